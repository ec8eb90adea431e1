#!/usr/bin/env python3
"""Copies measured figures from the files that benchmarks write into the documents that quote them.

  figures.py                      fills in docs/performance/figures.csv, then every document
  figures.py --check              changes nothing; names what is stale, and figures that stand in a README without a mark
  figures.py --ran FOLDER COMMAND notes in docs/performance/runs.csv that COMMAND has just written docs/performance/FOLDER;
                                  FOLDER may be one table of a folder: live/pictures

A document quotes a figure between two marks, <!--figure:ID-->76<!--/figure-->, and a whole CSV file as a table between
<!--table:FILE--> and <!--/table-->. figures.csv names for each ID the cell that it comes from:
FILE|COLUMN=VALUE|...|COLUMN, with #N behind it for the Nth number of a cell with text.
"""
import argparse
import csv
import datetime
import os
import pathlib
import re
import subprocess
import sys

import summaries

FIGURE = re.compile(r"<!--figure:([\w.]+)-->(.*?)<!--/figure-->", re.S)
TABLE = re.compile(r"(<!--table:([\w./]+)-->\n)(.*?)(<!--/table-->)", re.S)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Text that can only come from a measurement: short times, speed-ups, shares. Milliseconds are mostly limits, not measured.
MEASURED = re.compile(r"\d ?(?:us|µs|ns)\b|\d (?:times as (?:fast|long)|% off)\b")


class Stale(Exception):
    pass


def performance(root):
    return root / "docs/performance"


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_rows(path, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def cell(root, source):
    """The text of the cell that `source` names."""
    name, *conditions, column = source.split("|")
    column, _, number = column.partition("#")
    wanted = [condition.split("=", 1) for condition in conditions]
    rows = [row for row in read_rows(performance(root) / name) if all(row.get(k) == v for k, v in wanted)]
    if len(rows) != 1 or column not in rows[0]:
        raise Stale(f"{source}: {len(rows)} such rows, column '{column}'")
    text = rows[0][column]
    return NUMBER.findall(text)[int(number) - 1] if number else text


def written(text, digits, scale):
    """A number as people read it: `digits` significant ones. Text stays as it is."""
    if not NUMBER.fullmatch(text):
        return text
    value = float(text) * float(scale or 1)
    rounded = float(f"{value:.{int(digits or 3)}g}")
    if rounded == 0 or 1e-4 <= abs(rounded) < 1e7:
        return f"{rounded:,.10f}".rstrip("0").rstrip(".")
    return f"{rounded:g}"


def as_table(root, name):
    with open(performance(root) / name, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    lines = ["| " + " | ".join(rows[0]) + " |", "|" + "---|" * len(rows[0])]
    for row in rows[1:]:
        lines.append("| " + " | ".join(written(text, 3, 1) or "-" for text in row) + " |")
    return "\n".join(lines) + "\n"


def documents(root):
    for path in sorted(root.rglob("*.md")):
        if not {"build", "node_modules", "out", ".git"} & set(path.relative_to(root).parts):
            yield path


def brought_up_to_date(root, text, values, quoted):
    def figure(match):
        if match[1] not in values:
            raise Stale(f"no figure '{match[1]}' in docs/performance/figures.csv")
        quoted.add(match[1])
        return f"<!--figure:{match[1]}-->{values[match[1]]}<!--/figure-->"

    text = FIGURE.sub(figure, text)
    return TABLE.sub(lambda match: match[1] + as_table(root, match[2]) + match[4], text)


def without_marks(root, path, text):
    """Lines with a measured figure outside marks, which no command can update; in rooms' documents and docs/performance."""
    of_room = path.name in ("README.md", "LEDGER.md") and not path.is_relative_to(root / "docs")
    if not of_room and path.parent != performance(root):
        return []
    bare = TABLE.sub("", FIGURE.sub("", text))
    return [line.strip() for line in bare.splitlines() if MEASURED.search(line)]


def update(root, is_check):
    """Returns a line for each stale item; without is_check it also updates them."""
    stale = []
    for path, rows in summaries.tables(performance(root)):
        text = "".join(",".join(f'"{cell}"' if "," in cell else cell for cell in row) + "\n" for row in rows)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            stale.append(f"{path.relative_to(root)}: not a summary of the files beside it")
            if not is_check:
                path.write_text(text, encoding="utf-8")
    path = performance(root) / "figures.csv"
    rows = read_rows(path)
    for row in rows:
        value = written(cell(root, row["source"]), row["digits"], row["scale"])
        if value != row["value"]:
            stale.append(f"docs/performance/figures.csv: {row['id']} is {value}, not {row['value']}")
            row["value"] = value
    if stale and not is_check:
        write_rows(path, rows)
    runs = {row["folder"] for row in read_rows(performance(root) / "runs.csv")}
    values = {row["id"]: row["value"] for row in rows}
    quoted = set()
    for row in rows:
        if row["source"].split("/")[0] not in runs:
            stale.append(f"docs/performance/runs.csv: no row for {row['source']}")
    for document in documents(root):
        text = document.read_text(encoding="utf-8")
        name = document.relative_to(root)
        try:
            fresh = brought_up_to_date(root, text, values, quoted)
        except (Stale, OSError) as wrong:
            stale.append(f"{name}: {wrong}")
            continue
        if fresh != text:
            stale.append(f"{name}: quotes figures that are not those of docs/performance")
            if not is_check:
                document.write_text(fresh, encoding="utf-8")
        stale += [f"{name}: without a mark: {line}" for line in without_marks(root, document, text)]
    stale += [f"docs/performance/figures.csv: no document quotes {name}" for name in sorted(set(values) - quoted)]
    return stale


def note_run(root, folder, command):
    path = performance(root) / "runs.csv"
    rows = [row for row in read_rows(path) if not f"{row['folder']}/".startswith(folder + "/")]
    cpuinfo = pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")
    cpu = [line for line in cpuinfo.splitlines() if line.startswith("model name")]
    rows.append({
        "folder": folder,
        "command": command,
        "date": datetime.date.today().isoformat(),
        "commit": subprocess.check_output(["git", "-C", root, "rev-parse", "--short", "HEAD"], text=True).strip(),
        "machine": f"{os.cpu_count()} cores of {cpu[0].split(':')[1].strip()}" if cpu else f"{os.cpu_count()} cores",
    })
    write_rows(path, sorted(rows, key=lambda row: row["folder"]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--ran", nargs=2, metavar=("FOLDER", "COMMAND"))
    arguments = parser.parse_args()
    if arguments.ran:
        note_run(arguments.root, *arguments.ran)
        return 0
    stale = update(arguments.root, arguments.check)
    if not arguments.check:  # what is still stale needs a person
        stale = update(arguments.root, True)
    for line in stale:
        print(line)
    if stale:
        print("./dev figures updates quoted figures" if arguments.check else "correct the lines above by hand")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
