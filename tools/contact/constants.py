#!/usr/bin/env python3
"""The numeric constants of the contact engine: an inventory, and what each of the tuned ones is worth.

  constants.py --check   changes nothing; names each constant of the engine that docs/performance/vps/constants.csv does not
                         have, has with another value, or has although it is gone; each limit and indifferent one that was
                         not measured to be it; and a page that is not up to date
  constants.py --page    writes docs/performance/vps/constants.md from constants.csv and constants_sensitivity.csv
  constants.py FOLDER    halves and doubles each constant that was chosen (the first four kinds below) in a copy of the tree
                         in FOLDER, measures the training parts and runs the tests of its room each time, and writes
                         constants_sensitivity.csv: half a minute for each constant. --only takes names, with commas between
                         them; --kind one kind: with free it shows whether those are

The engine is libs/vps/{multibody,multibody/gap,walk,sampling,surface} without tests and benches. Its constants are all
`constexpr` and `const` numbers with a name that begins with k, those inside functions too. An enumerator is a name and
no figure. A number that stands in an expression without a name of its own cannot be found by a program; where one matters
the inventory has a row with that expression as its name, which then has to occur in the file.

The columns of constants.csv: file, name, value as written, kind, why. Kinds:

  tuned           changes results, and was chosen by measuring or by judgement
  indifferent     chosen, too; halved and doubled it changes no figure of the training parts by more than they scatter, and
                  every test of its room holds
  limit           bounds the time of a cycle, or memory; doubled it changes no such figure, and every test of its room holds
  measured        a ratio of times that was measured; why says how
  derived         why says from what
  rounding        bound of the rounding of floats
  free            no result depends on it, only time and memory
  unit or format  array size, bit layout, width of a register, sentinel

A name that a file has several times has as many rows, in the file's order.
"""
import argparse
import collections
import csv
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = [f"libs/vps/{name}" for name in ("multibody", "multibody/gap", "walk", "sampling", "surface")]
CSV = "docs/performance/vps/constants.csv"
PAGE = "docs/performance/vps/constants.md"
SENSITIVITY = "docs/performance/vps/constants_sensitivity.csv"
COLUMNS = ["file", "name", "value", "kind", "why"]
KINDS = {
    "tuned": "changes results, and was chosen by measuring or by judgement",
    "indifferent": "chosen, too; halved and doubled it changes no figure of the training parts by more than they scatter, and every "
                   "test of its room holds",
    "limit": "bounds the time of a cycle, or memory; doubled it changes no such figure, and every test of its room holds",
    "measured": "a ratio of times that was measured",
    "derived": "follows from others, or from a derivation",
    "rounding": "bound of the rounding of floats",
    "free": "no result depends on it, only time and memory",
    "unit or format": "array size, bit layout, width of a register, sentinel",
}
CHOSEN = ["tuned", "indifferent", "limit", "measured"]
FIGURES = ["p50", "p99", "worst", "within", "places"]
LEAST_SCATTER = 0.02

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


def measured(root):
    """Rows of constants_sensitivity.csv: by constant and factor."""
    found = collections.defaultdict(lambda: collections.defaultdict(list))
    for row in read_rows(root / SENSITIVITY):
        found[row["file"], row["name"]][row["factor"]].append(row)
    return found


def scatter_of(found):
    """By how much each figure of each row changes as any constant is changed by 1 %: more is needed to say that one matters."""
    scatter = collections.defaultdict(lambda: LEAST_SCATTER)
    for by_factor in found.values():
        for row in by_factor.get("0.99", []) + by_factor.get("1.01", []):
            for name in FIGURES:
                scatter[row["queries"], name] = max(scatter[row["queries"], name], abs(float(row[name]) - 1.0))
    return scatter


def changed_figures(row, scatter):
    """Those that differ from the constant as it is by more than they scatter, as ratios."""
    if not row["places"]:
        return [row["differs"]]
    return [f"{name} {row[name]}" for name in FIGURES if round(abs(float(row[name]) - 1.0) - scatter[row["queries"], name], 4) > 0.0]


def changes_no_figure(rows, scatter):
    return bool(rows) and not any(changed_figures(row, scatter) for row in rows) and not rows[0]["failed"]


def unproven(row, by_factor, scatter):
    """Why a constant is not measured to be what its kind says; none: it is."""
    if row["kind"] not in ("indifferent", "limit"):
        return None
    if any(r["value"] != row["value"] for rows in by_factor.values() for r in rows) or not {"0.5", "2"} <= by_factor.keys():
        return f"not measured at {row['value']}; run tools/contact/constants.py FOLDER --only {row['name']}"
    factors = ["2"] if row["kind"] == "limit" else ["0.5", "2"]
    holds = all(changes_no_figure(by_factor[factor], scatter) for factor in factors)
    return None if holds else f"{SENSITIVITY} does not show that it is {row['kind']}; call it tuned"


