#!/usr/bin/env python3
"""Fails where a document or a comment names something that is not there.

  scripts/check_references.py [--root FOLDER]

Looked at: every Markdown file; the comments of src, apps, bench, studies, examples, scripts, config, testdata, cmake
and the build files; and what the programs say to their users (files and option keys in strings). Looked for: files and
folders, programs and the commands of `facet`, their options, option keys, tests, presets and make targets, sections and
equations of documents, links and anchors, and in documents the names of code. docs/notebook/ names earlier versions:
there only links and sections are checked. Besides, in Markdown: phrases that only the authors understand, torn
marks of bold text, lines over 120 characters (tables and links aside), and dates outside of the notebook. Prints
file:line and what is missing; exit code 1 if anything is. Needs no build.
"""

import argparse
import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from reference_index import Index  # noqa: E402
from reference_text import FOLDERS, NOTEBOOK, blank, code_in, passages_of  # noqa: E402

MAX_COLUMNS = 120
DOCUMENTS = ("markdown", "notebook")
DERIVATIONS = "docs/math.md"  # has the equations that comments cite by number alone

# Said by the authors to each other; what they mean is said plainly instead.
PHRASES = [
    (r"\bcode\s+not\s+kept\b", "measured with a program that was not committed"),
    (r"\(by\s+hand\b|\bby\s+hand[,;)]", "measured with a program that was not committed"),
    (r"\b[Ii]ssues?\s+[A-Z]\b", "the part of the system"),
    (r"\b[Ff]or\s+sessions\b", "for a long time"),
    (r"\b(?:last|this)\s+stop\b", "the version"),
]
# Also plain English, so they are looked for in documents only.
DOCUMENT_PHRASES = PHRASES + [
    (r"\bby\s+hand\b", "measured with a program that was not committed, drawn manually"),
    (r"\basked\b", "target, required"),
    (r"\bmissed\b", "not met"),
    (r"\bolder(?=\s*[),;.:|]| figure)|\(older\b", "not measured again since version X"),
]
DATE = r"\b20\d\d-\d\d(?:-\d\d)?\b|\b(?:January|February|March|April|May|June|July|August|September|October|November|" \
       r"December)\s+20\d\d\b"

# Programs of others: their options are not ours to check.
FOREIGN = r"cmake|ctest|git|perf|timeout|taskset|callgrind|valgrind|clang-format|clang-tidy|apt-get|gcc|sbatch|g\+\+"
FOREIGN_FILES = {"immintrin.h", "OpenCVConfig.cmake"}
FOREIGN_NAMES = {"normal_distribution", "common_interfaces", "rmw_cyclonedds_cpp", "ros_discovery_info", "ROS_LOCALHOST_ONLY",
                 "ROS_AUTOMATIC_DISCOVERY_RANGE"}
PLACEHOLDER = r"[a-z](?:_\w+)?\.\w+"  # x.cpp and x_test.cpp stand for any file
DATA_SUFFIXES = ("csv", "json", "md", "ply", "sigma", "png", "tum", "yaml", "yml", "txt", "html", "svg", "py", "sh", "h",
                 "cpp", "cmake", "glb", "obj", "jpg")


# What is checked. Each check yields offsets into the passage and what is wrong there.


def check_paths(index, passage):
    text = blank(r"https?://\S+", blank(r"\]\([^)]*\)", passage.text))
    named = re.compile(r"(?<![\w/.~$}*-])(?:" + "|".join(map(re.escape, FOLDERS)) + r")/[\w./*{},+-]*")
    for match in named.finditer(text):
        for path in expand_braces(match.group()):
            path = re.sub(r"[.,:;{}-]+$", "", path)
            if not index.has_path(path):
                yield match.start(), f"no file or folder {path}"
    modules = sorted(p.split("/")[2] for p in index.folders if re.fullmatch(r"src/facet/\w+", p))
    named = re.compile(r"(?<![\w/.*-])(?:facet/)?(?:" + "|".join(modules) + r")/\w+(?:\.\w+)?") if modules else None
    for match in named.finditer(text) if named else ():
        path = "src/facet/" + match.group().removeprefix("facet/")
        if not index.has_path(path) and (Path(path).suffix in (".h", ".cpp") or match.group().startswith("facet/")):
            yield match.start(), f"no file {path}"
    if passage.kind == "message":
        return  # files of results have such names
    for match in re.finditer(r"(?<![\w/.*<{}$-])[A-Za-z_][\w-]*\.(?:md|py|sh|h|cpp|cmake)\b(?![\w(])", text):
        if match.group() not in index.names | FOREIGN_FILES and not re.fullmatch(PLACEHOLDER, match.group()):
            yield match.start(), f"no file {match.group()}"


