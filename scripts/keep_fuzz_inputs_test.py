#!/usr/bin/env python3
"""Tests of keep_fuzz_inputs.py."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPT = Path(__file__).resolve().parent / "keep_fuzz_inputs.py"


class Kept(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.found, self.file = Path(scratch.name) / "found", Path(scratch.name) / "inputs.txt"
        self.found.mkdir()

    def keep(self, *contents, arguments=()):
        for i, content in enumerate(contents):
            (self.found / str(i)).write_bytes(content)
        subprocess.run([sys.executable, str(SCRIPT), str(self.found), str(self.file), *arguments], check=True,
                       stdout=subprocess.DEVNULL)
        return self.file.read_text(encoding="utf-8").splitlines()

    def test_lines_are_inputs_in_hexadecimal_digits_the_small_ones_first(self):
        self.assertEqual(self.keep(b"abc", b"\x00\xff"), ["00ff", "616263"])

    def test_what_is_there_stays_and_nothing_is_kept_twice(self):
        self.file.write_text("# a comment\n616263\n", encoding="utf-8")
        self.assertEqual(self.keep(b"abc", b"xy"), ["# a comment", "616263", "7879"])
        self.assertEqual(self.keep(), ["# a comment", "616263", "7879"])

    def test_the_first_byte_is_the_name_of_the_reader(self):
        lines = self.keep(b"\x01ab", b"\x04cd", b"\x03ef", arguments=["--readers", "ply,image_list,json"])
        self.assertEqual(lines, ["image list\t6162", "ply\t6566", "image list\t6364"])

    def test_large_and_empty_inputs_are_left_out(self):
        self.assertEqual(self.keep(b"", b"a", b"abcd", b"abc", arguments=["--max-bytes", "3"]), ["616263"])


if __name__ == "__main__":
    unittest.main()
