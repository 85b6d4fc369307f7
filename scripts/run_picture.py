#!/usr/bin/python3
"""Draws a run on one picture: the mesh coloured by plane from outside with the trajectory in it, and beside images of
the left camera what the mesh looks like from there.

scripts/run_picture.py RESULT [--sequence FOLDER] [--out RESULT/picture.png] [--stamps NS,NS,NS]

Colours say what Facet calls a plane (floor, table, ceiling, wall, other); faces on no plane are grey. Without the
sequence, or if its images cannot be read, only the view from outside is drawn. Needs numpy, matplotlib and Pillow.
"""

import argparse
import csv
import re
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Patch  # noqa: E402

from render_mesh import look_at, quaternion_to_matrix, rasterise, read_ply  # noqa: E402

LABELS = {"floor": (214, 176, 70), "table": (60, 170, 130), "ceiling": (190, 150, 210), "wall": (92, 148, 218),
          "other": (205, 92, 60)}
NO_PLANE = (178, 178, 178)
LEGEND_SHADE = 0.85  # of a typical face in the picture
OUTSIDE = (1000, 700)
NUM_VIEWS = 3


def labels_of(result):
    file = result / "planes.csv"
    if not file.exists():
        return {}
    with open(file, newline="") as stream:
        rows = [{(k or "").strip("# "): v for k, v in row.items()} for row in csv.DictReader(stream)]
    labels = {}
    for row in rows:
        labels[int(row["id"])] = row["label"]
        for merged in (row.get("absorbed") or "").split():
            labels[int(merged)] = row["label"]
    return labels


