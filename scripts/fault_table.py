#!/usr/bin/python3
"""Plants every fault in recordings, runs Facet on them, and prints what became of it.

  fault_table.py                               every sequence of $FACET_DATA_DIR or ../shared/data that has images
  fault_table.py SEQUENCE ... --only 'frozen|object' --starts 3
  fault_table.py --program other/facet         another program, on the same damaged sequences
  fault_table.py --truth NAME=FILE             another ground truth of a sequence (studies/truth_lag.py makes one)

A row is a fault, a column group a sequence: the ATE in mm (median over the starts; with segments, the largest of
them), the ratio to the clean run's, the position NEES, the exit code, and what the run says of it: d for degraded
frames, l for lost ones, s for another segment, w for a warning. Starts are 0, 0.2, 0.4 s.
"""

import argparse
import csv
import json
import os
import re
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

FAULTS = [
    "imu_glitch:gyro=35", "imu_glitch:gyro=100,axis=2", "imu_glitch:gyro=0,accel=160", "imu_glitch:samples=3,gyro=35",
    "imu_gap:length=0.1", "imu_gap:length=0.3", "imu_gap:length=0.5", "imu_clip:gyro=0.6", "imu_frozen:length=0.3",
    "frozen:length=0.06", "frozen:length=0.5", "frozen:length=2", "repeated:share=0.1", "older:share=0.1",
    "exchanged:share=0.1", "frozen:length=2,camera=0", "frozen:length=2,camera=1", "dropped:share=0.3",
    "no_camera:length=3,camera=1", "no_camera:length=1,camera=2",
    "pause:length=1", "pause:length=3", "black:length=1", "black:length=7", "overexposed:length=2",
    "covered:length=3", "noisy:length=3",
    "object:share=0.2", "object:share=0.3", "object:share=0.3,depth=0.7,crossing=1.5",
    "knocked:deg=0.3", "knocked:deg=0.3,axis=1", "knocked:deg=0.3,axis=2", "knocked:deg=1.2,axis=1",
    "right_turned:axis=0", "right_turned:axis=1", "right_turned:axis=2", "focal:percent=1", "focal:percent=-1",
    "baseline:percent=2", "baseline:percent=100", "imu_early:ms=10", "imu_early:ms=20",
    "imu_degrees", "imu_negated:axis=0", "imu_negated:axis=1", "imu_negated:axis=2",
    "imu_negated:axis=0,accel_only=1", "imu_negated:axis=1,accel_only=1", "imu_negated:axis=2,accel_only=1",
    "inverted_T_BS", "swapped",
]


def sequences_of(arguments):
    if arguments.sequences:
        return arguments.sequences
    data = Path(os.environ.get("FACET_DATA_DIR", ROOT.parent / "shared" / "data"))
    return sorted(p.parents[2] for p in data.glob("*/mav0/cam0/data.csv"))


def run(program, sequence, truth, start, out):
    """Figures of one run; None where there are none."""
    done = subprocess.run([program, "run", sequence, "--out", out, "--start", str(start), "--quiet"],
                          capture_output=True, text=True, check=False)
    row = {"exit": done.returncode, "ate": None, "nees": None, "signs": ""}
    states = Path(out) / "states.csv"
    if not states.exists():
        return row
    with open(states, newline="") as stream:
        reader = csv.DictReader(stream)
        lines = [{(k or "").strip("# "): v for k, v in line.items()} for line in reader]
    statuses = {line.get("status") for line in lines}
    segments = {line.get("segment") for line in lines if line.get("segment")}
    summary = json.loads((Path(out) / "summary.json").read_text())
    row["signs"] = ("d" if "degraded" in statuses else "") + ("l" if "lost" in statuses else "") + \
        (f"s{len(segments)}" if len(segments) > 1 else "") + ("w" if summary.get("warnings") else "")
    subprocess.run([program, "evaluate", out, "--truth", truth, "--parts", "consistency"], capture_output=True,
                   check=False)
    evaluation = Path(out) / "evaluation.json"
    if evaluation.exists():
        figures = json.loads(evaluation.read_text())
        row["ate"] = 1e3 * figures["ate"]["rmse_m"]
        if figures.get("segments"):
            row["ate"] = 1e3 * max(s["ate"]["rmse_m"] for s in figures["segments"])
        row["nees"] = figures.get("consistency", {}).get("position", {}).get("nees")
    return row


def median(values):
    values = [v for v in values if v is not None]
    return statistics.median(values) if values else None


def text_of(value, form):
    return "-" if value is None else format(value, form)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="*", type=Path)
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--planter", default=str(ROOT / "build" / "facet"), help="program that knows the faults")
    parser.add_argument("--only", default="", metavar="REGEX", help="faults that match")
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--truth", action="append", default=[], metavar="NAME=FILE", type=lambda text: text.split("=", 1))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    sequences = sequences_of(arguments)
    faults = [f for f in FAULTS if re.search(arguments.only, f)]
    truths = dict(arguments.truth)
    starts = [0.2 * i for i in range(arguments.starts)]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(arguments.jobs) as pool:

        def all_starts(fault, sequence, number):
            damaged = sequence
            if fault:
                damaged = Path(folder) / f"{number}"
                subprocess.run([arguments.planter, "simulate", "--quiet", "--of", sequence, "--fault", fault, "--out",
                                damaged], check=True)
            truth = truths.get(sequence.name, damaged)
            return [run(arguments.program, damaged, truth, start, Path(folder) / f"{number}-{start}")
                    for start in starts]

        def print_row(name, groups, clean):
            text = f"{name:42s}"
            for group, reference in zip(groups, clean):
                ate, nees = median(r["ate"] for r in group), median(r["nees"] for r in group)
                ratio = ate / reference if ate is not None and reference else None
                exits = ",".join(sorted({str(r["exit"]) for r in group}))
                signs = "".join(sorted(set("".join(r["signs"] for r in group))))
                text += f" | {text_of(ate, '9.1f')} {text_of(ratio, '7.2f')} {text_of(nees, '8.2f')} {exits:>4s} {signs:6s}"
            print(text, flush=True)

        print(f"{'fault':42s}" + "".join(f" | {s.name[:20]:>20s}: ATE, ratio, NEES" for s in sequences))
        futures = {}
        for f, fault in enumerate(["", *faults]):
            for s, sequence in enumerate(sequences):
                futures[f, s] = pool.submit(all_starts, fault, sequence, f"{f}-{s}")
        clean = [median(r["ate"] for r in futures[0, s].result()) for s in range(len(sequences))]
        for f, fault in enumerate(["", *faults]):
            print_row(fault or "clean", [futures[f, s].result() for s in range(len(sequences))], clean)


if __name__ == "__main__":
    main()
