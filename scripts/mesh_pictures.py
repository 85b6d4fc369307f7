#!/usr/bin/python3
"""The pictures of docs/mesh.md, from runs of pipeline S.

scripts/mesh_pictures.py [--facet build/facet] [--sequence ../shared/data/rendered_room]
                         [--pallet ../shared/data/euroc_mh01_handheld] [--out docs/mesh]
mesh_filters.png   one keyframe; in red what comes back when one test is switched off
mesh_views.png     camera image, horizon mesh and map at three keyframes, coloured by normal
pallet.png         the horizon mesh over a recorded image of a pallet, and from its side
map_outside.png    the map from above, grey and by distance to the true surface
Needs numpy, scipy and Pillow (python3-scipy, python3-pil).
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np
from PIL import Image, ImageDraw

import render_mesh as render

STAMPS = ("1403715294700000000", "1403715298700000000", "1403715306700000000")
PALLET_STAMP = 1403636596763555584  # one of those in testdata/mh01_pallet.csv
SIZE, SCALE = (752, 480), 0.5
TESTS = {
    "all tests": ["plane_rescue.enabled=false"],
    "uncertain depth": ["faces.max_depth_sigma=1000"],
    "size": ["faces.max_side_m=1000", "faces.max_side_per_depth=1000", "support.max_side_per_depth=1000"],
    "side ratio, angle": ["faces.min_side_ratio=0", "faces.min_angle_deg=0"],
    "elongation": ["faces.min_elongation=0"],
    "grazing angle": ["faces.max_grazing_deg=90"],
    "with plane rescue": ["plane_rescue.enabled=true"],
}


def run(facet, sequence, out, duration, settings, every=10):
    command = [facet, "run", sequence, "--out", out, "--quiet", "--pipeline", "S", "--duration", str(duration)]
    command += ["--mesh-every", str(every)]
    for setting in settings:
        command += ["--set", "mesh." + setting]
    subprocess.run(command, check=True)


def pose_at(folder, stamp):
    seconds = stamp[:-9] + "." + stamp[-9:]
    for line in (folder / "trajectory.tum").read_text().splitlines():
        if line.startswith(seconds):
            return line
    raise SystemExit(f"no pose at {seconds}")


def camera_image(sequence, stamp):
    return Image.open(Path(sequence) / "mav0/cam0/data" / (stamp + ".jpg")).convert("RGB")


def small(image, title):
    if not isinstance(image, Image.Image):
        image = Image.fromarray(image)
    image = image.resize((int(SIZE[0] * SCALE), int(SIZE[1] * SCALE)), Image.LANCZOS)
    ImageDraw.Draw(image).text((6, 4), title, fill=(200, 0, 0))
    return image


def sheet(images, columns, path):
    width, height = images[0].size
    rows = (len(images) + columns - 1) // columns
    page = Image.new("RGB", (columns * width, rows * height), "white")
    for i, image in enumerate(images):
        page.paste(image, (i % columns * width, i // columns * height))
    page = page.resize((min(page.width, 900), page.height * min(page.width, 900) // page.width), Image.LANCZOS)
    page.quantize(64).save(path, optimize=True)


def draw(xyz, faces, colours, pose, edges=True):
    R, t = render.camera_of(pose)
    return render.rasterise(xyz @ R.T + t, faces, colours, 458, np.array(SIZE) / 2, SIZE, edges, False)


def keys_of(xyz, faces):
    return {tuple(sorted(map(tuple, np.round(xyz[f], 4)))) for f in faces}


def normal_colours(xyz, faces):
    a, b, c = (xyz[faces[:, i]] for i in range(3))
    n = np.cross(b - a, c - a)
    return (127.5 + 127.5 * n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-12)).astype(np.uint8)


def filters(args, work):
    stamp = STAMPS[1]
    images, kept = [small(camera_image(args.sequence, stamp), "left image")], None
    for name, settings in TESTS.items():
        folder = work / name.replace(" ", "_")
        run(args.facet, args.sequence, folder, 11, ["horizon_s=0", "plane_rescue.enabled=false"] + settings)
        xyz, faces, _, _ = render.read_ply(folder / "meshes" / (stamp + ".ply"))
        if kept is None:
            kept = keys_of(xyz, faces)
        extra = [tuple(sorted(map(tuple, np.round(xyz[f], 4)))) not in kept for f in faces]
        colours = np.where(np.array(extra)[:, None], (225, 90, 70), (185, 190, 195)).astype(np.uint8)
        title = name if " " in name and name.split()[0] in ("all", "with") else "without: " + name
        title += f" (+{sum(extra)})" if any(extra) else ""
        images.append(small(draw(xyz, faces, colours, pose_at(folder, stamp)), title))
    sheet(images, 4, args.out / "mesh_filters.png")


def views(args, folder):
    images = []
    whole, whole_faces, _, _ = render.read_ply(folder / "map.ply")
    for stamp in STAMPS:
        pose = pose_at(folder, stamp)
        xyz, faces, _, _ = render.read_ply(folder / "meshes" / (stamp + ".ply"))
        images += [small(camera_image(args.sequence, stamp), "left image"),
                   small(draw(xyz, faces, normal_colours(xyz, faces), pose), "horizon mesh"),
                   small(draw(whole, whole_faces, normal_colours(whole, whole_faces), pose, False), "map")]
    sheet(images, 3, args.out / "mesh_views.png")


def align(folder, sequence):
    """T_GW by rotation and translation, from positions."""
    poses = np.loadtxt(folder / "trajectory.tum")
    truth = np.loadtxt(Path(sequence) / "mav0/state_groundtruth_estimate0/data.csv", delimiter=",", comments="#")
    nearest = np.clip(np.searchsorted(truth[:, 0], poses[:, 0] * 1e9 - 5e5), 0, len(truth) - 1)
    p, q = poses[:, 1:4], truth[nearest, 1:4]
    u, _, vt = np.linalg.svd((q - q.mean(0)).T @ (p - p.mean(0)))
    R = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return R, q.mean(0) - R @ p.mean(0)


def outside(args, folder):
    from scipy.spatial import cKDTree
    R, t = align(folder, args.sequence)
    xyz, faces, grey, _ = render.read_ply(folder / "map.ply")
    xyz = xyz @ R.T + t
    truth = render.read_ply(Path(args.sequence) / "mav0/pointcloud0/data.ply")[0]
    error = np.clip(cKDTree(truth).query(xyz[faces].mean(1))[0] / 0.10, 0, 1)[:, None]
    by_error = (255 * np.hstack([error, 1 - error, 0.2 + 0 * error])).astype(np.uint8)
    tone = np.repeat(grey[faces].mean(axis=1)[:, None], 3, axis=1).astype(np.uint8)
    eye, target = truth.mean(0) + np.array([-7.5, -5.5, 7.5]), truth.mean(0)
    Rc, tc = render.look_at(eye, target)
    images = []
    for colours, title in ((tone, "map, intensity"), (by_error, "map, distance to the true surface: green 0, red 10 cm and more")):
        picture = render.rasterise(xyz @ Rc.T + tc, faces, colours, 900, np.array(SIZE) / 2, SIZE, False, True)
        images.append(small(picture, title))
    sheet(images, 2, args.out / "map_outside.png")


def project(sequence, p_C):
    """Pixels of the recorded, distorted image."""
    text = (Path(sequence) / "mav0/cam0/sensor.yaml").read_text()
    numbers = [re.search(key + r":\s*\[(.*?)\]", text).group(1) for key in ("intrinsics", "distortion_coefficients")]
    (fu, fv, cu, cv), (k1, k2, p1, p2) = (map(float, n.split(",")) for n in numbers)
    x, y = (p_C[:, :2] / p_C[:, 2:]).T
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    return np.stack([fu * u + cu, fv * v + cv], axis=1)


def overlay(image, px, p_C, faces, colours):
    """Faces over the image, the farthest first."""
    layer = Image.new("RGBA", image.size)
    pen = ImageDraw.Draw(layer)
    for f in np.argsort(-p_C[faces][:, :, 2].mean(1)):
        corners = [tuple(px[i]) for i in faces[f]]
        pen.polygon(corners, fill=(*map(int, colours[f]), 90), outline=(20, 20, 20, 200))
    return Image.alpha_composite(image.convert("RGBA"), layer).convert("RGB")


def pallet(args, folder):
    run(args.facet, args.pallet, folder, 14, [], every=1)
    stamp = min((p.stem for p in (folder / "meshes").iterdir()), key=lambda s: abs(int(s) - PALLET_STAMP))
    R, t = render.camera_of(pose_at(folder, stamp))
    xyz, faces, _, _ = render.read_ply(folder / "meshes" / (stamp + ".ply"))
    p_C = xyz @ R.T + t
    faces = faces[(p_C[faces][:, :, 2] > 0.1).all(1) & (np.abs(p_C[faces][:, :, :2] / p_C[faces][:, :, 2:]) < 1).all((1, 2))]
    colours = normal_colours(xyz, faces)
    image = Image.open(Path(args.pallet) / "mav0/cam0/data" / (stamp + ".webp")).convert("RGB")
    target = np.median(xyz[faces[(p_C[faces][:, :, 2] < 1).all(1)]].mean(1), axis=0)
    Rc, tc = render.look_at(target + np.array([-0.5, 0, 0.9]), target)
    side = render.rasterise(xyz @ Rc.T + tc, faces, colours, 458, np.array(SIZE) / 2, SIZE, True, False)
    images = [small(overlay(image, project(args.pallet, p_C), p_C, faces, colours), "over the left image"),
              small(side, "from above")]
    sheet(images, 2, args.out / "pallet.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--facet", default="build/facet")
    parser.add_argument("--sequence", default="../shared/data/rendered_room")
    parser.add_argument("--pallet", default="../shared/data/euroc_mh01_handheld")
    parser.add_argument("--out", type=Path, default=Path("docs/mesh"))
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work) / "run"
        run(args.facet, args.sequence, folder, 1000, [])
        views(args, folder)
        outside(args, folder)
        filters(args, Path(work))
        pallet(args, Path(work) / "pallet")


if __name__ == "__main__":
    main()
