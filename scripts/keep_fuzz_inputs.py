#!/usr/bin/python3
"""Keeps inputs that a fuzzer has found as lines of a file that tests and later fuzzers read.

  keep_fuzz_inputs.py FOLDER FILE                      one input a file of the folder, smallest first
  keep_fuzz_inputs.py FOLDER FILE --readers config,ply     of reader_fuzzer, run with --only=config,ply

Lines that are in FILE stay (a comment at its head, too), and nothing is kept twice. Inputs of more than --max-bytes are
left out: what they reach is found again soon, and the file lies in the repository.
"""

import argparse
from pathlib import Path


def line_of(content, readers):
    """Of reader_fuzzer: the first byte chooses the reader, and its number changes when there are more of them."""
    if not readers:
        return content.hex()
    return f"{readers[content[0] % len(readers)]}\t{content[1:].hex()}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("file", type=Path)
    parser.add_argument("--readers", help="their names in the order of --only")
    parser.add_argument("--max-bytes", type=int, default=250)
    arguments = parser.parse_args()
    readers = arguments.readers.replace("_", " ").split(",") if arguments.readers else []
    lines = arguments.file.read_text(encoding="utf-8").splitlines() if arguments.file.exists() else []
    known = set(lines)
    contents = (path.read_bytes() for path in arguments.folder.iterdir() if path.is_file())
    for content in sorted(contents, key=lambda c: (len(c), c)):
        if not 1 < len(content) <= arguments.max_bytes:
            continue
        line = line_of(content, readers)
        if line not in known:
            known.add(line)
            lines.append(line)
    arguments.file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print(f"{arguments.file}: {sum(not line.startswith('#') for line in lines)} inputs")


if __name__ == "__main__":
    main()
