#!/usr/bin/env python3
"""Tests of check_references.py: each kind of reference that leads nowhere is found, and its right counterpart is not.

With FACET_PROGRAM the option keys read from the sources are compared with those that the program prints.
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import check_references  # noqa: E402
from reference_index import Index, slug  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
REPOSITORY = {
    "README.md": "# Readme\n",
    "Makefile": "bench:\n\ttrue\n",
    "CMakePresets.json": '{"configurePresets": [{"name": "release"}]}',
    "CMakeLists.txt": "add_test(NAME references COMMAND x)\n",
    "apps/CMakeLists.txt": "add_executable(facet main.cpp)\n",
    "apps/run.cpp": 'app.add_subcommand("run", "x");\ncommand.add_option("--out", a.out, "x");\n',
    "apps/evaluate.cpp": 'app.add_subcommand("evaluate", "x");\ncommand->add_option("--truth", t, "x");\n',
    "bench/CMakeLists.txt":
        "foreach(name kernel other)\n  add_executable(${name}_bench ${name}_bench.cpp)\nendforeach()\n"
        "add_executable(report report.cpp)\n",
    "bench/report.cpp": 'app.add_option("--dump", dump, "x");\n',
    "bench/kernel_bench.cpp": "",
    "scripts/plot.py": 'parser.add_argument("--size")\nparser.add_argument("--set")\n',
    "src/facet/mesh/mesh_options.h":
        "struct FaceOptions {\n  double max_side_m = 3;\n  template <class Visitor>\n  void Visit(Visitor& v) {\n"
        '    v.Field("max_side_m", max_side_m, Range{0, 1},\n            "x");\n  }\n};\n'
        "struct MeshOptions {\n  FaceOptions faces;\n  template <class V>\n  void Visit(V& v) {\n"
        '    v.Group("faces", faces);\n  }\n};\n'
        "struct VioOptions {\n  MeshOptions mesh;\n  template <class V>\n  void Visit(V& v) {\n"
        '    v.Group("mesh", mesh);\n  }\n};\n',
    "src/facet/mesh/face_filter.h": "bool IsSteep(double long_name);\n",
    "src/facet/mesh/face_filter_test.cpp": "TEST(FaceFilterTest, SteepFacesGo) {}\n",
    "docs/math.md": "# Maths\n\n## 1. Rotations\n\n### 1.2 More\n\n$$x \\tag{1.1}$$\n\n1. step\n",
    "docs/notebook/old.md": "# Old\n",
}


def complaints(files):
    """Messages about a repository with these files added, as `path:line: message`."""
    with tempfile.TemporaryDirectory() as folder:
        for path, text in {**REPOSITORY, **files}.items():
            (Path(folder) / path).parent.mkdir(parents=True, exist_ok=True)
            (Path(folder) / path).write_text(text, encoding="utf-8")
        return [f"{path}:{line}: {message}" for path, line, message in sorted(check_references.findings(folder))]


class ReferencesTest(unittest.TestCase):
    def expect(self, file, good, bad, message):
        """`bad` gives one complaint, that has `message`, at the last line; `good` gives none."""
        self.assertEqual(complaints({file: good}), [])
        found = complaints({file: bad})
        self.assertEqual(len(found), 1, found)
        self.assertIn(message, found[0])
        last = bad.rstrip("\n").count("\n") + 1
        self.assertTrue(found[0].startswith(f"{file}:{last}: "), found[0])

    def test_a_clean_repository_has_no_complaints(self):
        self.assertEqual(complaints({}), [])

    def test_files_and_folders(self):
        self.expect("docs/a.md", "See `apps/run.cpp`, `src/facet/mesh`.\n", "See\n`apps/walk.cpp`.\n", "apps/walk.cpp")
        self.expect("docs/a.md", "`scripts/plot.py`\n", "`scripts/draw.py`\n", "scripts/draw.py")
        self.expect("docs/a.md", "`apps/{run,evaluate}.cpp`\n", "`apps/{run,walk}.cpp`\n", "apps/walk.cpp")
        self.expect("docs/a.md", "`src/facet/mesh/face_filter`\n", "`src/facet/mesh/face`\n", "src/facet/mesh/face")
        self.expect("docs/a.md", "face_filter.h\n", "face_sieve.h\n", "face_sieve.h")
        self.expect("src/facet/a.h", "// mesh/face_filter.h\n", "// mesh/face_sieve.h\n", "face_sieve.h")
        self.expect("scripts/a.sh", "# see docs/math.md\n", "# see docs/maths.md\n", "docs/maths.md")
        self.expect("scripts/a.py", '"""See docs/math.md."""\n', '"""A.\n\nSee docs/maths.md."""', "docs/maths.md")
        self.expect("config/a.yaml", "a: 1  # bench/report.cpp\n", "a: 1  # bench/reports.cpp\n", "bench/reports.cpp")
        self.expect("cmake/a.cmake", "# apps/run.cpp\n", "# apps/walk.cpp\n", "apps/walk.cpp")

    def test_messages_of_programs(self):
        good = 'Say("raise mesh.faces.max_side_m (docs/math.md) // gone_name");  // 1\'000\n'
        self.expect("src/facet/a.cpp", good, 'Say("raise mesh.faces.max_side");\n', "mesh.faces.max_side")
        self.expect("src/facet/a.cpp", good, 'Say("see docs/maths.md");\n', "docs/maths.md")
        self.assertEqual(complaints({"src/facet/a_test.cpp": 'Say("see docs/maths.md");\n'}), [])

    def test_programs_and_commands(self):
        self.expect("docs/a.md", "`build/bench/kernel_bench`\n", "`build/bench/nut_bench`\n", "nut_bench")
        self.expect("docs/a.md", "`build/facet run`\n", "`build/facets run`\n", "facets")
        self.expect("docs/a.md", "`facet run X`\n", "`facet walk X`\n", "'walk'")
        self.expect("src/facet/a.h", "// As `facet run` does.\n", "// As `facet walk` does.\n", "'walk'")
        self.expect("docs/a.md", "`make bench`\n", "`make lunch`\n", "'lunch'")
        self.expect("docs/a.md", "`cmake --preset release`\n", "`cmake --preset fast`\n", "'fast'")

    def test_command_line_options(self):
        self.expect("docs/a.md", "`facet run X --out R`\n", "`facet run X --truth R`\n", "run has no option --truth")
        self.expect("docs/a.md", "`--truth`\n", "`--falsehood`\n", "--falsehood")
        self.expect("docs/a.md", "`build/bench/report --dump F`\n", "`build/bench/report --size F`\n", "report has no")
        self.expect("docs/a.md", "`scripts/plot.py --size 3`\n", "`scripts/plot.py --width 3`\n", "--width")
        self.expect("apps/a.h", "/// With --out only.\n", "/// With\n/// --in only.\n", "--in")

    def test_option_keys(self):
        self.expect("docs/a.md", "`mesh.faces.max_side_m`\n", "`mesh.faces.max_side`\n", "mesh.faces.max_side")
        self.expect("docs/a.md", "`--set mesh.faces.max_side_m=1`\n", "`--set mesh.side_m=1`\n", "mesh.side_m")
        self.expect("docs/a.md", "`mesh.faces.max_*_m`\n", "`mesh.faces.min_*_m`\n", "mesh.faces.min_*_m")
        self.expect("src/facet/a.h", "// --set mesh.faces.max_side_m=1\n", "// --set mesh.side_m=1\n", "mesh.side_m")

    def test_tests(self):
        self.expect("docs/a.md", "`ctest -R FaceFilter`\n", "`ctest -R FaceSieve`\n", "FaceSieve")
        self.expect("docs/a.md", "`ctest -L unit`\n", "`ctest -L slow`\n", "slow")

    def test_sections_and_equations(self):
        self.expect("docs/a.md", "docs/math.md, section 1.2\n", "docs/math.md, section 1.3\n", "no section 1.3")
        self.expect("docs/a.md", "[m](math.md), section 1\n", "[m](math.md), section 2\n", "no section 2")
        self.expect("docs/a.md", "math.md, 1.2\n", "math.md, 1.3\n", "no section 1.3")
        self.expect("docs/a.md", 'math.md, "Rotations"\n', 'math.md, "Turns"\n', "no heading")
        self.expect("docs/a.md", "math.md, step 1\n", "math.md, step 2\n", "no step 2")
        header, own = "src/facet/a.h", "# A\n\n## 1. B\n\n"
        self.expect(header, "// (docs/math.md,\n// section 1)\n", "// (docs/math.md, section 7)\n", "no section 7")
        self.expect(header, "// Section 1 of docs/math.md\n", "// Section 9 of docs/math.md\n", "no section 9")
        self.expect(header, "// sections 1 and 1.2 of math.md\n", "// sections 1 to 3 of math.md\n", "no section 3")
        self.expect(header, "// Equation (1.1)\n", "// Equation (1.7)\n", "no equation (1.7)")
        self.expect("docs/a.md", own + "see section 1\n", own + "see section 2\n", "no section 2")

    def test_links_and_anchors(self):
        self.expect("docs/a.md", "[x](math.md)\n", "[x](maths.md)\n", "maths.md")
        self.expect("docs/a.md", "[x](../apps)\n", "[x](../app)\n", "../app")
        self.expect("docs/a.md", "[x](math.md#1-rotations)\n", "[x](math.md#turns)\n", "no such heading")
        self.expect("docs/a.md", "# Be `it`\n\n[x](#be-it)\n", "# Be\n\n[x](#a)\n", "no such heading")
        self.expect("docs/a.md", "[x](https://a.org/b)\n", "![x](images/none.png)\n", "images/none.png")

    def test_names_of_code(self):
        self.expect("docs/a.md", "`face_filter`, `IsSteep()`\n", "`face_sieve`\n", "face_sieve")
        self.expect("src/facet/a.h", "// With long_name.\n", "// With short_name.\n", "short_name")
        self.expect("docs/a.md", "`T_AB`, `_px`\n", "`IsFlat`\n", "IsFlat")

    def test_style_of_documents(self):
        for phrase in ("measured by hand", "code not kept", "asked: 3", "is missed", "Issue A", "for sessions",
                       "the last stop", "before this stop's changes", "0.9 (older)", "3 %, older."):
            for file in ("docs/a.md", "docs/notebook/a.md"):
                with self.subTest(phrase=phrase, file=file):
                    self.expect(file, "older keyframes\n", phrase + "\n", "private phrase")
        self.expect("src/facet/a.h", "// drawn by hand\n", "// (by hand: 3)\n", "private phrase")
        self.expect("docs/a.md", "x " * 60 + "\n", "x " * 60 + "x\n", "121 characters")
        self.expect("docs/a.md", "| " + "x" * 200 + " |\n", "x " * 70 + "x\n", "141 characters")
        self.expect("docs/a.md", "* **Bold** text\n\n* *slanted* text\n", "* *Bold** text\n", "tears")
        self.expect("docs/a.md", "ICRA 2019\n", "on 2026-11-22\n", "date 2026-11-22")
        self.assertEqual(complaints({"docs/notebook/a.md": "on 2026-11-22\n"}), [])

    def test_the_notebook_may_name_what_is_gone_but_not_link_to_it(self):
        page = "docs/notebook/a.md"
        self.expect(page, "`facet walk --gone`, `apps/walk.cpp`, `mesh.gone`\n", "[x](gone.md)\n", "gone.md")
        self.expect(page, "[m](../math.md), section 1\n", "[m](../math.md), section 4\n", "no section 4")


class IndexTest(unittest.TestCase):
    def test_anchors_are_those_of_github(self):
        self.assertEqual(slug("2.1 The `x_y` of [A](b.md), again"), "21-the-x_y-of-a-again")

    def test_option_keys_are_those_that_the_program_prints(self):
        program = os.environ.get("FACET_PROGRAM", "")
        if not os.path.exists(program):
            self.skipTest("no program")
        if os.path.getmtime(program) < max(path.stat().st_mtime for path in (ROOT / "src").rglob("*.h")):
            self.skipTest("the program was built before the sources changed")
        texts = [subprocess.run([program, "config", "--all"], capture_output=True, text=True, check=True).stdout]
        listed = subprocess.run([program, "simulate", "--list"], capture_output=True, text=True)
        if listed.returncode == 0:
            texts.append(listed.stdout.split("\n\n", 1)[1])
        keys, parents = set(), []
        for line in "\n".join(texts).split("\n"):
            match = re.match(r"( *)([a-z]\w*):(.*)", line)
            if match:
                parents = parents[:len(match.group(1)) // 2] + [match.group(2)]
                if match.group(3).split("#")[0].strip():
                    keys.add(".".join(parents))
        known = Index(ROOT).keys
        self.assertEqual(keys - known, set())
        if len(texts) == 2:
            self.assertEqual(known - keys, set())


if __name__ == "__main__":
    unittest.main()
