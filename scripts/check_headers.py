#!/usr/bin/python3
"""Does every header compile alone? A source that includes nothing else is compiled with the flags of all.

  check_headers.py build-no-pch/compile_commands.json     of a build without precompiled headers (preset no-pch)
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("src", "apps", "bench")


def arguments_of(entry):
    """The compiler's arguments without the source and the object."""
    words = shlex.split(entry["command"])
    kept, skip = [], False
    for word in words:
        if skip or word in ("-o", "-MF", "-MT", "-c"):
            skip = not skip
        elif word != "-MD" and word != "ccache":
            kept.append(word)
    return kept


def add_command(words, to):
    """`to` gets the include directories and macros that it lacks; of a macro the first value counts."""
    if not to:
        to.extend(words)
        return
    macros = {word.split("=")[0] for word in to if word.startswith("-D")}
    for word, value in zip(words, [*words[1:], ""]):
        if word == "-isystem" and value not in to:
            to += [word, value]
        elif word.startswith("-I") and word not in to or word.startswith("-D") and word.split("=")[0] not in macros:
            to.append(word)


def common_command(database):
    """What all sources together are compiled with."""
    words = []
    for entry in json.loads(database.read_text()):
        add_command(arguments_of(entry), words)
    return words


def check(header, words):
    command = [*words, "-fsyntax-only", "-x", "c++", "-include", str(header), os.devnull]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    return "" if run.returncode == 0 else f"{header.relative_to(ROOT)}:\n{run.stderr}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("database", type=Path)
    parser.add_argument("--only", default="", metavar="REGEX", help="headers whose path matches")
    arguments = parser.parse_args()
    words = common_command(arguments.database)
    headers = sorted(h for folder in FOLDERS for h in (ROOT / folder).rglob("*.h") if re.search(arguments.only, str(h)))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        wrong = [text for text in pool.map(lambda header: check(header, words), headers) if text]
    print("\n".join(wrong))
    print(f"{len(headers)} headers, {len(wrong)} do not compile alone")
    return 1 if wrong or not headers else 0


if __name__ == "__main__":
    sys.exit(main())
