#!/usr/bin/python3
"""Kills runs at recorded speed at random moments and looks at what they leave.

  kill_runs.py [SEQUENCE] [--kills N] [--seconds S] [--jobs J] [--seed N] [--program FILE]

SEQUENCE: a recording of at least S seconds; without one a room is simulated. Each run is sent SIGKILL at a moment that is
drawn evenly from its first S seconds. Then every file of OUT.partial must be readable as it is: tables with all columns
in every line, meshes as long as their headers say, a summary that says "interrupted". And everything up to a second
before the kill must be there: the frames of states.csv, timing.csv and trajectory.tum, the keyframes, and a mesh, a map
and a summary of the last second. The next run has to find it and call it OUT.interrupted. Prints one line; exit code 1
if anything was amiss.
"""

import argparse
import csv
import json
import math
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ALLOWED_S = 1.0  # what may be missing before the kill
SIZES = {"char": 1, "uchar": 1, "short": 2, "ushort": 2, "int": 4, "uint": 4, "float": 4, "double": 8}


class Amiss(Exception):
    """What a kill has left is not as it should be."""


def check(condition, text):
    if not condition:
        raise Amiss(text)


def read_table(path):
    text = path.read_text(encoding="utf-8")
    check(text.endswith("\n"), f"{path.name}: the last line is cut off")
    rows = list(csv.reader(text.splitlines()))
    for number, row in enumerate(rows, 1):
        check(len(row) == len(rows[0]), f"{path.name}:{number}: {len(row)} of {len(rows[0])} columns")
    return [dict(zip(rows[0], row)) for row in rows[1:]]


def read_tum(path):
    text = path.read_text(encoding="utf-8")
    check(text.endswith("\n"), f"{path.name}: the last line is cut off")
    stamps = []
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("#"):
            continue
        values = [float(v) for v in line.split()]
        check(len(values) == 8 and abs(math.hypot(*values[4:]) - 1) < 1e-6, f"{path.name}:{number}: no pose")
        seconds, fraction = line.split()[0].split(".")
        stamps.append(int(seconds) * 10**9 + int(fraction))
    return stamps


def check_ply(path):
    """Follows the faces' lists: the file must end where its header says."""
    data = path.read_bytes()
    end = data.find(b"end_header\n")
    check(data.startswith(b"ply\n") and end > 0, f"{path.name}: no header")
    at = end + len(b"end_header\n")
    for element in re.split(r"^element ", data[:end].decode(), flags=re.M)[1:]:
        lines = element.splitlines()
        count = int(lines[0].split()[1])
        properties = [line.split() for line in lines[1:] if line.startswith("property")]
        lists = [p for p in properties if p[1] == "list"]
        fixed = sum(SIZES[p[1]] for p in properties if p[1] != "list")
        # All faces are triangles.
        at += count * (fixed + sum(SIZES[p[2]] + 3 * SIZES[p[3]] for p in lists))
    check(at == len(data), f"{path.name}: {len(data)} bytes, {at} by its header")


def check_fresh(path, killed):
    age = killed - path.stat().st_mtime
    check(age < ALLOWED_S, f"{path.name}: {age:.2f} s old")


def inspect(folder, killed):
    """Raises Amiss; returns by how much the newest frame is before the kill [s], or None before the first."""
    began = (folder / "config.yaml").stat().st_mtime
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    check(summary["interrupted"] is True, "summary.json: not interrupted")
    for path in folder.rglob("*.ply"):
        if not path.name.startswith("."):
            check_ply(path)
    states, timing = read_table(folder / "states.csv"), read_table(folder / "timing.csv")
    trajectory = read_tum(folder / "trajectory.tum")
    keyframes = read_tum(folder / "keyframes.tum") if (folder / "keyframes.tum").exists() else []
    if (folder / "planes.csv").exists():
        read_table(folder / "planes.csv")
    if killed - began < ALLOWED_S:
        return None
    check(states, "states.csv: empty")
    # Frames come at recorded speed from the beginning on.
    first = int(states[0]["timestamp_ns"])
    behind = killed - began - 1e-9 * (int(states[-1]["timestamp_ns"]) - first)
    check(behind < ALLOWED_S, f"states.csv: the newest frame is {behind:.2f} s before the kill")
    check(timing[-1]["timestamp_ns"] >= states[-2 if len(states) > 1 else -1]["timestamp_ns"], "timing.csv is behind")
    posed = [int(s["timestamp_ns"]) for s in states if s["px"]]
    check(len(trajectory) >= len(posed) - 2 and trajectory == posed[: len(trajectory)], "trajectory.tum: poses are missing")
    newest = int(states[-1]["timestamp_ns"])
    due = [int(row["timestamp_ns"]) for row, state in zip(timing, states)
           if row["is_keyframe"] == "1" and state["px"] and newest - int(row["timestamp_ns"]) > 1e9 * (ALLOWED_S - behind)]
    check(keyframes == sorted(set(keyframes)), "keyframes.tum: not in order of time")
    check(not due or (keyframes and keyframes[-1] >= due[-1]), "keyframes.tum: keyframes are missing")
    check_fresh(folder / "summary.json", killed)
    if due:
        for name in ("mesh.ply", "landmarks.ply"):
            check((folder / name).exists(), f"{name}: missing")
    return behind


