#!/usr/bin/env python3
"""The numeric constants of the contact engine: an inventory, and what each of the tuned ones is worth.

  constants.py --check   changes nothing; names each constant of the engine that docs/performance/vps/constants.csv does not
                         have, has with another value, or has although it is gone; and a page that is not up to date
  constants.py --page    writes docs/performance/vps/constants.md from constants.csv and constants_sensitivity.csv
  constants.py FOLDER    halves and doubles each tuned constant in a copy of the tree in FOLDER, measures the training
                         parts each time and writes constants_sensitivity.csv: some minutes for each constant. --only takes
                         names, with commas between them; --kind free shows whether free ones are

The engine is libs/vps/{multibody,multibody/gap,walk,sampling,surface} without tests and benches. Its constants are all
`constexpr` and `const` numbers with a name that begins with k, those inside functions too. An enumerator is a name and
no figure. A number that stands in an expression without a name of its own cannot be found by a program; where one matters
the inventory has a row with that expression as its name, which then has to occur in the file.

The columns of constants.csv: file, name, value as written, kind, why. Kinds:

  unit or format  array size, bit layout, width of a register, sentinel
  derived         why says from what
  rounding        bound of the rounding of floats
  free            no result depends on it, only time and memory
  tuned           changes results, and was chosen by measuring or by judgement

A name that a file has several times has as many rows, in the file's order.
"""
import argparse
import collections
import csv
import pathlib
import re
import sys

import constants_sensitivity

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = [f"libs/vps/{name}" for name in ("multibody", "multibody/gap", "walk", "sampling", "surface")]
CSV = "docs/performance/vps/constants.csv"
PAGE = "docs/performance/vps/constants.md"
SENSITIVITY = "docs/performance/vps/constants_sensitivity.csv"
COLUMNS = ["file", "name", "value", "kind", "why"]
KINDS = ["tuned", "derived", "rounding", "free", "unit or format"]

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
NUMERIC = r"(?:double|float|int|unsigned|(?:std::)?size_t|(?:std::)?u?int\d+_t)"
DECLARATION = re.compile(rf"\b(?:constexpr|const)\s+{NUMERIC}\s+(?=k[A-Z]\w*\s*(?:\[[^\]]*\]\s*)?[={{])")
DECLARATOR = re.compile(r"\s*(k[A-Z]\w*)\s*(?:\[[^\]]*\]\s*)?=\s*")

Constant = collections.namedtuple("Constant", "file line name value begin end")  # the value is text[begin:end]


def without_comments(text):
    """The same length and lines."""
    return COMMENT.sub(lambda comment: re.sub(r"[^\n]", " ", comment[0]), text)


def squeezed(text):
    return " ".join(text.split())


def end_of_value(text, at):
    """Of an initializer: its first ',' or ';' outside of brackets."""
    depth = 0
    for i in range(at, len(text)):
        if text[i] in "({[":
            depth += 1
        elif text[i] in ")}]":
            depth -= 1
        elif text[i] in ",;" and depth == 0:
            return i
    return len(text)


def constants_of(file, text):
    """In the order of the file."""
    code = without_comments(text)
    for declaration in DECLARATION.finditer(code):
        at = declaration.end()
        while declarator := DECLARATOR.match(code, at):
            begin = declarator.end()
            end = end_of_value(code, begin)
            line = code.count("\n", 0, declarator.start(1)) + 1
            yield Constant(file, line, declarator[1], squeezed(code[begin:end]), begin, end)
            at = end + 1
            if end == len(code) or code[end] == ";":
                break


def sources(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).glob("*.[ch]pp")):
            if not path.stem.endswith(("_test", "_bench")):
                yield path


def constants(root):
    for path in sources(root):
        yield from constants_of(str(path.relative_to(root)), path.read_text(encoding="utf-8"))


def read_rows(path):
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def is_unnamed(row):
    return re.fullmatch(r"k[A-Z]\w*", row["name"]) is None


def findings(root):
    """A line for each problem."""
    rows = read_rows(root / CSV)
    listed = collections.defaultdict(list)
    for number, row in enumerate(rows, start=2):
        where = f"{CSV}:{number}: {row['name']}"
        if row["kind"] not in KINDS:
            yield f"{where}: no kind '{row['kind']}'; take one of: {', '.join(KINDS)}"
        if not row["why"].strip():
            yield f"{where}: say why in the last column"
        if not is_unnamed(row):
            listed[row["file"], row["name"]].append((number, row))
            continue
        path = root / row["file"]
        code = squeezed(without_comments(path.read_text(encoding="utf-8"))) if path.exists() else ""
        if row["name"] not in code:
            yield f"{where}: {row['file']} has no such expression any more; remove the row, or write it as it is now"
        elif row["value"] not in row["name"]:
            yield f"{where}: the value {row['value']} does not occur in it"
    for constant in constants(root):
        where = f"{constant.file}:{constant.line}: {constant.name}"
        if not listed[constant.file, constant.name]:
            yield f"{where} is not in {CSV}; add a row with its value, {constant.value}, a kind and a reason"
            continue
        number, row = listed[constant.file, constant.name].pop(0)
        if row["value"] != constant.value:
            yield (f"{where} is {constant.value}, {CSV}:{number} says {row['value']}; write the new value there, and "
                   "see whether kind and reason still hold")
    for (file, name), gone in listed.items():
        for number, _ in gone:
            yield f"{CSV}:{number}: {name}: {file} has it no more; remove the row"