def expand_braces(path):
    match = re.search(r"\{([^{}]*,[^{}]*)\}", path)
    if not match:
        return [path]
    before, after = path[:match.start()], path[match.end():]
    return [p for part in match.group(1).split(",") for p in expand_braces(before + part + after)]


def check_programs(index, passage):
    for match in re.finditer(r"(?<![\w/-])build/(?:(bench|studies|tests)/)?([\w*]+)(?![\w/])", passage.text):
        folder, name = match.groups()
        if "*" in name or (not folder and name in ("bench", "studies", "tests", "python", "packages")):
            continue
        if name not in index.programs:
            yield match.start(), f"no program {match.group()}"
        elif folder in ("bench", "studies") and not any(p.startswith(f"{folder}/{name}.") for p in index.paths):
            yield match.start(), f"program {name} is not in {folder}/"
    for begin, code in code_in(passage):
        for match in re.finditer(r"(?<![\w.:-])facet\s+([a-z][\w-]*)", code):
            if match.group(1) not in index.commands and (passage.kind in DOCUMENTS or is_command(passage, match)):
                yield begin + match.start(), f"facet has no command '{match.group(1)}'"
        for match in re.finditer(r"(?:^|[`\s])make\s+([a-z][\w-]*)", code):
            if passage.kind in DOCUMENTS and match.group(1) not in index.make_targets:
                yield begin + match.start(), f"no make target '{match.group(1)}'"
        for match in re.finditer(r"--preset[ =]([a-z][\w-]*)|scripts/build\.sh ([a-z][\w-]*)", code):
            if (match.group(1) or match.group(2)) not in index.presets:
                yield begin + match.start(), f"no preset '{match.group(1) or match.group(2)}'"
        yield from ((begin + at, text) for at, text in check_tests(index, code))


def is_command(passage, match):
    """Whether a comment means the program and not the word: `facet run`."""
    return passage.text[match.start() - 1:match.start()] in ("`", "'")


def check_tests(index, code):
    for match in re.finditer(r"\bctest\b[^\n`]*?\s-R\s+('[^']+'|\"[^\"]+\"|[^\s`),]+)", code):
        pattern = match.group(1).strip("'\"")
        for part in pattern.split("|"):
            if not any(re.search(part, test) for test in index.tests):
                yield match.start(), f"no test matches '{part}'"
    for match in re.finditer(r"\bctest\b[^\n`]*?\s(?:-L|--label-regex)\s+(\w+)", code):
        if match.group(1) not in index.labels:
            yield match.start(), f"no test has the label '{match.group(1)}'"


def check_options(index, passage):
    """Each option belongs to the program named before it, or, where none is named, to any of ours."""
    own = sorted({Path(p).stem for p in index.paths if re.match(r"(?:bench|studies)/\w+\.(?:cpp|py)$", p)})
    studies = "|".join(own)
    program = re.compile(
        r"\bfacet\s+(?P<command>[a-z]\w*)|(?:(?:scripts|studies)/)?(?P<script>[a-z]\w*)\.(?:py|sh)|"
        + (rf"\b(?P<study>{studies})\b(?!\.(?:h|cpp))|" if studies else "")
        + rf"(?P<foreign>\b(?:{FOREIGN}|make)(?=\s))")
    option = re.compile(r"(?<![\w=-])--[a-z][\w-]*")
    for begin, code in code_in(passage):
        mentions = [(m.start(), m) for m in program.finditer(code)]
        for match in option.finditer(code):
            before = [m for at, m in mentions if at < match.start()]
            known, owner = options_after(index, before[-1] if before else None)
            name = match.group().rstrip("-")
            if known is not None and name not in known and not name.startswith("--benchmark_"):
                yield begin + match.start(), f"{owner} has no option {name}"


def options_after(index, mention):
    groups = mention.groupdict() if mention else {}
    if groups.get("foreign"):
        return None, ""
    if groups.get("command"):
        return index.commands.get(groups["command"]), f"facet {groups['command']}"
    name = groups.get("script") or groups.get("study")
    own = index.options_of(name) if name else None
    if own is None:
        return index.all_options | {"--preset", "--prefix"}, "the repository"
    # Scripts hand what they do not know to facet.
    return own | index.all_options if groups.get("script") else own, name