def run_until(moment_s, sequence, out, program):
    """Lets a run go on for so long, and kills it. Returns the moment of the kill."""
    process = subprocess.Popen([program, "run", sequence, "--realtime", "--quiet", "--mesh-every", "2", "--out", out],
                               stderr=subprocess.DEVNULL)
    partial = Path(f"{out}.partial")
    begin = time.monotonic()
    while not (partial / "summary.json").exists():  # there is nothing to lose before
        if process.poll() is not None or time.monotonic() - begin > 60:
            raise Amiss(f"the run ended by itself with {process.poll()}")
        time.sleep(0.005)
    time.sleep(moment_s)
    if process.poll() is not None:
        raise Amiss("the run was over before the kill: give a longer sequence, or fewer --seconds")
    killed = time.time()
    process.send_signal(signal.SIGKILL)
    process.wait()
    return killed


def kill_one(number, moment_s, sequence, folder, program):
    """Returns what was amiss, or an empty text, and how far the newest frame was behind."""
    out = folder / f"run{number}"
    behind, amiss = None, ""
    try:
        killed = run_until(moment_s, sequence, out, program)
        behind = inspect(Path(f"{out}.partial"), killed)
        subprocess.run([program, "run", sequence, "--quiet", "--duration", "0.2", "--out", out],
                       check=False, capture_output=True)
        check(not Path(f"{out}.partial").exists(), "the next run leaves the partial result")
        check((Path(f"{out}.interrupted") / "summary.json").exists(), "the next run does not keep it")
    except (Amiss, OSError, ValueError, KeyError) as error:
        amiss = f"kill {number} after {moment_s:.3f} s: {error}"
        print(amiss, file=sys.stderr)
    for path in folder.glob(f"*run{number}*"):
        if path.name.split(".partial")[0].lstrip(".") in (out.name, f"{out.name}.interrupted"):
            shutil.rmtree(path, ignore_errors=True)
    return amiss, behind


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", nargs="?", type=Path)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=6)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kill_runs-") as name:
        folder = Path(name)
        sequence = arguments.sequence
        if sequence is None:
            sequence = folder / "room"
            subprocess.run([arguments.program, "simulate", "--out", sequence, "--scene", "room", "--trajectory", "gentle",
                            "--duration", str(math.ceil(arguments.seconds + 1))], check=True, capture_output=True)
        drawn = random.Random(arguments.seed)
        moments = [drawn.uniform(0, arguments.seconds) for _ in range(arguments.kills)]
        with ThreadPoolExecutor(arguments.jobs) as pool:
            results = list(pool.map(
                lambda item: kill_one(item[0], item[1], sequence, folder, arguments.program), enumerate(moments)))
    num_amiss = sum(bool(amiss) for amiss, _ in results)
    behind = [b for _, b in results if b is not None]
    print(f"{len(results)} kills within {arguments.seconds:g} s: {num_amiss} left something amiss; "
          f"the newest frame was {max(behind, default=0):.2f} s before the kill at most, "
          f"{sorted(behind)[len(behind) // 2] if behind else 0:.2f} s in the median of {len(behind)}")
    return 1 if num_amiss else 0


if __name__ == "__main__":
    sys.exit(main())
