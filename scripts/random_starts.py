#!/usr/bin/python3
"""Starts Facet at many random moments for a few seconds each, and counts late, wrong and alarmed starts.

  random_starts.py                          1000 starts over all recordings and simulated flights
  random_starts.py --count 100 --only room  fewer, of the sequences whose name matches
  random_starts.py --program other/facet --csv starts.csv
  random_starts.py --sequences FOLDER ...   these instead, e.g. those of `scripts/suite.py make`

Sequences: those of $FACET_DATA_DIR or ../shared/data that have images, and the flights of start_flights.py, which are
simulated into --cache once. Moments are drawn with a fixed seed, the same number in every sequence. A start is late
without a pose within 0.5 s of its first image, and wrong if it is off by more than 0.5 m or 10 deg after 5 s or lost by
then, where position and heading of the first pose are those of the truth; its tilt is not aligned. Kinds of motion are
those of the first half second: rest (below 0.05 m/s and 0.1 rad/s), turning (above 0.5 rad/s), moving. Alarms are
warnings, and frames after the first pose whose status is not ok. Exit code 1 if the targets are missed.
"""

import argparse
import csv
import json
import math
import os
import random
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import naive_ate  # noqa: E402
import start_flights  # noqa: E402
import trajectories  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
MAX_INIT_S, MIN_SHARE = 0.5, 0.995
MAX_OFF_M, MAX_OFF_DEG = 0.5, 10
BEGIN_S = 0.5  # of a start, for its kind of motion


@dataclass
class Start:
    """One start and what became of it."""

    sequence: Path
    at: float
    motion: str
    exit_code: int = 0
    init_s: float = None
    off_m: float = math.nan
    off_deg: float = math.nan
    tilt_deg: float = None  # of the first pose
    statuses: Counter = field(default_factory=Counter)
    warnings: list = field(default_factory=list)

    def is_late(self):
        return self.init_s is None or self.init_s > MAX_INIT_S + 1e-3

    def is_wrong(self):
        """Also if it has no pose at the end any more."""
        if self.init_s is None:
            return False
        return self.exit_code != 0 or not (self.off_m <= MAX_OFF_M and self.off_deg <= MAX_OFF_DEG)

    def has_alarm(self):
        return bool(self.statuses or self.warnings)


class Sequence:
    """A folder, its length, and its truth."""

    def __init__(self, folder):
        self.folder = folder
        mav0 = folder / "mav0" if (folder / "mav0").is_dir() else folder
        with open(mav0 / "cam0" / "data.csv", encoding="utf-8") as stream:
            stamps = [int(line.split(",")[0]) for line in stream if line[:1].isdigit()]
        self.first, self.length_s = stamps[0], 1e-9 * (stamps[-1] - stamps[0])
        self.truth = naive_ate.read_trajectory(trajectories.truth_file(folder))

    def motion_at(self, at):
        """Kind of motion of the first moments after `at` seconds."""
        t = np.array(self.truth[0])
        begin, end = np.searchsorted(t, [self.first + 1e9 * at, self.first + 1e9 * (at + BEGIN_S)])
        if end - begin < 2:
            return "unknown"
        p, q = self.truth[1][begin:end], self.truth[2][begin:end]
        duration = 1e-9 * (t[end - 1] - t[begin])
        stride = max(1, (end - begin) // 10)
        speed = np.linalg.norm(np.diff(p[::stride], axis=0), axis=1).sum() / duration
        cosines = np.minimum(1, np.abs(np.sum(q[:-stride:stride] * q[stride::stride], axis=1)))
        rate = 2 * np.arccos(cosines).sum() / duration
        if rate > 0.5:
            return "turning"
        return "rest" if speed < 0.05 and rate < 0.1 else "moving"


def angle_deg(R):
    return math.degrees(math.acos(min(1, max(-1, (np.trace(R) - 1) / 2))))


def heading(R):
    """The turn about z that is nearest to R."""
    angle = math.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1])
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def measure_errors(trajectory, truth, start):
    """Error of the last pose when the first one has the truth's position and heading, and its tilt."""
    rows = naive_ate.associate(naive_ate.read_trajectory(trajectory), truth)
    if not rows:
        return
    _, p_first, q_first, g_first, h_first = rows[0]
    _, p, q, g, h = rows[-1]
    difference = naive_ate.rotation(h_first) @ naive_ate.rotation(q_first).T
    R = heading(difference)
    start.tilt_deg = angle_deg(R.T @ difference)
    start.off_m = float(np.linalg.norm(R @ (p - p_first) + g_first - g))
    start.off_deg = angle_deg(naive_ate.rotation(h).T @ R @ naive_ate.rotation(q))