def check_keys(index, passage):
    component = r"[a-z*][a-z0-9_*]*"
    dotted = re.compile(rf"(?<![\w./\\-])(--set[ =])?'?({component}(?:\.{component})*)(?![\w(/:-])")
    for begin, code in code_in(passage):
        for match in dotted.finditer(code):
            key = match.group(2)
            if match.group(1) and passage.kind != "message":
                if key != "key" and not key.startswith("key.") and not index.has_key(key, anywhere=True):
                    yield begin + match.start(), f"no option key {key}"
                continue
            parts = key.split(".")
            if len(parts) < 2 or parts[-1] in DATA_SUFFIXES:
                continue
            # In comments two words with a dot between them may be C++.
            is_meant = parts[0] in index.top_groups and (len(parts) > 2 or passage.kind in DOCUMENTS)
            is_part = passage.kind in DOCUMENTS and parts[0] in index.group_names
            if is_meant and not index.has_key(key) and not index.has_key(key, anywhere=True) or (
                    is_part and not is_meant and not index.has_key(key, anywhere=True)):
                yield begin + match.start(), f"no option key {key}"


EQUATIONS = r"(?P<equations>\([\w.]+\)(?:(?:,\s+and\s+|,\s+|\s+and\s+|\s+to\s+)\([\w.]+\))*)"
NUMBERS = r"\d+(?:\.\d+)*(?:(?:,\s+|\s+and\s+|,\s+and\s+|\s+to\s+|\s*-\s*)\d+(?:\.\d+)*)*"


def find_document(index, passage, name):
    base = Path(passage.path).parent
    for path in (base / name, Path(name), Path("docs") / name, Path(NOTEBOOK) / name):
        parts = []
        for part in path.parts:
            parts = parts[:-1] if part == ".." else parts + [part]
        if str(Path(*parts)) in index.paths if parts else False:
            return str(Path(*parts))
    return None


def check_sections(index, passage):
    text = passage.text
    file = r"(?P<file>[\w./-]+\.md)(?:#[\w-]*)?\)?`?"
    cited = [
        (re.compile(file + r",?\s+(?:sections?|§)\s+(?P<numbers>" + NUMBERS + ")"), "section"),
        (re.compile(file + r",\s+(?P<numbers>\d+\.\d+)"), "section"),
        (re.compile(r"\b[Ss]ections?\s+(?P<numbers>" + NUMBERS + r")\s+(?:of|in)\s+`?" + file), "section"),
        (re.compile(file + r",?\s+step\s+(?P<numbers>\d+)"), "step"),
        (re.compile(file + r',?\s+"(?P<title>[^"]+)"'), "heading"),
        (re.compile(r"\b(?:[Ee]quations?|[Ee]qs?\.)\s+" + EQUATIONS + r"\s+(?:of|in)\s+" + file), "equation"),
        (re.compile(file + r",?\s+(?:equations?|eqs?\.)\s+(?P<equations>\([\w.]+\))"), "equation"),
    ]
    for pattern, kind in cited:
        for match in pattern.finditer(text):
            path = find_document(index, passage, match.group("file"))
            if not path:
                yield match.start(), f"no document {match.group('file')}"
                continue
            yield from ((match.start(), m) for m in missing_parts(index.document(path), path, kind, match.groupdict()))
    if passage.kind == "comment":
        for match in re.finditer(r"\b[Ee]quations?\s+" + EQUATIONS, text):
            if DERIVATIONS in index.paths and re.match(r"\(\d+\.", match.group("equations")):
                lost = missing_parts(index.document(DERIVATIONS), DERIVATIONS, "equation", match.groupdict())
                yield from ((match.start(), m) for m in lost)
        return
    own = index.document(passage.path)
    for match in re.finditer(r"\b[Ss]ections?\s+(?P<numbers>" + NUMBERS + r")(?!\s+(?:of|in)\b)", text):
        of_another = re.search(r"\.md\)?`?,?\s*$", text[:match.start()])
        if own.sections and not of_another:
            lost = missing_parts(own, passage.path, "section", match.groupdict())
            yield from ((match.start(), m) for m in lost)


