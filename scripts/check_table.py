#!/usr/bin/python3
"""Plants the defects of docs/check.md in recordings, at their magnitude and at half of it, and prints what facet check says.

  check_table.py SEQUENCE ...                       all of them
  check_table.py SEQUENCE ... --only 'jitter|gap'   those whose finding or fault matches
  check_table.py --good SEQUENCE ...                false alarms: recordings as they are, no defects

One row is a defect: for each recording, the mark of the magnitude and, behind a slash, that of half of it. Marks:
+ named, - not named, r refused as damaged beyond use, with a message; behind it, in brackets, what else was named.
Recordings are cut to their first seconds (--length).
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ALL = "at=0,length=1e6"  # images of the whole recording

# finding, fault at its magnitude, fault at half of it (None: there is no half)
DEFECTS = [
    ("stamps_backward", "disordered:imu=1,share=0.01", "disordered:imu=1,share=0.005"),
    ("stamps_backward", "disordered:imu=0,share=0.01", "disordered:imu=0,share=0.005"),
    ("stamps_repeated", "stamps_repeated:imu=1,share=0.01", "stamps_repeated:imu=1,share=0.005"),
    ("stamps_repeated", "stamps_repeated:imu=0,share=0.01", "stamps_repeated:imu=0,share=0.005"),
    ("image_gap", "no_camera:length=0.5,camera=2", "no_camera:length=0.25,camera=2"),
    ("imu_gap", "imu_gap:length=0.1", "imu_gap:length=0.05"),
    ("images_dropped", "dropped:share=0.1", "dropped:share=0.05"),
    ("imu_dropped", "imu_dropped:share=0.05", "imu_dropped:share=0.025"),
    ("image_jitter", "jitter:imu=0,ms=5", "jitter:imu=0,ms=2.5"),
    ("imu_jitter", "jitter:imu=1,ms=1", "jitter:imu=1,ms=0.5"),
    ("images_slow", "thinned:imu=0,every=3", "thinned:imu=0,every=2"),
    ("imu_slow", "thinned:imu=1,every=4", "thinned:imu=1,every=2"),
    ("right_missing", "right_dropped:share=0.1", "right_dropped:share=0.05"),
    ("right_stamps", "right_stamped_late:ms=3", "right_stamped_late:ms=1.5"),
    ("imu_missing", "imu_late:length=1", "imu_late:length=0.5"),
    ("images_repeated", "repeated:share=0.05", "repeated:share=0.025"),
    ("clock_jump", "clock_jump:at=5,ms=30", "clock_jump:at=5,ms=15"),
    ("too_short", "cut:length=4.9", "cut:length=9.8"),
    ("gyroscope", "imu_degrees", None),
    ("gyroscope", "imu_negated:axis=0", None),
    ("gyroscope", "imu_negated:axis=1", None),
    ("gyroscope", "imu_negated:axis=2,gyro_only=1", None),
    ("gyroscope|camera_imu_rotation", "inverted_T_BS", None),
    ("gyroscope|camera_imu_rotation", "identity_T_BS", None),
    ("gyro_scale", "gyro_scaled:percent=5", "gyro_scaled:percent=2.5"),
    ("gyro_scale", "focal:percent=-5", "focal:percent=-2.5"),
    ("gyro_bias", "gyro_biased:axis=0,bias=0.2", "gyro_biased:axis=0,bias=0.1"),
    ("gyro_bias", "gyro_biased:axis=2,bias=-0.2", "gyro_biased:axis=2,bias=-0.1"),
    ("accel_scale", "accel_scaled:percent=10", "accel_scaled:percent=5"),
    ("accel_scale", "accel_scaled:percent=-10", "accel_scaled:percent=-5"),
    ("accel_scale", "accel_scaled:percent=-89.806", None),
    ("no_gravity|accel_scale", "no_gravity:share=1", "no_gravity:share=0.5"),
    ("accel_axes", "accel_exchanged:axis=2", None),
    ("accel_axes", "accel_exchanged:axis=1", None),
    ("imu_saturated", "imu_saturated:share=0.01", "imu_saturated:share=0.005"),
    ("imu_dead_axis", "imu_dead_axis:axis=1", None),
    ("imu_dead_axis", "imu_dead_axis:axis=0,of_gyro=1", None),
    ("imu_frozen", "imu_frozen:length=0.3", "imu_frozen:length=0.15"),
    ("imu_glitch", "imu_glitch:gyro=35", "imu_glitch:gyro=17.5"),
    ("gyro_density", "densities:gyro=100,accel=1", "densities:gyro=10,accel=1"),
    ("gyro_density", "densities:gyro=0.01,accel=1", "densities:gyro=0.1,accel=1"),
    ("accel_density", "densities:gyro=1,accel=100", "densities:gyro=1,accel=10"),
    ("accel_density", "densities:gyro=1,accel=0.01", "densities:gyro=1,accel=0.1"),
    ("cameras_swapped", "swapped", None),
    ("camera_imu_rotation", "cameras_turned:axis=0,deg=3", "cameras_turned:axis=0,deg=1.5"),
    ("camera_imu_rotation", "cameras_turned:axis=1,deg=3", "cameras_turned:axis=1,deg=1.5"),
    ("camera_imu_rotation", "cameras_turned:axis=2,deg=3", "cameras_turned:axis=2,deg=1.5"),
    ("time_offset", "imu_early:ms=10", "imu_early:ms=5"),
    ("time_offset", "imu_early:ms=-10", "imu_early:ms=-5"),
    ("right_turned", "right_turned:axis=0,deg=0.2", "right_turned:axis=0,deg=0.1"),
    ("right_turned", "right_turned:axis=2,deg=0.2", "right_turned:axis=2,deg=0.1"),
    ("stereo_misfit", "no_distortion:share=1", "no_distortion:share=0.5"),
    ("right_late", "right_late:images=1", None),
    ("too_dark", f"underexposed:{ALL},mean=12", f"underexposed:{ALL},mean=24"),
    ("too_bright", f"clipped:{ALL},share=0.3", f"clipped:{ALL},share=0.15"),
    ("flicker", "flicker:change=0.2", "flicker:change=0.1"),
    ("unequal_brightness", f"overexposed:{ALL},camera=1,gain=0.4", f"overexposed:{ALL},camera=1,gain=0.63"),
    ("blur", f"blurred:{ALL},sigma=3", f"blurred:{ALL},sigma=1.5"),
    ("image_noise", f"noisy:{ALL},sigma=15", f"noisy:{ALL},sigma=7.5"),
    ("no_texture", f"faded:{ALL},contrast=0.03", f"faded:{ALL},contrast=0.06"),
    ("covered", f"covered:{ALL},share=0.3", f"covered:{ALL},share=0.15"),
    ("fixed_pattern", f"dots:{ALL},grey=40", f"dots:{ALL},grey=20"),
    ("standing_still", "still:share=0.9", "still:share=0.45"),
]


def check(program, sequence, folder):
    """Names of the findings, or None where the recording was refused, and the message."""
    report = Path(folder) / "check.json"
    report.unlink(missing_ok=True)
    done = subprocess.run([program, "check", sequence, "--quiet", "--json", report], capture_output=True, text=True,
                          check=False)
    if not report.exists():
        return None, done.stderr.strip()
    names = [finding["name"] for finding in json.loads(report.read_text())["findings"]]
    if done.returncode != (3 if names else 0):
        sys.exit(f"{sequence}: exit code {done.returncode}: {done.stderr}")
    return names, done.stdout


def plant(planter, sequence, faults, out):
    options = [text for fault in faults for text in ("--fault", fault)]
    subprocess.run([planter, "simulate", "--quiet", "--of", sequence, *options, "--out", out], check=True)


def mark(wanted, names):
    if names is None:
        return "r"
    others = [name for name in names if name not in wanted]
    return ("+" if len(others) < len(names) else "-") + (f"({','.join(others)})" if others else "")


def table(arguments, folder):
    chosen = [d for d in DEFECTS if any(re.search(arguments.only, text) for text in d[:2])]
    num_hits = num_planted = 0
    print(f"{'finding':22s} {'fault':38s}" + "".join(f" | {s.name[:24]:24s}" for s in arguments.sequences))
    for name, at, half in chosen:
        wanted = name.split("|")
        cells = []
        for sequence in arguments.sequences:
            marks = []
            for fault in (at, half):
                if fault is None or (fault == half and arguments.whole):
                    continue
                with tempfile.TemporaryDirectory(dir=folder) as out:
                    damaged = Path(out) / "damaged"
                    plant(arguments.planter, sequence, [f"cut:length={arguments.length}", fault], damaged)
                    names, text = check(arguments.program, damaged, out)
                    marks.append(mark(wanted, names))
                    if arguments.verbose:
                        print(f"--- {sequence.name} {fault}\n{text}")
            num_planted += 1
            num_hits += marks[0][0] in "+r"
            cells.append("/".join(marks))
        print(f"{name:22s} {at:38s}" + "".join(f" | {cell:24s}" for cell in cells), flush=True)
    print(f"{num_hits} of {num_planted} named or refused at their magnitude")


def good(arguments, folder):
    num_alarms = 0
    for sequence in arguments.sequences:
        names, text = check(arguments.program, sequence, folder)
        print(f"{sequence.name:32s} {'nothing' if names == [] else names}", flush=True)
        if names != [] or arguments.verbose:
            print(text)
        num_alarms += names != []
    print(f"{num_alarms} of {len(arguments.sequences)} recordings have a finding")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="+", type=Path)
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--planter", default=str(ROOT / "build" / "facet"), help="program that knows the faults")
    parser.add_argument("--only", default="", metavar="REGEX", help="defects whose finding or fault matches")
    parser.add_argument("--length", type=float, default=16, help="seconds that are kept of each recording")
    parser.add_argument("--whole", action="store_true", help="without the halves")
    parser.add_argument("--good", action="store_true")
    parser.add_argument("--verbose", action="store_true", help="print every report")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        (good if arguments.good else table)(arguments, folder)


if __name__ == "__main__":
    main()
