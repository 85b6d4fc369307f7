#!/usr/bin/python3
"""Hours of clean data: every alarm is a false one.

  clean_hours.py                     two hours over all recordings and simulated flights
  clean_hours.py --hours 0.2 --only room
  clean_hours.py --sequences FOLDER ...   these alone, from many starts, e.g. those of `scripts/suite.py make`

Closed flights of start_flights.py are played lap after lap (build/bench/laps); recordings and open flights are run from
many starts, one tenth of all data. An alarm is, after the first pose, a frame whose status is not ok, a new segment, an
image that is called repeated, a sample of the IMU that is cut out or doubted, a hole in the IMU, or any warning. Prints
the data, the accuracy and the alarms of each sequence; exit code 1 if there is an alarm.
"""

import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

sys.path.insert(0, str(Path(__file__).resolve().parent))
import random_starts  # noqa: E402
import start_flights  # noqa: E402
import trajectories  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
OPEN_SHARE = 0.1  # of the data, from recordings and open flights
START_STEP_S = 0.37  # between their starts; no multiple of the frames' interval


def play_laps(folder, seconds, laps):
    """Seconds of data, a description, and the alarms as text."""
    done = subprocess.run([laps, str(folder), "--hours", f"{seconds / 3600:.6f}", "--print-every", "1000000"],
                          capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    if not lines or " laps, " not in lines[-1]:
        return 0, "", [f"laps failed: {done.stderr.strip()[-200:]}"]
    hours = float(re.search(r"([\d.]+) h:", lines[-1]).group(1))
    return 3600 * hours, lines[-1].split(": ", 1)[1], [line for line in lines if line.startswith("alarm: ")]


def run_from_many_starts(folder, seconds, program):
    sequence = random_starts.Sequence(folder)
    total, worst_m, alarms, number = 0, 0, [], 0
    while total < seconds:
        at = START_STEP_S * number % max(START_STEP_S, sequence.length_s / 2)
        start = random_starts.Start(folder, at, "")
        random_starts.execute(start, sequence, program, 1e5, [])
        alarms += [f"alarm: {n} x {text} (--start {at:.2f})" for text, n in start.statuses.items()]
        alarms += [f"alarm: {text} (--start {at:.2f})" for text in start.warnings]
        if start.init_s is None:
            alarms.append(f"alarm: no pose (--start {at:.2f})")
        worst_m = max(worst_m, start.off_m)
        total += sequence.length_s - at
        number += 1
    return total, f"{number} runs, at most {1e3 * worst_m:.0f} mm off at their ends", alarms


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=2)
    parser.add_argument("--only", default="", metavar="REGEX", help="sequences that match")
    parser.add_argument("--cache", type=Path, default=ROOT / "runs" / "flights", help="of simulated flights")
    parser.add_argument("--sequences", type=Path, nargs="+", help="instead of the recordings and simulated flights")
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--laps", default=str(ROOT / "build" / "bench" / "laps"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    flights = [f for f in start_flights.FLIGHTS if re.search(arguments.only, f.name) and not arguments.sequences]
    made = start_flights.make_all(arguments.cache, arguments.program, flights)
    closed = [folder for flight, folder in made if flight.is_closed()]
    opened = [f for f in trajectories.find_sequences(arguments.sequences or [start_flights.data_folder()])
              if re.search(arguments.only, f.name) and trajectories.truth_file(f)]
    opened += [folder for flight, folder in made if not flight.is_closed()]
    open_share = OPEN_SHARE if closed and opened else float(bool(opened))
    seconds = 3600 * arguments.hours
    closed_s = (1 - open_share) * seconds / max(1, len(closed))
    open_s = open_share * seconds / max(1, len(opened))
    with ThreadPoolExecutor(arguments.jobs) as pool:
        jobs = [(f, pool.submit(play_laps, f, closed_s, arguments.laps)) for f in closed]
        jobs += [(f, pool.submit(run_from_many_starts, f, open_s, arguments.program)) for f in opened]
        total, count = 0, 0
        for folder, job in jobs:
            played_s, text, alarms = job.result()
            total, count = total + played_s, count + len(alarms)
            print(f"{folder.name:20s} {played_s:6.0f} s  {text}", flush=True)
            for alarm in alarms:
                print("    " + alarm)
    print(f"{total / 3600:.2f} h of clean data, {len(jobs)} sequences: {count} kinds of false alarms (target 0)")
    return 1 if count or total < seconds else 0


if __name__ == "__main__":
    sys.exit(main())
