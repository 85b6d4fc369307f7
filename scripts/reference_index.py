"""What can be named in this repository, for scripts/check_references.py: files, programs and their options, option
keys, tests, presets, and the headings of documents. All of it is read from the sources; nothing has to be built.
"""

import fnmatch
import json
import os
import re
from functools import cached_property
from pathlib import Path

IGNORED_FOLDERS = {".git", "__pycache__", "runs", "bench-out", "node_modules"}
CODE_SUFFIXES = {".h", ".cpp", ".py", ".sh", ".cmake", ".txt", ".yaml", ".json"}
# Roots of the option structs, and the program that prints their keys.
ROOT_OPTIONS = {"VioOptions": "facet config", "SimulatorOptions": "facet simulate --list"}


def is_ignored(name):
    return name in IGNORED_FOLDERS or name.startswith("build")


def list_files(root):
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = [name for name in folders if not is_ignored(name)]
        found += [Path(folder, name).relative_to(root) for name in names]
    return sorted(found)


def closing_brace(text, begin):
    """The place after the brace that closes the one at `begin`."""
    depth = 0
    for match in re.compile(r"[{}]").finditer(text, begin):
        depth += 1 if match.group() == "{" else -1
        if depth == 0:
            return match.end()
    return len(text)


def slug(heading):
    """The anchor that GitHub makes of a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text.replace("`", "")).replace(" ", "-")


class Document:
    """A Markdown file: its headings and the numbers of its sections, equations and steps."""

    def __init__(self, text):
        prose = re.sub(r"(?ms)^\s*```.*?^\s*```", "", text)
        self.headings = [re.sub(r"\s*#*$", "", h) for h in re.findall(r"(?m)^#{1,6}\s+(.*)$", prose)]
        self.sections = {m.group(1) for h in self.headings if (m := re.match(r"(\d+(?:\.\d+)*)\.?\s", h))}
        self.equations = set(re.findall(r"\\tag\{([\w.]+)\}", text)) | set(re.findall(r"\((\d+\.\d+[a-z]?)\)", prose))
        self.steps = set(re.findall(r"(?m)^\s*(\d+)\.\s", prose))
        self.anchors, seen = set(), {}
        for heading in self.headings:
            name = slug(heading)
            seen[name] = seen.get(name, -1) + 1
            self.anchors.add(f"{name}-{seen[name]}" if seen[name] else name)

    def has_heading(self, title):
        title = " ".join(title.split()).rstrip(".,").lower()
        names = [h.lower() for h in self.headings]
        return any(h.startswith(title) or re.sub(r"^\d[\d.]*\s+", "", h).startswith(title) for h in names)


class Index:
    def __init__(self, root):
        self.root = Path(root)
        self.files = list_files(self.root)
        self.paths = {str(path) for path in self.files}
        self.folders = {str(parent) for path in self.files for parent in path.parents} - {"."}
        self.names = {path.name for path in self.files}
        self.stems = {str(path.with_suffix("")) for path in self.files} | {
            re.sub(r"(_test|_bench)?\.\w+$", "", str(path)) for path in self.files}
        self._documents = {}

    def text(self, path):
        return (self.root / path).read_text(encoding="utf-8", errors="replace")

    def document(self, path):
        if path not in self._documents:
            self._documents[path] = Document(self.text(path))
        return self._documents[path]

    def has_path(self, path):
        """A file, a folder, a file without its suffix (a.h and a.cpp), or a pattern that some file matches."""
        path = path.rstrip("/")
        if "*" in path:
            return any(fnmatch.fnmatch(known, path) for known in self.paths)
        return path in self.paths or path in self.folders or path in self.stems

    # Programs and what they are called with.

    @cached_property
    def cmake(self):
        texts = [self.text(p) for p in self.files if p.name == "CMakeLists.txt" or p.suffix == ".cmake"]
        return "\n".join(re.sub(r"#.*", "", text) for text in texts)

    @cached_property
    def programs(self):
        """Targets that can be run, by name."""
        names = set(re.findall(r"add_executable\(\s*([\w-]+)", self.cmake))
        names |= set(re.findall(r"facet_add_test\(\s*NAME\s+([\w-]+)", self.cmake))
        for loop in re.finditer(r"foreach\(\s*(\w+)([^)]*)\)(.*?)endforeach", self.cmake, re.S):
            variable, words, body = loop.groups()
            for name in re.findall(r"(?:add_executable\(|NAME)\s*([\w-]*\$\{" + variable + r"\}[\w-]*)", body):
                names |= {name.replace("${" + variable + "}", word) for word in words.split()}
        return names

    @cached_property
    def labels(self):
        return set(re.findall(r"\bLABELS?\s+\"?([\w]+)", self.cmake)) | {"unit"}

    @cached_property
    def tests(self):
        """Names as CTest knows them, as far as they can be read from the sources."""
        names = set(re.findall(r"add_test\(\s*NAME\s+([\w-]+)", self.cmake))
        for path in self.files:
            if path.suffix == ".cpp":
                text = self.text(path)
                cases = re.findall(r"\bTEST(?:_[FP])?\(\s*(\w+)\s*,\s*(\w+)", text)
                names |= {f"{suite}.{case}" for suite, case in cases}
                for prefix, suite in re.findall(r"INSTANTIATE_TEST_SUITE_P\(\s*(\w+)\s*,\s*(\w+)", text):
                    names |= {f"{prefix}/{suite}.{case}/0" for s, case in cases if s == suite}
        return names

    @cached_property
    def presets(self):
        path = "CMakePresets.json"
        return {p["name"] for p in json.loads(self.text(path))["configurePresets"]} if path in self.paths else set()

    @cached_property
    def make_targets(self):
        return set(re.findall(r"(?m)^([\w-]+):", self.text("Makefile"))) if "Makefile" in self.paths else set()

    @cached_property
    def commands(self):
        """Options of each command of `facet`, by its name."""
        found = {}
        for path in self.files:
            if path.parts[0] == "apps" and path.suffix == ".cpp" and not path.stem.endswith("_test"):
                text = self.text(path)
                for name in re.findall(r"add_subcommand\(\s*\"([\w-]+)\"", text):
                    found.setdefault(name, set()).update(self._options_of(text))
        return found

    def _options_of(self, text):
        listed = re.findall(r"(?:add_option|add_flag|set_\w+_flag|add_argument)\w*\(\s*\"([^\"]+)\"", text)
        return {o.lstrip("!").split("{")[0] for names in listed for o in names.split(",") if "--" in o} | {"--help"}

    def options_of(self, program):
        """Options of a program of bench/ or studies/, or of a script; None: unknown program."""
        for folder in ("bench", "studies", "scripts", "ros1/test"):
            for suffix in (".cpp", ".py", ".sh", ""):
                path = f"{folder}/{program}{suffix}"
                if path in self.paths:
                    text = self.text(path)
                    if path.endswith((".sh", ".py")):
                        return self._options_of(text) | set(re.findall(r"(?<![\w-])--[a-z][\w-]*", text))
                    return self._options_of(text)
        return None

    @cached_property
    def all_options(self):
        found = {"--version"}
        for options in self.commands.values():
            found |= options
        for path in self.files:
            if path.parts[0] in ("bench", "studies", "scripts", "ros1"):
                found |= self.options_of(path.stem) or set()
            if path.parts[0] == "dds" and path.suffix == ".cpp":
                found |= set(re.findall(r"\"(--[a-z][\w-]*)\"", self.text(path)))
        return found

    # Option keys.

    @cached_property
    def _visited(self):
        """For each options struct: its fields, and the type of each of its groups."""
        found = {}
        for path in self.files:
            if path.parts[0] in ("src", "apps") and path.suffix in (".h", ".cpp") and not path.stem.endswith("_test"):
                text = re.sub(r"//.*", "", self.text(path))
                for match in re.finditer(r"\b(?:struct|class)\s+(\w+)[^;{()]*\{", text):
                    body = text[match.end() - 1:closing_brace(text, match.end() - 1)]
                    visit = re.search(r"\bVisit\(\s*\w+\s*&\s*(\w+)\s*\)[^{;]*\{", body)
                    if not visit:
                        continue
                    calls = body[visit.end() - 1:closing_brace(body, visit.end() - 1)]
                    fields = re.findall(visit.group(1) + r"\.(?:Field|Choice)\(\s*\"(\w+)\"", calls)
                    groups = {}
                    for name, member in re.findall(visit.group(1) + r"\.Group\(\s*\"(\w+)\"\s*,\s*([\w.]+)", calls):
                        kind = re.search(r"\b([A-Z]\w*)\s+" + re.escape(member) + r"\b\s*(?:[;={])", body)
                        groups[name] = kind.group(1) if kind else None
                    found[match.group(1)] = (fields, groups)
        return found

    def _keys_of(self, kind, prefix=""):
        fields, groups = self._visited.get(kind, ([], {}))
        for field in fields:
            yield prefix + field
        for name, child in groups.items():
            yield from self._keys_of(child, prefix + name + ".")

    @cached_property
    def keys(self):
        """Full option keys of `facet run` and `facet simulate`."""
        return {key for kind in ROOT_OPTIONS for key in self._keys_of(kind)}

    @cached_property
    def key_groups(self):
        """Every group, as a full path: estimator, estimator.solver, ..."""
        return {key.rsplit(".", n)[0] for key in self.keys for n in range(1, key.count(".") + 1)}

    @cached_property
    def top_groups(self):
        return {key.split(".")[0] for key in self.key_groups}

    @cached_property
    def group_names(self):
        return {name for group in self.key_groups for name in group.split(".")}

    def has_key(self, key, anywhere=False):
        """A full key or group, perhaps with `*`; `anywhere`: without its first groups, too."""
        known = self.keys | self.key_groups
        if anywhere:
            known = {k.split(".", n)[n] for k in known for n in range(k.count(".") + 1)}
        return any(fnmatch.fnmatchcase(k, key) for k in known) if "*" in key else key in known

    # Words.

    @cached_property
    def words(self):
        """Every word of the code without its comments, and every part of a file's path."""
        found = {part for path in self.files for part in re.split(r"[/.]", str(path))}
        for path in self.files:
            if path.suffix in CODE_SUFFIXES or path.name in ("Makefile", "run"):
                comment = r"//[^\n]*" if path.suffix in (".h", ".cpp") else r"(?m)^\s*#[^\n]*"
                found.update(re.findall(r"\w+", re.sub(comment, "", self.text(path))))
        return found
