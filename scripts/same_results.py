#!/usr/bin/python3
"""Do two programs write the same bytes? A change of structure must not change any result.

  same_results.py                          the current build against the commit that results are pinned to
  same_results.py --commit HEAD~3          against another commit, which is built first (build_commit.sh)
  same_results.py --program other/facet --config-folder other/config      against any other program
  same_results.py --quick                  six seconds of each recording, one thread

Pipelines S, SP and SPR with the default parameters and with config/paper.yaml, on one and two threads, on every
sequence of $FACET_DATA_DIR or ../shared/data that has images (or the folders given); then two short simulated
sequences. Compared: the files below, byte by byte. Exit code 1 if any differs.
"""

import argparse
import filecmp
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

sys.path.insert(0, str(Path(__file__).resolve().parent))
import trajectories  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
PINNED = "d926fc8"  # change it together with a change of results, and say so in that commit
FILES = ["trajectory.tum", "keyframes.tum", "states.csv", "planes.csv", "mesh.ply", "map.ply", "landmarks.ply",
         "evaluation.json"]
SIMULATIONS = {
    "room": ["--scene", "room", "--trajectory", "gentle", "--duration", "2", "--seed", "3"],
    "corridor": ["--scene", "corridor", "--trajectory", "walk", "--duration", "2", "--seed", "1"],
}


@dataclass
class Program:
    """A program and the folder with its parameter files."""

    path: str
    config: Path


@dataclass
class Case:
    """What both programs do, and where their results go."""

    name: str
    arguments: list  # of `facet run`, but for --config and --out
    config: str  # file in the program's config folder, or empty
    sequence: Path


def cases(sequences, quick):
    for sequence in sequences:
        for config in ("", "paper.yaml"):
            for pipeline in ("S", "SP", "SPR"):
                for threads in (1,) if quick else (1, 2):
                    arguments = ["--pipeline", pipeline, "--threads", str(threads)]
                    if quick:
                        arguments += ["--duration", "6"]
                    name = f"{sequence.name} {config or 'default'} {pipeline} {threads} thread{'s' * (threads > 1)}"
                    yield Case(name, arguments, config, sequence)


def call(command):
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    if process.returncode != 0:
        sys.exit(f"same_results: {' '.join(map(str, command))}: {process.stderr.strip() or process.returncode}")


def run_case(case, program, out):
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    config = ["--config", program.config / case.config] if case.config else []
    call([program.path, "run", case.sequence, "--out", out, "--quiet", *config, *case.arguments])
    if trajectories.truth_file(case.sequence):
        call([program.path, "evaluate", out, "--truth", case.sequence])


def without_segments(file):
    """The bytes of states.csv without its last column, `segment`, which older programs did not write."""
    lines = file.read_bytes().split(b"\n")
    if not lines[0].endswith(b",segment"):
        return file.read_bytes()
    return b"\n".join(line.rpartition(b",")[0] for line in lines)


def different_files(a, b):
    """Of FILES: those that only one has, or that differ."""
    def same(name):
        first, second = a / name, b / name
        if first.exists() != second.exists():
            return False
        if not first.exists() or filecmp.cmp(first, second, shallow=False):
            return True
        return name == "states.csv" and without_segments(first) == without_segments(second)
    return [name for name in FILES if not same(name)]


def different_trees(a, b):
    def files(folder):
        return {p.relative_to(folder) for p in folder.rglob("*") if p.is_file() and p.name != "simulation.txt"}
    names = files(a) | files(b)
    return sorted(str(n) for n in names
                  if not ((a / n).exists() and (b / n).exists() and filecmp.cmp(a / n, b / n, shallow=False)))


def simulate(name, program, out):
    shutil.rmtree(out, ignore_errors=True)
    out.parent.mkdir(parents=True, exist_ok=True)
    call([program.path, "simulate", "--out", out, "--quiet", *SIMULATIONS[name]])


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path, help="sequences, or folders that hold sequences")
    parser.add_argument("--commit", default=PINNED)
    parser.add_argument("--program", help="instead of a commit's")
    parser.add_argument("--config-folder", type=Path, help="that program's parameter files")
    parser.add_argument("--current", default=str(ROOT / "build" / "facet"), help="the program under test")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "same-results")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    return parser.parse_args()


def reference_program(arguments):
    if arguments.program:
        return Program(arguments.program, arguments.config_folder or ROOT / "config")
    built = subprocess.run([ROOT / "scripts" / "build_commit.sh", arguments.commit], stdout=subprocess.PIPE, text=True,
                           check=False)
    if built.returncode != 0:
        sys.exit(f"same_results: commit {arguments.commit} cannot be built")
    path = Path(built.stdout.strip().splitlines()[-1])
    return Program(str(path), path.parent.parent / "config")


def main():
    arguments = parse_arguments()
    folders = arguments.folders or [Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")]
    sequences = trajectories.find_sequences(folders)
    if not sequences:
        print("same_results: no recording in " + ", ".join(map(str, folders)) + "; only simulations are compared")
    programs = {"reference": reference_program(arguments), "current": Program(arguments.current, ROOT / "config")}
    todo = list(cases(sequences, arguments.quick))

    def compare_case(case):
        outs = [arguments.out / name / case.name.replace(" ", "-") for name in programs]
        for program, out in zip(programs.values(), outs):
            run_case(case, program, out)
        return case.name, different_files(*outs)

    def compare_simulation(name):
        outs = [arguments.out / which / f"simulated-{name}" for which in programs]
        for program, out in zip(programs.values(), outs):
            simulate(name, program, out)
        return f"simulated {name}", different_trees(*outs)

    same = True
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for name, differing in [*pool.map(compare_case, todo), *pool.map(compare_simulation, SIMULATIONS)]:
            same = same and not differing
            print(f"{name:48} {'same' if not differing else 'DIFFERENT: ' + ', '.join(differing[:8])}", flush=True)
    print("same bytes everywhere" if same else "some results differ")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
