#!/usr/bin/python3
"""The figures of docs/BENCHMARK.md: pipelines S and SPR with the default configuration, as a Markdown table.

  benchmark.py                    simulates three flights (once, some minutes) and adds the recordings that it finds in
                                  $FACET_DATA_DIR or ../shared/data
  benchmark.py --starts 9         more starts: 0, 0.1, 0.2 ... s into each sequence
  benchmark.py FOLDER...          these sequences instead

Every run is alone on one core; a figure is the median over the starts, memory the largest.
"""

import argparse
import os
import platform
import subprocess
import sys
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import run_all

ROOT = Path(__file__).resolve().parent.parent
FACET = ROOT / "build" / "facet"
RUNS = ROOT / "runs" / "benchmark"
FLIGHTS = {
    "room_gentle": ["--scene", "room", "--trajectory", "gentle", "--duration", "30", "--seed", "11"],
    "room_fast": ["--scene", "room", "--trajectory", "fast", "--duration", "30", "--seed", "12"],
    "corridor_walk": ["--scene", "corridor", "--trajectory", "walk", "--duration", "60", "--seed", "13"],
}
HEADER = ["sequence", "pipeline", "ATE [mm]", "position NEES", "map error [mm]", "map complete [%]", "planes found [%]",
          "planes right [%]", "CPU per frame [ms]", "99 % below [ms]", "memory [MB]"]


def simulated():
    for name, arguments in FLIGHTS.items():
        folder = RUNS / "sequences" / name
        if not (folder / "simulation.txt").exists():
            subprocess.run([FACET, "simulate", "--out", folder, "--quiet", "--set", "image.rays_per_pixel=3", *arguments],
                           check=True)
        yield folder


def recorded():
    data = Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")
    return run_all.trajectories.find_sequences([data]) if data.is_dir() else []


def figure(runs, *keys, scale=1.0, form=".1f"):
    def of(evaluation):
        for key in keys:
            evaluation = (evaluation or {}).get(key)
        return None if evaluation is None else scale * evaluation

    return run_all.text(run_all.median([of(run.evaluation) for run in runs]), form)


def row(runs):
    summary = run_all.summarise(runs)
    return [summary["sequence"], summary["config"],
            figure(runs, "ate", "rmse_m", scale=1e3),
            figure(runs, "consistency", "position", "nees", form=".2f"),
            figure(runs, "map", "accuracy_median_m", scale=1e3),
            figure(runs, "map", "completeness_10cm", scale=100, form=".0f"),
            figure(runs, "planes", "recall", scale=100, form=".0f"),
            figure(runs, "planes", "precision", scale=100, form=".0f"),
            run_all.text(summary["cpu_mean_ms"], ".2f"), run_all.text(summary["cpu_p99_ms"], ".1f"),
            run_all.text(summary["peak_rss_mb"], ".0f")]


def machine():
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.machine()}, {len(models)} cores"


def commit():
    run = subprocess.run(["git", "-C", str(ROOT), "describe", "--always", "--dirty"], capture_output=True, text=True,
                         check=False)
    return run.stdout.strip() or "unknown"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--starts", type=int, default=5)
    arguments = parser.parse_args()
    if arguments.folders:
        sequences = run_all.trajectories.find_sequences(arguments.folders)
    else:
        sequences = [*simulated(), *recorded()]
    configs = [run_all.Config(name, str(FACET), ["--pipeline", name]) for name in ("S", "SPR")]
    groups = [[run_all.Run(s, c, 0.1 * k, RUNS / s.name / c.name / f"start_{0.1 * k:.1f}")
               for k in range(arguments.starts)] for s in sequences for c in configs]
    run_all.execute_all([run for group in groups for run in group], 1, parts=())
    failed = [run for group in groups for run in group if run.exit_code != 0]
    print(f"Commit {commit()}; {machine()}; {arguments.starts} starts.\n")
    for cells in (HEADER, ["---"] * len(HEADER), *(row(group) for group in groups)):
        print("| " + " | ".join(cells) + " |")
    for run in failed:
        print(f"\n{run.sequence.name} {run.config.name} start {run.start:g} failed: {run.message}")
    return 1 if failed or not sequences else 0


if __name__ == "__main__":
    sys.exit(main())
