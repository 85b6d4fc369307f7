"""Text that may name things, for scripts/check_references.py: documents, comments, and messages of the programs."""

import ast
import bisect
import io
import re
import tokenize
from dataclasses import dataclass

FOLDERS = ("src", "apps", "bench", "studies", "python", "ros1", "examples", "scripts", "docs", "config", "cmake", "testdata",
           "debian", ".ci")
NOTEBOOK = "docs/notebook/"


@dataclass
class Passage:
    """Text that belongs together, with the lines it comes from."""

    path: str
    kind: str  # markdown, notebook, comment or message
    lines: list  # of numbers
    text: str

    def line_at(self, offset):
        starts = [0]
        for line in self.text.split("\n")[:-1]:
            starts.append(starts[-1] + len(line) + 1)
        return self.lines[bisect.bisect_right(starts, offset) - 1]


# A raw string, a string, a character (but not the mark between digits), a comment.
CPP_TOKEN = re.compile(r'''
    R"\((?s:.*?)\)" | "(?:\\.|[^"\\\n])*" | (?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'
    | //[^\n]* | /\*(?s:.*?)\*/''', re.VERBOSE)


def cpp_comments(text):
    for match in CPP_TOKEN.finditer(text):
        if match.group()[:2] in ("//", "/*"):
            first = text.count("\n", 0, match.start()) + 1
            for number, line in enumerate(match.group().split("\n"), first):
                yield number, re.sub(r"^\s*(?://[/!]?<?|/\*+|\*+/?)|\*/$", "", line)


def python_comments(text):
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            yield token.start[0], token.string.lstrip("#!")
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node, False):
            string = node.body[0].value
            yield from enumerate(string.value.split("\n"), string.lineno)


def hash_comments(text):
    for number, line in enumerate(text.split("\n"), 1):
        match = re.search(r"(?:^|\s)#!?(.*)$", line)
        if match:
            yield number, match.group(1)


def comments_of(path, text):
    if path.suffix in (".h", ".cpp"):
        return cpp_comments(text)
    if path.suffix == ".py":
        return python_comments(text)
    if path.suffix in (".sh", ".cmake", ".yaml") or path.name in ("CMakeLists.txt", "Makefile", "run"):
        return hash_comments(text)
    return ()


def messages_of(path, text):
    """What a program says to its user: string literals outside of tests."""
    if path.suffix in (".h", ".cpp") and path.parts[0] in ("src", "apps") and not path.stem.endswith("_test"):
        for match in CPP_TOKEN.finditer(text):
            if match.group()[0] in 'R"':
                yield text.count("\n", 0, match.start()) + 1, match.group().lstrip("R").strip('"()')


def passages_of(index, path):
    name = str(path)
    if path.suffix == ".md":
        text = index.text(path)
        kind = "notebook" if name.startswith(NOTEBOOK) else "markdown"
        yield Passage(name, kind, list(range(1, text.count("\n") + 2)), text)
        return
    if path.parts[0] not in FOLDERS and len(path.parts) > 1:
        return
    lines = []
    for number, line in sorted(set(comments_of(path, index.text(path)))):
        if lines and number > lines[-1][0] + 1:
            yield Passage(name, "comment", [n for n, _ in lines], "\n".join(t for _, t in lines))
            lines = []
        lines.append((number, line))
    if lines:
        yield Passage(name, "comment", [n for n, _ in lines], "\n".join(t for _, t in lines))
    for number, line in messages_of(path, index.text(path)):
        yield Passage(name, "message", list(range(number, number + line.count("\n") + 1)), line)


def blank(pattern, text):
    return re.sub(pattern, lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def code_in(passage):
    """Offset and text of what is code: all of a comment or message; spans and fenced lines of a document."""
    if passage.kind in ("comment", "message"):
        yield 0, passage.text
        return
    text = passage.text
    for fence in re.finditer(r"(?ms)^\s*```\w*\n(.*?)^\s*```", text):
        for line in re.finditer(r"(?:[^\n]*\\\n)*[^\n]+", fence.group(1)):
            yield fence.start(1) + line.start(), line.group()
    text = blank(r"(?ms)^\s*```.*?^\s*```", text)
    for span in re.finditer(r"`([^`]+)`", text):
        yield span.start(1), span.group(1)
