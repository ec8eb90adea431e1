"""What the tuned constants of the contact engine are worth: each is halved and doubled in turn, in a copy of the tree,
and the training parts (study_training.cpp) are measured with it. See constants.py."""
import csv
import math
import os
import re
import shutil
import subprocess

import constants

FACTORS = ("0.5", "2")
# No pair of the training study has gaps: these change only if they are named.
UNSEEN = "libs/vps/multibody/gap"
# Rows of training.csv whose figures are kept.
KEPT = (("cold", "2 %"), ("few places", "10 %"))
FIGURES = {"p50": "force_p50", "p99": "force_p99", "worst": "force_max", "within": "within_twice", "places": "places_mean"}
COLUMNS = ["file", "name", "factor", "value", "queries", "accuracy", *FIGURES, "differs"]


def copy_tree(root, to):
    """Files that are the same keep their time, so that only what has changed is built."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "-coz", "--exclude-standard"], check=True, capture_output=True)
    names = {name for name in listed.stdout.decode().split("\0") if name and (root / name).is_file()}
    for path in to.rglob("*"):
        name = str(path.relative_to(to))
        if path.is_file() and name not in names and not name.startswith("build/"):
            path.unlink()
    for name in names:
        from_path, to_path = root / name, to / name
        if to_path.exists() and to_path.read_bytes() == from_path.read_bytes():
            continue
        to_path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(from_path, to_path)


def run(command, log, folder):
    with open(log, "a", encoding="utf-8") as file:
        words = [str(word) for word in command]
        return subprocess.run(words, stdout=file, stderr=file, cwd=folder, check=False).returncode == 0


class Bench:
    """A copy of the tree, built, and the study's figures."""

    def __init__(self, root, folder):
        self.tree = folder / "main"
        self.build = self.tree / "build/release"
        self.plots = folder / "plots"
        self.log = folder / "log.txt"
        for made in (self.tree, self.plots):
            made.mkdir(parents=True, exist_ok=True)
        copy_tree(root, self.tree)
        if not run(["cmake", "--preset", "release"], self.log, self.tree):
            raise SystemExit(f"the copy could not be configured: see {self.log}")

    def figures(self):
        """Rows of training.csv, or None where it does not build or ends with an error."""
        table = self.plots / "training.csv"
        table.unlink(missing_ok=True)
        for command in (["ninja", f"-j{os.cpu_count()}", "contact_training"], ["bin/contact_training", self.plots]):
            if not run(command, self.log, self.build):
                return None
        return constants.read_rows(table)


def scaled(value, factor, why):
    """The same literal or expression times the factor, written anew. Of a cosine the angle is scaled."""
    suffix = "f" if re.search(r"\d\.?f\b", value) else ""
    if "cosine" in why and re.fullmatch(r"[\d.ef+\- ]+", value):
        cosine = sum(float(term) for term in re.sub(r"(?<=\d)f", "", value).replace(" - ", " -").split())
        return f"{math.cos(float(factor) * math.acos(cosine)):.9g}{suffix}"
    if re.fullmatch(r"[\d']+U?", value):
        count = max(1, round(int(re.sub(r"['U]", "", value)) * float(factor)))
        return f"{count}{'U' if value.endswith('U') else ''}"
    return f"({value}) * {float(factor)}{suffix}"


def changed(text, row, factor):
    """The file with that constant scaled, and its new value."""
    value = scaled(row["value"], factor, row["why"])
    if constants.is_unnamed(row):
        pattern = r"\s+".join(re.escape(word) for word in row["name"].split())
        found = re.search(pattern, text)
        return text[:found.start()] + found[0].replace(row["value"], value, 1) + text[found.end():], value
    for constant in constants.constants_of(row["file"], text):
        if constant.name == row["name"] and constant.value == row["value"]:
            return text[:constant.begin] + value + text[constant.end:], value
    raise SystemExit(f"{row['file']}: {row['name']} is not {row['value']}; run constants.py --check")


def number_of_differences(before, after):
    return sum(a[key] != b[key] for a, b in zip(before, after) for key in a)


def ratio(after, before):
    return f"{float(after) / float(before):.3g}" if float(before) != 0.0 else after


def rows_of(row, factor, value, before, after):
    head = {"file": row["file"], "name": row["name"], "factor": factor, "value": value}
    rows = []
    for queries, accuracy in KEPT:
        out = dict(head, queries=queries, accuracy=accuracy, differs="does not build or run", **dict.fromkeys(FIGURES, ""))
        if after is not None:
            def of(table):
                wanted = {"queries": queries, "accuracy": accuracy, "contacts": "felt"}
                return next(r for r in table if all(r[key] == text for key, text in wanted.items()))
            out.update({key: ratio(of(after)[column], of(before)[column]) for key, column in FIGURES.items()})
            out["differs"] = str(number_of_differences(before, after))
        rows.append(out)
    return rows


def keep(path, new):
    """In the place of older rows about the same constant."""
    key = (new[0]["file"], new[0]["name"], new[0]["factor"])
    rows = [r for r in constants.read_rows(path) if (r["file"], r["name"], r["factor"]) != key] + new
    rows.sort(key=lambda r: (r["file"], r["name"], float(r["factor"])))
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def measure(root, folder, kind, names):
    os.nice(10)
    wanted = [row for row in constants.read_rows(root / constants.CSV)
              if row["kind"] == kind and (row["name"] in names if names else not row["file"].startswith(UNSEEN))]
    bench = Bench(root, folder)
    before = bench.figures()
    if before is None:
        raise SystemExit(f"the copy could not be built or measured: see {bench.log}")
    for row in wanted:
        path = bench.tree / row["file"]
        text = path.read_text(encoding="utf-8")
        for factor in FACTORS:
            variant, value = changed(text, row, factor)
            path.write_text(variant, encoding="utf-8")
            new = rows_of(row, factor, value, before, bench.figures())
            path.write_text(text, encoding="utf-8")
            print(f"{row['name']} = {value}: " + "; ".join(
                f"{r['queries']} p99 {r['p99']}, worst {r['worst']}, places {r['places']}, differs {r['differs']}" for r in new),
                flush=True)
            if kind == "tuned":
                keep(root / constants.SENSITIVITY, new)
