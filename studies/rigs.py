#!/usr/bin/python3
"""Question: do other lenses and resolutions along the same flight do as well as EuRoC's? Its rig with a lens like TUM
  VI's (equidistant, 512 x 512, 190 degrees along the diagonal), and with half and twice the pixels.
Command: studies/rigs.py [--program build/facet] [--out runs/rigs] [--rigs fisheye,half,double] [--starts 3]
  Planes and map of every rig are judged by what EuRoC's lens saw along the flight, so that all have the same truth.
Answer: docs/notebook/rigs.md.
Date: 2026-11-26.
"""

import argparse
import json
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "scripts"))
import debian_python  # noqa: E402, F401 (first: it may start another Python)

import numpy as np  # noqa: E402

FLIGHTS = {  # name: arguments of facet simulate
    "room": ["--scene", "room", "--trajectory", "gentle", "--seed", "61"],
    "office": ["--scene", "office", "--trajectory", "walk", "--seed", "62"],
    "corridor": ["--scene", "corridor", "--trajectory", "walk", "--seed", "63"],
}
DURATION_S = 30
# T_BS of EuRoC's cameras, resolution and intrinsics; the IMU is the body.
T_BC = [np.array([[0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975],
                  [0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768],
                  [-0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949], [0, 0, 0, 1]]),
        np.array([[0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556],
                  [0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024],
                  [-0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038], [0, 0, 0, 1]])]
PINHOLE = [([458.654, 457.296, 367.215, 248.375], [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]),
           ([457.587, 456.134, 379.999, 255.238], [-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05])]
# TUM VI's left lens at 512 x 512, and one that differs from it as its right one does: 77 degrees off the axis at the
# sides of the image, more than 100 in its corners.
FISHEYE = [([190.98, 190.97, 254.93, 256.90], [0.0035, 0.0007, -0.0021, 0.0002]),
           ([190.44, 190.43, 252.59, 254.95], [0.0034, 0.0018, -0.0027, 0.0003])]


def rescaled(lens, factor):
    """Pixel centres are whole numbers, so the corner of the image is at -0.5."""
    (fx, fy, cx, cy), distortion = lens
    return [fx * factor, fy * factor, (cx + 0.5) * factor - 0.5, (cy + 0.5) * factor - 0.5], distortion


RIGS = {
    "pinhole": (PINHOLE, "radtan", (752, 480)),
    "fisheye": (FISHEYE, "equidistant", (512, 512)),
    "half": ([rescaled(lens, 0.5) for lens in PINHOLE], "radtan", (376, 240)),
    "double": ([rescaled(lens, 2) for lens in PINHOLE], "radtan", (1504, 960)),
}


def write_calibration(rig, file):
    """A camchain of Kalibr's."""
    lenses, model, resolution = RIGS[rig]
    text = ""
    for camera, (intrinsics, distortion) in enumerate(lenses):
        T_CB = np.linalg.inv(T_BC[camera])
        text += f"cam{camera}:\n  camera_model: pinhole\n  intrinsics: {json.dumps(list(intrinsics))}\n"
        text += f"  distortion_model: {model}\n  distortion_coeffs: {json.dumps(list(distortion))}\n"
        text += f"  resolution: {json.dumps(list(resolution))}\n  T_cam_imu: {json.dumps(T_CB.tolist())}\n"
        if camera == 1:
            text += f"  T_cn_cnm1: {json.dumps((T_CB @ T_BC[0]).tolist())}\n"
    file.write_text(text, encoding="utf-8")


def call(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"rigs: {' '.join(map(str, words))}: {done.stderr.strip()[-400:]}")


def sequence_of(arguments, flight, rig):
    out = arguments.out / "sequences" / f"{flight}-{rig}"
    if not (out / "simulation.txt").exists():
        print(f"rendering {out.name}", file=sys.stderr, flush=True)
        shutil.rmtree(out, ignore_errors=True)
        out.parent.mkdir(parents=True, exist_ok=True)
        calibration = arguments.out / f"{rig}.yaml"
        write_calibration(rig, calibration)
        call(arguments.program, "simulate", *FLIGHTS[flight], "--duration", DURATION_S, "--calibration", calibration,
             "--threads", 1, "--quiet", "--set", "image.rays_per_pixel=3", "--set", "image.max_rays_per_pixel=6",
             "--set", "truth.points_per_m2=500", "--out", out)
    return out


def run(arguments, flight, rig, pipeline, start):
    out = arguments.out / "runs" / f"{flight}-{rig}-{pipeline}-{start}"
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    words = [w for text in arguments.set for w in ("--set", text)]
    call(arguments.program, "run", sequence_of(arguments, flight, rig), "--out", out, "--pipeline", pipeline, "--start",
         0.1 * start, "--quiet", *words)
    call(arguments.program, "evaluate", out, "--truth", sequence_of(arguments, flight, "pinhole"))
    evaluation = json.loads((out / "evaluation.json").read_text(encoding="utf-8"))
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    planes, surface = evaluation.get("planes", {}), evaluation.get("map", {})
    return {"ATE mm": 1e3 * evaluation["ate"]["rmse_m"], "plane recall": planes.get("recall", 0),
            "plane precision": planes.get("precision", 0), "map within 10 cm": surface.get("completeness_10cm", 0),
            "map accuracy mm": 1e3 * surface.get("accuracy_mean_m", 0),
            "CPU ms": summary["stages"]["total_without_decode"]["mean_ms"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/facet")
    parser.add_argument("--out", type=Path, default=Path("runs/rigs"))
    parser.add_argument("--rigs", default="fisheye,half,double", type=lambda text: text.split(","))
    parser.add_argument("--flights", default=",".join(FLIGHTS), type=lambda text: text.split(","))
    parser.add_argument("--pipelines", default="S,SPR", type=lambda text: text.split(","))
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--set", action="append", default=[], help="key.path=value, repeatable")
    arguments = parser.parse_args()
    for flight in arguments.flights:
        for pipeline in arguments.pipelines:
            for rig in ["pinhole", *arguments.rigs]:
                runs = [run(arguments, flight, rig, pipeline, start) for start in range(arguments.starts)]
                row = {key: statistics.median(r[key] for r in runs) for key in runs[0]}
                print(f"{flight:10} {pipeline:4} {rig:9}" + "".join(f"{key} {value:.2f}  " for key, value in row.items()),
                      flush=True)


if __name__ == "__main__":
    main()