def execute(start, sequence, program, duration, extra):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "run"
        done = subprocess.run([program, "run", str(start.sequence), "--out", str(out), "--start", f"{start.at:.2f}",
                               "--duration", f"{duration:g}", "--quiet", *extra],
                              capture_output=True, text=True, check=False)
        start.exit_code = done.returncode
        if not (out / "summary.json").exists():
            start.warnings.append(done.stderr.strip()[-200:])
            return
        summary = json.loads((out / "summary.json").read_text())
        start.init_s = summary.get("init_s")
        start.warnings += summary.get("warnings", [])
        with open(out / "states.csv", encoding="utf-8") as stream:
            states = [(row["status"], row["reason"]) for row in csv.DictReader(stream)]
        begun = next((i for i, state in enumerate(states) if state[0] != "initialising"), len(states))
        start.statuses.update(f"{status}: {reason}" for status, reason in states[begun:] if status != "ok")
        measure_errors(out / "trajectory.tum", sequence.truth, start)


def draw_starts(sequences, count, duration, seed):
    rng = random.Random(seed)
    starts = []
    for i in range(count):
        sequence = sequences[i % len(sequences)]
        at = round(rng.uniform(0, max(0, sequence.length_s - duration)), 2)
        starts.append((sequence, Start(sequence.folder, at, sequence.motion_at(at))))
    return starts


def percentile(values, share):
    values = sorted(v for v in values if v is not None and not math.isnan(v))
    return values[min(len(values) - 1, int(share * len(values)))] if values else math.nan


def print_group(name, starts):
    in_time = sum(not s.is_late() for s in starts)
    init_s, off_m = [s.init_s for s in starts], [s.off_m for s in starts]
    off_deg, tilt_deg = [s.off_deg for s in starts], [s.tilt_deg for s in starts]
    print(f"{name:24s} {len(starts):5d} {100 * in_time / len(starts):7.1f} {percentile(init_s, 0.5):6.2f} "
          f"{max((s for s in init_s if s is not None), default=math.nan):6.2f} {sum(s.is_wrong() for s in starts):5d} "
          f"{1e3 * percentile(off_m, 0.5):8.1f} {1e3 * percentile(off_m, 0.99):8.1f} {percentile(off_deg, 0.5):7.2f} "
          f"{percentile(off_deg, 0.99):7.2f} {percentile(tilt_deg, 0.99):7.2f} {sum(s.has_alarm() for s in starts):6d}")


def print_tables(starts):
    print(f"{'':24s} {'':>5s} {'in time':>7s} {'first pose [s]':>13s} {'':>5s} {'off [mm]':>17s} {'off [deg]':>15s} "
          f"{'tilt':>7s}")
    print(f"{'':24s} {'count':>5s} {'[%]':>7s} {'median':>6s} {'max':>6s} {'wrong':>5s} {'median':>8s} {'99 %':>8s} "
          f"{'median':>7s} {'99 %':>7s} {'99 %':>7s} {'alarms':>6s}")
    for motion in sorted({s.motion for s in starts}):
        print_group(motion, [s for s in starts if s.motion == motion])
    for folder in dict.fromkeys(s.sequence for s in starts):
        print_group(folder.name, [s for s in starts if s.sequence == folder])
    print_group("all", starts)


