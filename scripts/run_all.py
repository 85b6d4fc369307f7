#!/usr/bin/python3
"""Runs Facet over sequences with perturbed starts and prints what it costs and how good it is.

  run_all.py                                    every sequence of $FACET_DATA_DIR or ../shared/data
  run_all.py DATA EXTRA_SEQUENCE --starts 9     those folders instead
  run_all.py --config base --config 'small=--set estimator.window.max_pose_keyframes=5'
                                                two configurations and their paired comparison
  run_all.py --config new --config 'old=@build-old/facet'     two programs
  run_all.py --against 99993d2 --starts 9       builds that commit and runs both in turn
  run_all.py --repeat-check                     same bytes twice and with two threads?

Starts are 0, 0.1, 0.2 ... s. Each run is pinned to one core; times are thread CPU time without decoding.
"""

import argparse
import json
import os
import queue
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
import trajectories  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent


@dataclass
class Config:
    """A name, the program, and extra arguments of `facet run`."""

    name: str
    program: str
    arguments: list


@dataclass
class Run:
    """One run: what was asked for and what came out."""

    sequence: Path
    config: Config
    start: float
    folder: Path
    exit_code: int = 0
    message: str = ""
    summary: dict = field(default_factory=dict)
    evaluation: dict = field(default_factory=dict)

    def ate(self):
        return self.evaluation.get("ate", {}).get("rmse_m")

    def cpu_ms(self):
        return self.stage("total_without_decode", "mean_ms")

    def memory_mb(self):
        return self.summary.get("peak_rss_mb")

    def stage(self, name, key):
        return self.summary.get("stages", {}).get(name, {}).get(key)


def parse_config(text, program, common):
    """'name', 'name=arguments' or 'name=@program arguments'."""
    name, _, rest = text.partition("=")
    words = shlex.split(rest)
    if words and words[0].startswith("@"):
        program = words.pop(0)[1:]
    return Config(name, program, common + words)


def read_json(path):
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def run_command(run, core, extra=()):
    return ["taskset", "-c", str(core), run.config.program, "run", str(run.sequence), "--out", str(run.folder),
            "--start", f"{run.start:g}", "--quiet", *run.config.arguments, *extra]


def last_line(process):
    lines = (process.stderr or process.stdout).strip().splitlines()
    return lines[-1] if lines else ""


def execute(run, core, parts):
    shutil.rmtree(run.folder, ignore_errors=True)
    run.folder.parent.mkdir(parents=True, exist_ok=True)
    process = subprocess.run(run_command(run, core), capture_output=True, text=True, check=False)
    run.exit_code = process.returncode
    run.message = last_line(process)
    run.summary = read_json(run.folder / "summary.json")
    if trajectories.truth_file(run.sequence) and (run.folder / "trajectory.tum").exists():
        command = [run.config.program, "evaluate", str(run.folder), "--truth", str(run.sequence), *parts]
        process = subprocess.run(command, capture_output=True, text=True, check=False)
        if process.returncode != 0:
            run.message = run.message or last_line(process)
        run.evaluation = read_json(run.folder / "evaluation.json")


def execute_all(runs, jobs, parts=("--parts", "trajectory")):
    """Each job owns one core of those this process may use. `parts`: of `facet evaluate`; the surfaces of a large scene
    take longer than the run."""
    allowed = sorted(os.sched_getaffinity(0))
    cores = queue.Queue()
    for core in allowed[:jobs]:
        cores.put(core)

    def work(run):
        core = cores.get()
        try:
            execute(run, core, parts)
        finally:
            cores.put(core)
        ate = run.ate()
        print(f"  {run.sequence.name} {run.config.name} start {run.start:g}: "
              + (f"ATE {ate:.4f} m" if ate is not None else run.message or f"exit {run.exit_code}"),
              file=sys.stderr, flush=True)

    with ThreadPoolExecutor(min(jobs, len(allowed))) as pool:
        list(pool.map(work, runs))


def median(values):
    values = [v for v in values if v is not None]
    return float(np.median(values)) if values else None


def text(value, form):
    return "-" if value is None else format(value, form)


