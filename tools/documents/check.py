#!/usr/bin/env python3
"""Checks what documents claim about the tree; prints a line for each claim that does not hold.

Relative links lead somewhere. Tests and code that a document names in `backticks` exist. Decisions that code cites are written down. Every
room has a README.md; every other folder with more than three source files has one, or that of a folder above says what it holds.
"""
import argparse
import collections
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")
TEST = re.compile(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)")
NAMED_TEST = re.compile(r"`(?:\w+/)?([A-Z]\w+)\.(\w*\*?)`")
CODE_NAME = re.compile(r"`((?:\w+::)*[A-Z][a-z]\w+(?:::\w+)*)`")
CITED = re.compile(r"\bD([1-9]\d?|0\d)\b(?=[ ,.;:)])|\bdecisions? (\d{1,2})\b|decisions/(\d{4})")
ROOM = re.compile(r"^\s*add_(?:room|node)\(", re.M)
SOURCES = {".cpp", ".hpp", ".py", ".mjs", ".proto"}
# In these every name of code is checked, not only tests: they say which code implements an equation and which test holds it.
LEDGERS = ("libs/vps/LEDGER.md", "libs/vps/README.md")


def tracked(root):
    names = subprocess.check_output(["git", "-C", root, "ls-files", "-co", "--exclude-standard"], text=True)
    return [root / name for name in names.splitlines() if (root / name).is_file()]


def broken_links(root, path, text):
    for target in LINK.findall(text):
        if re.match(r"\w+:|#", target):
            continue
        if not (path.parent / target.split("#")[0]).exists():
            yield f"{path.relative_to(root)}: link to a missing file, {target}"


def unknown_tests(root, path, text, tests):
    suites = {suite for suite, _ in tests}
    for suite, name in NAMED_TEST.findall(text):
        # Others, such as `Node.Wait`, are no tests: a test's name begins with a known suite or ends in a star.
        if suite not in suites and not name.endswith("*"):
            continue
        start = name.rstrip("*")
        if not any(s == suite and (n == start or (name.endswith("*") and n.startswith(start))) for s, n in tests):
            yield f"{path.relative_to(root)}: no test is called {suite}.{name}"


def unknown_code(root, path, text, words):
    for name in CODE_NAME.findall(text):
        missing = [part for part in name.split("::") if part not in words]
        if missing:
            yield f"{path.relative_to(root)}: no code is called {name}"


def unwritten_decisions(root, path, text, decisions):
    for letter, number, file in CITED.findall(text):
        name = f"D{int(letter):02}" if letter else f"{int(number or file):04}"
        if name not in decisions:
            yield f"{path.relative_to(root)}: decision {name} is not in docs/decisions"


def unexplained_folders(root, sources):
    """Folders with more than three source files, without a README.md, that no README.md above names as `folder/` or `folder`."""
    for folder, count in sorted(collections.Counter(path.parent for path in sources).items()):
        if count <= 3 or folder == root or (folder / "README.md").exists():
            continue
        above = [parent / "README.md" for parent in folder.parents if parent == root or root in parent.parents]
        named = re.compile(rf"(?<!\w){re.escape(folder.name)}(?:/|`|\])")
        if not any(readme.exists() and named.search(readme.read_text(encoding="utf-8")) for readme in above):
            yield f"{folder.relative_to(root)}: {count} source files, and no README.md says what for"


def findings(root):
    files = tracked(root)
    texts = {path: path.read_text(encoding="utf-8", errors="ignore") for path in files
             if path.suffix in SOURCES | {".md"} or path.name == "CMakeLists.txt"}
    sources = {path: text for path, text in texts.items() if path.suffix in SOURCES}
    tests = {pair for text in sources.values() for pair in TEST.findall(text)}
    words = {word for text in sources.values() for word in re.findall(r"\w+", text)}
    decisions = {path.name.split("-")[0] for path in (root / "docs/decisions").glob("*-*.md")}
    for path, text in texts.items():
        name = str(path.relative_to(root))
        if path.suffix == ".md":
            yield from broken_links(root, path, text)
            yield from unknown_tests(root, path, text, tests)
            if name in LEDGERS:
                yield from unknown_code(root, path, text, words)
        if not name.startswith("tools/documents/") and "node_modules" not in name:
            yield from unwritten_decisions(root, path, text, decisions)
        if path.name == "CMakeLists.txt" and ROOM.search(text) and not (path.parent / "README.md").exists():
            yield f"{path.parent.relative_to(root)}: a room without README.md"
    yield from unexplained_folders(root, sources)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    found = list(findings(parser.parse_args().root))
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