def print_worst(starts, number):
    def line(s):
        text = ", ".join([f"{n} x {reason}" for reason, n in s.statuses.items()] + s.warnings)
        init = "never" if s.init_s is None else f"{s.init_s:.2f} s"
        off = "-" if math.isnan(s.off_m) else f"{1e3 * s.off_m:.0f} mm, {s.off_deg:.2f} deg"
        tilt = "-" if s.tilt_deg is None else f"{s.tilt_deg:.2f}"
        what = f"first pose {init}, tilt {tilt}, off {off}; {text}"
        print(f"  {s.sequence.name} --start {s.at:.2f} ({s.motion}): {what}"[:400])

    late = [s for s in starts if s.is_late()]
    print(f"\nlate: {len(late)}")
    for s in sorted(late, key=lambda s: -(s.init_s or math.inf))[:3 * number]:
        line(s)
    print("\nfarthest off:")
    for s in sorted(starts, key=lambda s: 0 if math.isnan(s.off_m) else -s.off_m)[:number]:
        line(s)
    print("\nturned most:")
    for s in sorted(starts, key=lambda s: 0 if math.isnan(s.off_deg) else -s.off_deg)[:number]:
        line(s)
    alarms = Counter()
    for s in starts:
        alarms.update(set(s.statuses) | {re.sub(r"\d+", "N", w) for w in s.warnings})
    print("\nalarms, by number of starts:")
    for text, number_of_starts in alarms.most_common():
        print(f"  {number_of_starts:5d}  {text[:150]}")


def write_csv(starts, file):
    with open(file, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["sequence", "start", "motion", "exit", "init_s", "off_m", "off_deg", "tilt_deg", "alarms"])
        for s in starts:
            alarms = "; ".join([f"{n} x {reason}" for reason, n in s.statuses.items()] + s.warnings)
            writer.writerow([s.sequence.name, s.at, s.motion, s.exit_code, s.init_s, s.off_m, s.off_deg, s.tilt_deg,
                             alarms])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--duration", type=float, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", metavar="REGEX", help="sequences that match")
    parser.add_argument("--cache", type=Path, default=ROOT / "runs" / "flights", help="of simulated flights")
    parser.add_argument("--sequences", type=Path, nargs="+", help="instead of the recordings and simulated flights")
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for facet run")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--csv", type=Path, help="one line for each start")
    parser.add_argument("--worst", type=int, default=8, help="how many are listed")
    arguments = parser.parse_args()
    folders = [f for f in trajectories.find_sequences(arguments.sequences or [start_flights.data_folder()])
               if re.search(arguments.only, f.name) and trajectories.truth_file(f)]
    flights = [f for f in start_flights.FLIGHTS if re.search(arguments.only, f.name) and not arguments.sequences]
    folders += [folder for _, folder in start_flights.make_all(arguments.cache, arguments.program, flights)]
    if not folders:
        sys.exit("random_starts: no sequence matches")
    extra = [word for item in arguments.set for word in ("--set", item)]
    starts = draw_starts([Sequence(f) for f in folders], arguments.count, arguments.duration, arguments.seed)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(lambda pair: execute(pair[1], pair[0], arguments.program, arguments.duration, extra), starts))
    starts = [start for _, start in starts]
    print_tables(starts)
    print_worst(starts, arguments.worst)
    if arguments.csv:
        write_csv(starts, arguments.csv)
    in_time = sum(not s.is_late() for s in starts) / len(starts)
    wrong = sum(s.is_wrong() for s in starts)
    print(f"\n{len(starts)} starts: {100 * in_time:.2f} % with a pose within {MAX_INIT_S:g} s (target "
          f"{100 * MIN_SHARE:g}), {wrong} off by more than {MAX_OFF_M:g} m or {MAX_OFF_DEG:g} deg after "
          f"{arguments.duration:g} s (target 0), "
          f"{sum(s.has_alarm() for s in starts)} with an alarm")
    return 0 if in_time >= MIN_SHARE and wrong == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