def cell(text):
    return text.replace("|", "\\|")


def sensitivity_text(row):
    if row["differs"] == "0":
        return f"×{row['factor']}: nothing"
    if not row["p99"]:
        return f"×{row['factor']}: {row['differs']}"
    return f"×{row['factor']}: {row['p99']}, {row['worst']}, {row['places']}"


def sensitivities(rows):
    return "; ".join(sensitivity_text(row) for row in rows if row["queries"] == "cold") or "-"


def page(root):
    rows = read_rows(root / CSV)
    by_name = collections.defaultdict(list)
    for row in read_rows(root / SENSITIVITY):
        by_name[row["file"], row["name"]].append(row)
    count = collections.Counter(row["kind"] for row in rows)
    lines = [
        "# Constants of the contact engine",
        "",
        "Written by `tools/contact/constants.py --page` from [constants.csv](constants.csv), which has every numeric constant of",
        "`libs/vps/{multibody,multibody/gap,walk,sampling,surface}` with its kind and reason; a test (`contact_constants`) fails when",
        "the two differ from the code.",
        "",
        "| kind | what | constants |",
        "|---|---|---|",
    ]
    what = {
        "tuned": "changes results, and was chosen by measuring or by judgement",
        "derived": "follows from others, or from a derivation",
        "rounding": "bound of the rounding of floats",
        "free": "no result depends on it, only time and memory",
        "unit or format": "array size, bit layout, width of a register, sentinel",
    }
    lines += [f"| {kind} | {what[kind]} | {count[kind]} |" for kind in KINDS]
    unnamed = sum(is_unnamed(row) and row["kind"] == "tuned" for row in rows)
    lines += [
        "",
        f"## Tuned: {count['tuned']}",
        "",
        f"At most 25 are wanted. Without a name of its own, quoted with the expression in which it stands: {unnamed}.",
        "",
    ]
    if by_name:
        lines += [
            "The last column, where it was measured ([constants_sensitivity.csv](constants_sensitivity.csv)): the constant halved and",
            "doubled, and what becomes of the training parts' figures, relative to those with the constant as it is: error of the",
            "force at 2 %, 99th percentile and worst, and places read, of cold queries. *Nothing*: no figure of any query changes;",
            "the study looks at force and moment of `fast`, not at planes, gaps, budgets of points and `paper`.",
            "",
        ]
    for folder in FOLDERS:
        tuned = [row for row in rows if row["kind"] == "tuned" and str(pathlib.PurePath(row["file"]).parent) == folder]
        if not tuned:
            continue
        lines += [f"### {folder.removeprefix('libs/vps/')}", "", "| constant | value | why | halved, doubled |",
                  "|---|---|---|---|"]
        for row in tuned:
            measured = sensitivities(by_name[row["file"], row["name"]])
            file = pathlib.PurePath(row["file"])
            link = f"[`{file.name}`](../../../{file})"
            lines.append(f"| `{cell(row['name'])}`, {link} | {cell(row['value'])} | {cell(row['why'])} | {measured} |")
        lines.append("")
    return "\n".join(lines)


def check(root):
    yield from findings(root)
    path = root / PAGE
    if not path.exists() or path.read_text(encoding="utf-8") != page(root):
        yield f"{PAGE}: not up to date; write it with tools/contact/constants.py --page"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", action="store_true")
    what.add_argument("--page", action="store_true")
    what.add_argument("folder", nargs="?", type=pathlib.Path)
    parser.add_argument("--only", help="names of constants, with commas between them")
    parser.add_argument("--kind", choices=KINDS, default="tuned")
    args = parser.parse_args()
    if args.folder:
        names = args.only.split(",") if args.only else None
        constants_sensitivity.measure(ROOT, args.folder.resolve(), args.kind, names)
        return 0
    if args.page:
        (ROOT / PAGE).write_text(page(ROOT), encoding="utf-8")
        return 0
    found = list(check(ROOT))
    print("\n".join(found) or f"ok: {len(read_rows(ROOT / CSV))} constants")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