def summarise(runs):
    """One row of the table: medians over the starts of one sequence and configuration."""
    ates = [r.ate() for r in runs]
    coverage = [r.evaluation.get("coverage") for r in runs]
    total = "total_without_decode"
    return {
        "sequence": runs[0].sequence.name,
        "config": runs[0].config.name,
        "coverage_min": min((c for c in coverage if c is not None), default=None),
        "init_s_max": max((r.summary["init_s"] for r in runs if r.summary.get("init_s") is not None), default=None),
        "ate_rmse_m": ates,
        "ate_rmse_median_m": median(ates),
        "cpu_mean_ms": median([r.stage(total, "mean_ms") for r in runs]),
        "cpu_keyframe_median_ms": median([r.stage(total, "keyframe_median_ms") for r in runs]),
        "cpu_p99_ms": median([r.stage(total, "p99_ms") for r in runs]),
        "peak_rss_mb": max((r.summary["peak_rss_mb"] for r in runs if "peak_rss_mb" in r.summary), default=None),
        "resets": sum(r.summary.get("resets", 0) for r in runs),
        "failed": sum(r.exit_code != 0 for r in runs),
    }


def table_cells(row):
    coverage = row["coverage_min"]
    return [
        row["sequence"], row["config"],
        text(None if coverage is None else 100 * coverage, ".1f"),
        text(row["init_s_max"], ".2f"),
        text(row["ate_rmse_median_m"], ".4f"),
        " ".join(text(a, ".4f") for a in row["ate_rmse_m"]),
        text(row["cpu_mean_ms"], ".2f"), text(row["cpu_keyframe_median_ms"], ".2f"), text(row["cpu_p99_ms"], ".2f"),
        text(row["peak_rss_mb"], ".0f"), str(row["resets"]), str(row["failed"]),
    ]


HEADER = ["sequence", "config", "cover%", "init_s", "ATE med", "ATE rmse per start [m]", "cpu mean", "kf med", "p99",
          "RSS MB", "resets", "failed"]


def print_table(rows):
    cells = [HEADER] + rows
    widths = [max(len(row[i]) for row in cells) for i in range(len(HEADER))]
    for row in cells:
        print("  ".join(c.ljust(w) if i < 2 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))))
    print("cover%: least over the starts; init_s: longest; cpu: ms per frame without decoding, medians over the starts")


def bootstrap_interval(ratios, rounds=10000):
    """95 % interval of the median ratio; fixed seed."""
    rng = np.random.default_rng(1)
    medians = np.median(rng.choice(ratios, (rounds, len(ratios))), axis=1)
    return np.percentile(medians, [2.5, 97.5])


def paired_ratios(reference, other):
    """ATE of `other` over ATE of `reference`, start by start, on the frames that all runs cover."""
    done = [(a, b) for a, b in zip(reference, other) if a.ate() is not None and b.ate() is not None]
    if not done:
        return None
    truth = trajectories.Truth(done[0][0].sequence)
    pairs = [tuple(truth.pairs(run.folder / "trajectory.tum") for run in both) for both in done]
    common = set.intersection(*(set(p) for both in pairs for p in both))
    if len(common) < 3:
        return None
    return np.array([trajectories.ate_rmse_on(b, common) / trajectories.ate_rmse_on(a, common) for a, b in pairs])


def compare_costs(groups, sequences, configs):
    """Processor time and memory of every configuration, paired start by start with the first one."""
    results = []
    for config in configs[1:]:
        pairs = [pair for s in sequences for pair in zip(groups[s, configs[0].name], groups[s, config.name])]
        print()
        for name, cost in (("processor time per frame", Run.cpu_ms), ("peak memory", Run.memory_mb)):
            ratios = np.array([cost(b) / cost(a) for a, b in pairs if cost(a) and cost(b)])
            if len(ratios) == 0:
                continue
            low, high = bootstrap_interval(ratios)
            print(f"{config.name} / {configs[0].name}, {name}: median ratio {np.median(ratios):.3f}  "
                  f"[{low:.3f}, {high:.3f}], {len(ratios)} pairs")
            results.append({"cost": name, "config": config.name, "median_ratio": float(np.median(ratios)),
                            "low": float(low), "high": float(high), "pairs": len(ratios)})
    return results


def compare(groups, sequences, configs):
    """Paired comparison of every configuration with the first one."""
    results = []
    for config in configs[1:]:
        print(f"\n{config.name} / {configs[0].name}, ATE rmse paired by start on common frames:")
        pooled = []
        for sequence in sequences:
            ratios = paired_ratios(groups[sequence, configs[0].name], groups[sequence, config.name])
            if ratios is None:
                continue
            pooled.append(ratios)
            results.append(report_ratio(sequence.name, config.name, ratios))
        if len(pooled) > 1:
            results.append(report_ratio("all", config.name, np.concatenate(pooled)))
    return results


