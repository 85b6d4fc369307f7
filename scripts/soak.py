#!/usr/bin/python3
"""A long flight: nothing is lost, and memory and time per frame stay level.

  soak.py                      simulates laps through a corridor (once for each duration) and runs them
  soak.py --duration 20        a short one
  soak.py --sequence FOLDER    a recording instead
  soak.py --hours 2            one closed lap through a room again and again, in one process (build/bench/laps), each
                               time with the noise of one of eight simulations

Fails if a frame has no pose after the start, the run was reset, the second half of the frames takes much longer than
the first (flights of a minute and more), memory grows faster than the map is allowed to, or the drift is not that of an
odometry. Laps may show no alarm at all, memory without the map may grow by 2 MB after the first five minutes, and later
laps have to be as accurate as the first ones.
"""

import argparse
import csv
import json
import statistics
import subprocess
import sys
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

sys.path.insert(0, str(Path(__file__).resolve().parent))
import start_flights  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
MAX_SLOWER = 1.5  # medians of the second half of the frames against the first
MIN_TIMED_S = 60  # of flight: the halves of a shorter one tell what else the machine did, not how frames grow
MAX_GROWTH_MB = 60  # of the process over the second half, without the map
MAX_DRIFT = 0.01  # ATE by the length of the path
LAP = "room-gentle"  # of start_flights.FLIGHTS
NUM_TAKES = 8  # of it; with one alone the calibration ends where its noise leads, which is the same in every lap


def run(program, *arguments):
    subprocess.run([str(program), *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


def simulate(program, runs, duration):
    folder = runs / f"soak-{duration:g}"
    if not (folder / "simulation.txt").exists():
        run(program, "simulate", "--out", folder, "--scene", "corridor", "--trajectory", "walk", "--duration", duration, "--seed", 5,
            "--set", "image.rays_per_pixel=2", "--quiet")
    return folder


def play_laps(arguments):
    """Exit code of build/bench/laps, which prints its figures."""
    [flight] = [flight for flight in start_flights.FLIGHTS if flight.name == LAP]
    folders = start_flights.make_takes(flight, arguments.runs / "flights", arguments.program, NUM_TAKES)
    command = [str(arguments.laps), *map(str, folders), "--hours", str(arguments.hours)]
    return subprocess.run(command, check=False).returncode


def summary_of(out):
    return json.loads((out / "summary.json").read_text())


def states_of(out):
    with open(out / "states.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def frame_times_ms(out):
    with open(out / "timing.csv", encoding="utf-8") as file:
        return [float(row["total_without_decode"]) for row in csv.DictReader(file)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, default=240, help="seconds of the simulated flight")
    parser.add_argument("--sequence", type=Path)
    parser.add_argument("--program", type=Path, default=ROOT / "build" / "facet")
    parser.add_argument("--runs", type=Path, default=ROOT / "runs", help="folder for the sequence and the results")
    parser.add_argument("--hours", type=float, help="of laps instead of one flight")
    parser.add_argument("--laps", type=Path, default=ROOT / "build" / "bench" / "laps", help="what plays them")
    arguments = parser.parse_args()
    if arguments.hours:
        return play_laps(arguments)
    program = arguments.program
    sequence = arguments.sequence or simulate(program, arguments.runs, arguments.duration)
    out, half = arguments.runs / "soak-run", arguments.runs / "soak-half"
    run(program, "run", sequence, "--out", out, "--quiet")
    whole = summary_of(out)
    run(program, "run", sequence, "--out", half, "--quiet", "--duration", whole["duration_s"] / 2)
    first = summary_of(half)

    wrong = []
    statuses = [row["status"] for row in states_of(out)]
    started = next((i for i, status in enumerate(statuses) if status != "initialising"), len(statuses))
    lost = sum(status not in ("ok", "degraded") for status in statuses[started:])
    if started == len(statuses) or lost:
        wrong.append(f"{lost} frames without a pose after the start")
    if whole["resets"]:
        wrong.append(f"{whole['resets']} resets")
    times = frame_times_ms(out)[started:]
    early, late = (statistics.median(part) for part in (times[:len(times) // 2], times[len(times) // 2:]))
    if whole["duration_s"] >= MIN_TIMED_S and late > MAX_SLOWER * early:
        wrong.append(f"frames take {late:.2f} ms, {early:.2f} before")
    grown = (whole["peak_rss_mb"] - whole["map_memory_mb"]) - (first["peak_rss_mb"] - first["map_memory_mb"])
    if grown > MAX_GROWTH_MB:
        wrong.append(f"{grown:.0f} MB more in the second half, without the map")
    run(program, "evaluate", out, "--truth", sequence)
    evaluation = json.loads((out / "evaluation.json").read_text())
    drift = evaluation["ate"]["rmse_m"] / evaluation["path_length_m"]
    if drift > MAX_DRIFT:
        wrong.append(f"an ATE of {100 * drift:.2f} % of the path")
    for text in wrong:
        print("soak:", text)
    print(f"soak: {whole['duration_s']:.0f} s, {len(times)} frames, {late:.2f} ms a frame in the second half ({early:.2f} "
          f"in the first), {whole['peak_rss_mb']:.0f} MB ({first['peak_rss_mb']:.0f} after half), {lost} frames lost, "
          f"ATE {100 * drift:.3f} % of the path")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