def colours_of(xyz, faces, ids, labels):
    """One colour for each label, lighter or darker from plane to plane, shaded by the normal."""
    a, b, c = (xyz[faces[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    shade = 0.6 + 0.4 * np.abs(normal @ np.array([0.36, 0.48, 0.8]))
    base = np.array([LABELS.get(labels.get(i, "other"), LABELS["other"]) if i >= 0 else NO_PLANE for i in ids], float)
    tone = np.where(ids >= 0, 0.92 + 0.04 * (ids * 7 % 5), 1.0)
    return np.clip(base * (shade * tone)[:, None], 0, 255).astype(np.uint8)


def read_camera(sequence):
    """Focal length, centre, size and T_BC of the left camera; None if there is no EuRoC calibration."""
    file = sequence / "cam0" / "sensor.yaml"
    if not file.exists():
        return None
    text = re.sub(r"#.*", "", file.read_text())
    numbers = lambda key: [float(x) for x in re.findall(  # noqa: E731
        r"[-+]?[0-9.]+(?:e[-+]?\d+)?", re.search(key + r"[^\[]*\[([^\]]*)\]", text, re.I).group(1))]
    try:
        fu, fv, cu, cv = numbers("intrinsics")
        return fu, np.array([cu, cv]), tuple(int(x) for x in numbers("resolution")), np.array(
            numbers("data")).reshape(4, 4)
    except (AttributeError, ValueError):
        return None


def image_files(sequence):
    """Stamp in ns -> file of the left camera."""
    with open(sequence / "cam0" / "data.csv") as stream:
        rows = [re.split(r"[,\s]+", line.strip()) for line in stream if line.strip() and not line.startswith("#")]
    return {int(row[0]): sequence / "cam0" / "data" / row[1] for row in rows}


def seen_from(pose, camera, mesh, colours):
    focal, centre, size, T_BC = camera
    T_WB = np.eye(4)
    T_WB[:3, :3] = quaternion_to_matrix(*pose[4:8])
    T_WB[:3, 3] = pose[1:4]
    T_CW = np.linalg.inv(T_WB @ T_BC)
    xyz, faces = mesh
    return rasterise(xyz @ T_CW[:3, :3].T + T_CW[:3, 3], faces, colours, focal, centre, size, False, True)


def outside_view(xyz, positions):
    """A place above one corner from which all of the mesh is in view: R, t, focal length."""
    low, high = np.percentile(xyz, 1, axis=0), np.percentile(xyz, 99, axis=0)
    middle, reach = (low + high) / 2, np.linalg.norm(high - low)
    # From the side of the flight: what lies behind the camera was never seen.
    towards = middle[:2] - positions[:, :2].mean(axis=0)
    angle = np.arctan2(-towards[1], -towards[0]) + 0.35 if np.linalg.norm(towards) > 0.05 * reach else 0.9
    eye = middle + 1.25 * reach * np.array([0.72 * np.cos(angle), 0.72 * np.sin(angle), 0.7])
    R, t = look_at(eye, middle)
    uv = (xyz @ R.T + t)[:, :2] / (xyz @ R.T + t)[:, 2:]
    spread = np.abs(np.percentile(uv, [1, 99], axis=0)).max(axis=0)
    return R, t, float((0.48 * np.array(OUTSIDE) / spread).min())


def draw_outside(ax, mesh, colours, positions):
    xyz, faces = mesh
    R, t, focal = outside_view(xyz, positions)
    ax.imshow(rasterise(xyz @ R.T + t, faces, colours, focal, np.array(OUTSIDE) / 2, OUTSIDE, False, False))
    path = positions @ R.T + t
    uv = focal * path[:, :2] / path[:, 2:] + np.array(OUTSIDE) / 2
    ax.plot(uv[:, 0], uv[:, 1], color="black", linewidth=1.6)
    ax.plot(*uv[0], "o", color="black", markersize=5)
    ax.set_xlim(0, OUTSIDE[0])
    ax.set_ylim(OUTSIDE[1], 0)
    return uv


def views_of(args, trajectory):
    """(image file, pose) of each moment that is shown."""
    sequence = args.sequence / "mav0" if (args.sequence / "mav0").is_dir() else args.sequence
    camera, files = read_camera(sequence), image_files(sequence)
    if camera is None:
        return None, []
    stamps = np.array(sorted(files))
    seconds = trajectory[:, 0]
    wanted = [int(s) for s in args.stamps.split(",")] if args.stamps else [
        int(s * 1e9) for s in seconds[(np.array([0.2, 0.5, 0.8]) * (len(seconds) - 1)).astype(int)]]
    views = []
    for stamp in wanted[:NUM_VIEWS]:
        file = files[int(stamps[np.abs(stamps - stamp).argmin()])]
        views.append((file, trajectory[np.abs(seconds - stamp * 1e-9).argmin()]))
    return camera, views


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", type=Path)
    parser.add_argument("--sequence", type=Path, help="the recording that the run was made from")
    parser.add_argument("--out", type=Path)
    parser.add_argument("--stamps", help="which camera images [ns]; default: three, spread over the run")
    args = parser.parse_args()
    file = args.result / "map.ply"
    if not file.exists():
        file = args.result / "mesh.ply"
    xyz, faces, _, ids = read_ply(file)
    trajectory = np.loadtxt(args.result / "trajectory.tum", ndmin=2)
    if not len(faces) or not len(trajectory):
        raise SystemExit(f"{args.result}: the run has no mesh or no trajectory")
    labels = labels_of(args.result)
    colours = colours_of(xyz, faces, ids, labels)
    camera, views = None, []
    if args.sequence:
        try:
            camera, views = views_of(args, trajectory)
        except OSError as error:
            print(f"run_picture: no camera images: {error}")
    rows = 4 if views else 3
    figure = plt.figure(figsize=(12, 8.4 + (5.6 if views else 0)), dpi=100)
    grid = figure.add_gridspec(rows + (1 if views else 0), NUM_VIEWS, hspace=0.04, wspace=0.03, left=0.01, right=0.99,
                               top=0.96, bottom=0.01)
    ax = figure.add_subplot(grid[:3, :])
    uv = draw_outside(ax, (xyz, faces), colours, trajectory[:, 1:4])
    found = [name for name in LABELS if name in {labels.get(i, "other") for i in set(ids[ids >= 0].tolist())}]
    handles = [Patch(color=LEGEND_SHADE * np.array(LABELS[name]) / 255, label=name) for name in found]
    handles += [Patch(color=LEGEND_SHADE * np.array(NO_PLANE) / 255, label="no plane"),
                plt.Line2D([], [], color="black", marker="o", markevery=[0], label="flight")]
    ax.legend(handles=handles, loc="lower left", ncols=4, frameon=False)
    ax.set_title("mesh of the whole run, coloured by plane; below: camera image, and the mesh from there"
                 if views else "mesh of the whole run, coloured by plane")
    axes = [ax]
    for k, (image, pose) in enumerate(views):
        number = str(k + 1)
        at = np.abs(trajectory[:, 0] - pose[0]).argmin()
        ax.annotate(number, uv[at], weight="bold", bbox={"boxstyle": "circle", "fc": "white"})
        for row, content in ((3, plt.imread(image)), (4, seen_from(pose, camera, (xyz, faces), colours))):
            small = figure.add_subplot(grid[row, k])
            small.imshow(content, cmap="gray")
            small.text(0.03, 0.95, number, transform=small.transAxes, va="top", weight="bold",
                       bbox={"boxstyle": "circle", "fc": "white"})
            axes.append(small)
    for each in axes:
        each.axis("off")
    out = args.out or args.result / "picture.png"
    figure.savefig(out)
    print(f"run_picture: wrote {out}")


if __name__ == "__main__":
    main()