def missing_parts(document, path, kind, named):
    if kind == "heading":
        if not document.has_heading(named["title"]):
            yield f'{path} has no heading "{" ".join(named["title"].split())}"'
        return
    if kind == "equation":
        for number in re.findall(r"\(([\w.]+)\)", named["equations"]):
            known = number in document.equations
            if number.endswith(".x"):
                known = any(e.startswith(number[:-1]) for e in document.equations)
            if not known:
                yield f"{path} has no equation ({number})"
        return
    known = document.sections if kind == "section" else document.steps
    for number in re.findall(r"\d+(?:\.\d+)*", named["numbers"]):
        if number not in known:
            yield f"{path} has no {kind} {number}"


def check_links(index, passage):
    if passage.kind == "comment":
        return
    text = blank(r"`[^`\n]*`", blank(r"(?ms)^\s*```.*?^\s*```", passage.text))
    for match in re.finditer(r"\]\(\s*<?([^)\s>]+)>?[^)]*\)|^\[[^\]]+\]:\s*(\S+)", text, re.M):
        target = match.group(1) or match.group(2)
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        parts = [] if name.startswith("/") else list(Path(passage.path).parent.parts)
        for part in Path(name).parts:
            parts = parts[:-1] if part == ".." else parts + [part]
        path = "/".join(parts) if name else passage.path
        if path not in index.paths and path not in index.folders and path:
            yield match.start(), f"link to {target}: no such file"
        elif anchor and path.endswith(".md") and anchor not in index.document(path).anchors:
            yield match.start(), f"link to {target}: no such heading"


SYMBOL = r"_\w+|[A-Za-z](?:_\w{1,3})+|\w+_"  # of mathematics, or a part of names: T_AB, _px


def check_names(index, passage):
    """A code span that is one name of code, and any name with an underscore in a comment, is a word of the code."""
    if passage.kind == "comment":
        name = re.compile(r"(?<![\w:/.])[a-z]{3,}(?:_[a-z0-9]{3,})+\b(?![*/-]|\.\w)")
        named = [(m.start(), m.group()) for m in name.finditer(passage.text)]
    else:
        named = [(at, code.strip().removesuffix("()")) for at, code in code_in(passage)]
        named = [(at, n) for at, n in named if re.fullmatch(r"\w+(?:::\w+)*", n) and re.search(r"_|::|[a-z][A-Z]", n)]
    for at, name in named:
        for part in name.split("::"):
            if part not in index.words | FOREIGN_NAMES and not re.fullmatch(SYMBOL, part):
                yield at, f"nothing in the code is called {part}"


def check_style(index, passage):
    phrases = PHRASES if passage.kind == "comment" else DOCUMENT_PHRASES
    for pattern, instead in phrases:
        for match in re.finditer(pattern, passage.text):
            yield match.start(), f'"{" ".join(match.group().split())}" is a private phrase; say it plainly ({instead})'
    if passage.kind == "comment":
        return
    if passage.kind == "markdown" and (passage.path.startswith("docs/") or "/" not in passage.path):
        for match in re.finditer(DATE, passage.text):
            yield match.start(), f"date {match.group()} outside of {NOTEBOOK}"
    for match in re.finditer(r"^\s*\* \*(?!\*)[^*\n]+\*\*", passage.text, re.MULTILINE):
        yield match.start(), "a blank tears the mark of bold text apart"
    offset = 0
    for line in passage.text.split("\n"):
        is_free = line.lstrip().startswith(("|", "![")) or re.fullmatch(r"\s*\S*\]\(\S+\)\S*|\s*\S+", line)
        if len(line) > MAX_COLUMNS and not is_free:
            yield offset, f"{len(line)} characters, at most {MAX_COLUMNS}"
        offset += len(line) + 1


ANYWHERE = [check_sections, check_links, check_style]
CHECKS = {
    "markdown": [check_paths, check_programs, check_options, check_keys, check_names, *ANYWHERE],
    "comment": [check_paths, check_programs, check_options, check_keys, check_names, *ANYWHERE],
    "notebook": ANYWHERE,
    "message": [check_paths, check_keys],
}


def findings(root):
    index = Index(root)
    for path in index.files:
        if path.name in ("check_references.py", "check_references_test.py", "retired_options.cpp"):
            continue  # they name what is to be found, or what was there once
        for passage in passages_of(index, path):
            for check in CHECKS[passage.kind]:
                for offset, message in check(index, passage):
                    yield passage.path, passage.line_at(offset), message


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parent.parent)
    found = sorted(set(findings(parser.parse_args().root)))
    for path, line, message in found:
        print(f"{path}:{line}: {message}")
    print(f"references: {len(found)} that lead nowhere" if found else "references: all there")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
