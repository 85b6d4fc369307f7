#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-2-Clause
"""Prints the manual page facet(1), made of what the program says about itself: scripts/man_page.py PROGRAM"""

import re
import subprocess
import sys

TEXT_COLUMN = 30  # of the help; a name that is longer has its text on the next line
EXIT_CODES = [
    ("0", "done"),
    ("1", "internal error"),
    ("2", "wrong usage or configuration"),
    ("3", "input missing or damaged beyond use; the line on standard error names file and place"),
    ("4", "the estimator could not start or was lost for good; the results up to then are written"),
    ("5", "a result cannot be written"),
    ("130", "interrupted; the results up to then are written"),
]
DESCRIPTION = """Facet estimates how a stereo camera with an inertial measurement unit moves, builds a triangle mesh of the
surfaces that it passes, and finds the planes among them, which in turn make the estimate more accurate. It reads folders
in the layout of EuRoC, KITTI's raw data, folders with left/, right/ and imu.csv, ROS 1 bags and ROS 2 bags, and writes
folders with trajectories, states, meshes, planes and times."""


def roff(text):
    """Plain text as the page's: no line begins a request, and hyphens are those that can be copied."""
    return re.sub(r"(?m)^([.'])", r"\\&\1", text.replace("\\", "\\e").replace("-", "\\-"))


def help_of(program, *command):
    return subprocess.run([program, *command, "--help"], capture_output=True, text=True, check=True).stdout


def items_of(text, heading):
    """Names with their meanings under a heading of the help."""
    section = re.search(rf"(?ms)^{heading}:\n(.*?)(?:\n\S|\Z)", text)
    items = []
    for line in section.group(1).splitlines() if section else ():
        if re.match(r" {2}\S", line):
            fits = line[TEXT_COLUMN - 1:TEXT_COLUMN] == " "
            items.append([line[:TEXT_COLUMN].strip(), line[TEXT_COLUMN:].strip()] if fits else [line.strip(), ""])
        elif line.strip() and items:
            items[-1][1] = f"{items[-1][1]} {line.strip()}".strip()
    return items


def print_items(items):
    for name, meaning in items:
        print(f".TP\n.B {roff(name)}\n{roff(meaning)}")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    program = sys.argv[1]
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    commands = items_of(help_of(program), "Subcommands")
    if not commands:
        sys.exit(f"man_page: {program} --help names no commands")
    print(f'.TH FACET 1 "" "facet {version}" "User Commands"')
    print(".SH NAME\nfacet \\- stereo visual\\-inertial odometry that builds a mesh and finds planes")
    print(".SH SYNOPSIS\n.B facet\n.I COMMAND\n[ARGUMENTS]...")
    print(f".SH DESCRIPTION\n{roff(DESCRIPTION)}\n.SH COMMANDS")
    print_items(commands)
    for command, meaning in commands:
        text = help_of(program, command)
        usage = re.search(r"Usage: (.*)", text).group(1)
        print(f".SH FACET {command.upper()}\n{roff(meaning)}.\n.PP\n.B {roff(usage)}")
        print_items(items_of(text, "Positionals") + items_of(text, "Options"))
    print(".SH EXIT STATUS")
    print_items(EXIT_CODES)
    print(".SH FILES\n.TP\n.I /usr/share/facet/config\nparameters for the option \\-\\-config, and scenes of the simulator")
    print(".TP\n.I /usr/share/doc/facet/docs\nthe documents; tutorial.md is the one to begin with")


if __name__ == "__main__":
    main()