def sensitivity_text(factor, rows, scatter):
    changes = [f"{row['queries']} {', '.join(figures)}" for row in rows if (figures := changed_figures(row, scatter))]
    failed = rows[0]["failed"]
    if failed == "does not build":
        return f"×{factor}: does not build, another bound is as tight"
    text = "nothing" if all(row["differs"] == "0" for row in rows) else "; ".join(changes) or "scatter"
    return f"×{factor}: {text}" + (f"; {len(failed.split())} of {rows[0]['tests']} tests fail" if failed else "")


def sensitivities(by_factor, scatter):
    return " — ".join(sensitivity_text(factor, by_factor[factor], scatter) for factor in ("0.5", "2") if factor in by_factor) or "not measured"


def scatter_text(scatter):
    larger = collections.defaultdict(list)
    for (queries, name), value in scatter.items():
        if value > LEAST_SCATTER:
            larger[queries].append(f"{name} {100.0 * value:.3g} %")
    return "; ".join(f"{queries} {', '.join(texts)}" for queries, texts in larger.items()) or "none is larger"


def table(rows, found, scatter):
    lines = []
    for folder in FOLDERS:
        of_folder = [row for row in rows if str(pathlib.PurePath(row["file"]).parent) == folder]
        if not of_folder:
            continue
        lines += [f"### {folder.removeprefix('libs/vps/')}", "", "| constant | value | why | halved, doubled |", "|---|---|---|---|"]
        for row in of_folder:
            file = pathlib.PurePath(row["file"])
            link = f"[`{file.name}`](../../../{file})"
            text = sensitivities(found[row["file"], row["name"]], scatter)
            lines.append(f"| `{cell(row['name'])}`, {link} | {cell(row['value'])} | {cell(row['why'])} | {text} |")
        lines.append("")
    return lines


def page(root):
    rows = read_rows(root / CSV)
    count = collections.Counter(row["kind"] for row in rows)
    unnamed = sum(is_unnamed(row) and row["kind"] in CHOSEN for row in rows) or "none"
    lines = [
        "# Constants of the contact engine",
        "",
        "Written by `tools/contact/constants.py --page` from [constants.csv](constants.csv), which has every numeric constant of",
        "`libs/vps/{multibody,multibody/gap,walk,sampling,surface}` with its kind and reason, and",
        "[constants_sensitivity.csv](constants_sensitivity.csv), what halving and doubling does; a test (`contact_constants`) fails",
        "when they differ from the code, or when a constant was not measured to be of its kind.",
        "",
        "| kind | what | constants |",
        "|---|---|---|",
    ]
    lines += [f"| {kind} | {what} | {count[kind]} |" for kind, what in KINDS.items()]
    lines += [
        "",
        f"Chosen by measuring or by judgement are the first four kinds: {sum(count[kind] for kind in CHOSEN)}; {unnamed} without a name, quoted with the",
        "expression in which they stand.",
        "",
        "The last columns below: each chosen constant halved and doubled, alone, and what becomes of the figures of the training parts",
        "(`oos bench vps --pair training`) relative to those with the constant as it is: p50, p99 and worst error, share of estimates that",
        "hold, places read. Rows of that study: force of *cold* queries at 2 % and of queries with as *few places* as in scenarios at 10 %;",
        "*planes* of bodies and *gaps* of tools after a motion of 30 µm (places: how many planes). *Nothing*: no figure of any row differs in",
        "any digit. Tests: those of the constant's room that no longer hold.",
        "",
        "A hundred poses scatter: which patch is opened last decides digits. A change is named where it is larger than",
        f"{100.0 * LEAST_SCATTER:.0f} %, and than any that a change of 1 % of any one constant makes ({scatter_text(scatter_of(measured(root)))}). Smaller",
        "ones: *scatter*.",
        "",
    ]
    found = measured(root)
    scatter = scatter_of(found)
    for kind in CHOSEN:
        lines += [f"## {kind.capitalize()}: {count[kind]}", ""]
        if kind == "tuned":
            lines += ["At most 25 are wanted.", ""]
        lines += table([row for row in rows if row["kind"] == kind], found, scatter)
    return "\n".join(lines)


def check(root):
    yield from findings(root)
    found = measured(root)
    scatter = scatter_of(found)
    for number, row in enumerate(read_rows(root / CSV), start=2):
        if why := unproven(row, found[row["file"], row["name"]], scatter):
            yield f"{CSV}:{number}: {row['name']}: {why}"
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
    parser.add_argument("--kind", choices=list(KINDS))
    args = parser.parse_args()
    if args.folder:
        import constants_sensitivity  # which needs this module

        names = args.only.split(",") if args.only else None
        constants_sensitivity.measure(ROOT, args.folder.resolve(), [args.kind] if args.kind else CHOSEN, names)
        return 0
    if args.page:
        (ROOT / PAGE).write_text(page(ROOT), encoding="utf-8")
        return 0
    found = list(check(ROOT))
    print("\n".join(found) or f"ok: {len(read_rows(ROOT / CSV))} constants")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
