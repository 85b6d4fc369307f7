#!/usr/bin/python3
"""compare_runs.py on trajectories whose differences are known."""

import math
import subprocess
import sys
import tempfile
from pathlib import Path

PROGRAM = Path(__file__).with_name("compare_runs.py")


def compare(folder, rows, *options):
    for name, lines in zip(("a", "b"), rows):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "trajectory.tum").write_text("# stamp x y z qx qy qz qw\n" + "".join(f"{line}\n" for line in lines))
    run = subprocess.run([sys.executable, PROGRAM, folder / "a", folder / "b", *options], capture_output=True, text=True)
    return run.returncode, run.stdout


def main():
    half = math.radians(1) / 2  # a turn of 1 degree
    turned = f"2.5 0 0 0.001 0 0 {math.sin(half):.12f} {math.cos(half):.12f}"
    same, other = "1.5 1 2 3 0 0 0 1", "2.5 0 0 0 0 0 0 -1"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        code, text = compare(folder, ([same, other], [same, turned]))
        assert code == 0 and "2 poses" in text and "0.001 m apart" in text and "1 and 0.5 degrees" in text, text
        assert compare(folder, ([same, other], [same, turned]), "--max-metres", "0.002")[0] == 0
        assert compare(folder, ([same, other], [same, turned]), "--max-metres", "0.0005")[0] == 1
        code, text = compare(folder, ([same], [same, other]))
        assert code == 1 and "1 stamps" in text, text
        code, text = compare(folder, ([same, other], [same, other.replace("0 0 0 0", "nan 0 0 0")]))
        assert code == 1 and "not finite" in text, text
        assert compare(folder, ([], []))[0] == 1, "no poses are not equal poses"
    print("compare_runs: all as expected")


if __name__ == "__main__":
    main()