def report_ratio(name, config, ratios):
    low, high = bootstrap_interval(ratios)
    if len(ratios) < 9:
        verdict = "needs >= 9 starts to judge"
    else:
        verdict = "real" if high < 1 or low > 1 else "no difference shown"
    print(f"  {name:24} median ratio {np.median(ratios):.3f}  [{low:.3f}, {high:.3f}]  "
          f"better in {np.sum(ratios < 1)} of {len(ratios)}  {verdict}")
    return {"sequence": name, "config": config, "median_ratio": float(np.median(ratios)), "low": float(low),
            "high": float(high), "starts": len(ratios), "verdict": verdict}


def verdict(a, b):
    if a is None or b is None:
        return "not compared"
    return "identical" if a == b else "DIFFER"


def repeat_check(sequences, config, out):
    """Two runs and one with two threads must write the same trajectory."""
    same = True
    cores = ",".join(map(str, sorted(os.sched_getaffinity(0))))
    for sequence in sequences:
        contents = []
        for name, extra in (("first", []), ("second", []), ("two_threads", ["--threads", "2"])):
            run = Run(sequence, config, 0, out / sequence.name / f"repeat_{name}")
            shutil.rmtree(run.folder, ignore_errors=True)
            run.folder.parent.mkdir(parents=True, exist_ok=True)
            process = subprocess.run(run_command(run, cores, extra), capture_output=True, text=True, check=False)
            file = run.folder / "trajectory.tum"
            contents.append(file.read_bytes() if file.exists() else None)
            if contents[-1] is None:
                print(f"{sequence.name}: {name}: no trajectory ({last_line(process)})")
        first, second, threaded = contents
        print(f"{sequence.name:24} two runs {verdict(first, second)}, two threads {verdict(first, threaded)}")
        same = same and None not in contents and first == second == threaded
    return same


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help="sequences, or folders that hold sequences")
    parser.add_argument("--starts", type=int, default=5, help="perturbed starts per sequence")
    parser.add_argument("--config", action="append", default=[], metavar="NAME[=ARGS]",
                        help="arguments of 'facet run' under a name; '@program' first takes another program")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for every configuration")
    parser.add_argument("--against", metavar="COMMIT", help="also run this commit of Facet, with its own defaults")
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--jobs", type=int, default=1, help="runs at the same time, one core each")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "all", help="where the results go")
    parser.add_argument("--json", type=Path, help="write the table there too")
    parser.add_argument("--repeat-check", action="store_true")
    return parser.parse_args()


def find_sequences(folders):
    if not folders:
        folders = [Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")]
    sequences = trajectories.find_sequences(folders)
    if not sequences:
        sys.exit("run_all: no sequence (a folder with mav0/) in " + ", ".join(map(str, folders)))
    return sequences


def main():
    arguments = parse_arguments()
    sequences = find_sequences(arguments.folders)
    common = [word for item in arguments.set for word in ("--set", item)]
    configs = [parse_config(c, arguments.program, common) for c in arguments.config or ["default"]]
    if arguments.against:
        process = subprocess.run([ROOT / "scripts" / "build_commit.sh", arguments.against], stdout=subprocess.PIPE,
                                 text=True, check=False)
        if process.returncode != 0:
            sys.exit(f"run_all: commit {arguments.against} could not be built")
        configs = [Config(arguments.against, process.stdout.strip(), common), *configs]
    for config in configs:
        if not os.access(config.program, os.X_OK):
            sys.exit(f"run_all: {config.program}: no such program; run 'make build'")
    if arguments.repeat_check:
        return 0 if repeat_check(sequences, configs[0], arguments.out) else 1

    groups = {(s, c.name): [Run(s, c, 0.1 * k, arguments.out / s.name / c.name / f"start_{0.1 * k:.1f}")
                            for k in range(arguments.starts)] for s in sequences for c in configs}
    # Start by start, so that slow spells of the machine hit all configurations alike.
    runs = [groups[s, c.name][k] for s in sequences for k in range(arguments.starts) for c in configs]
    execute_all(runs, arguments.jobs)
    rows = [summarise(groups[s, c.name]) for s in sequences for c in configs]
    print_table([table_cells(row) for row in rows])
    comparison = compare(groups, sequences, configs) + compare_costs(groups, sequences, configs)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps({"rows": rows, "comparison": comparison}, indent=1), encoding="utf-8")
    return 1 if any(r.exit_code for r in runs) else 0


if __name__ == "__main__":
    sys.exit(main())
