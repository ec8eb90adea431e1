"""What the constants of the contact engine that were chosen are worth: each is halved and doubled in turn, in a copy of the tree,
and with it the training parts (study_training.cpp) are measured and the tests of its room run. See constants.py.

In the copy a program reads the constants when it starts (studied_constant.hpp), so that one build serves them all. Those
that the compiler has to know, such as the size of an array, are written into their file, and it is built anew."""
import concurrent.futures
import csv
import json
import os
import queue
import re
import shutil
import subprocess

import constants

FACTORS = ("0.5", "2")
NEARLY = ("0.99", "1.01")  # by which the scatter of the figures is found; no tests are run
LONGEST_S = 1800  # of a build, a study, the tests of a room
# Tests of vps_test that state what a room promises; budgets are in them alone.
CLAIMS = {
    "libs/vps/multibody": "CollisionWorld* ContactPlanes* FastPair* FastWorld* HandOnVoxmap* LookAhead* ManyObjects* *WildMotion*",
    "libs/vps/multibody/gap": "GapQuery* ContactPlanes* FastWorld* HandOnVoxmap*",
    "libs/vps/walk": "FieldWalk* BoundFreeDistance* FacetLanes* WalkMemory* GapQuery*",
    "libs/vps/sampling": "PanelOwners* SampleTree* SurfaceSamples* TouchPoints* FieldWalk* GapQuery*",
    "libs/vps/surface": "FieldBends* SurfacePieces* SurfaceTree* SurfaceWalk*",
}
# Rows of training.csv whose figures are kept. Of planes and gaps the errors are those of a motion of 30 um, and places
# are how many planes there are.
KEPT = (("cold", "2 %"), ("few places", "10 %"), ("planes", "10 %"), ("gaps", "10 %"))
FIGURES = {"p50": "force_p50", "p99": "force_p99", "worst": "force_max", "within": "within_twice", "places": "places_mean"}
COLUMNS = ["file", "name", "value", "factor", "queries", "accuracy", *FIGURES, "differs", "tests", "failed"]

HEADER = "tools/contact/studied_constant.hpp"
IN_COPY = "libs/vps/studied_constant.hpp"
PATCHES = "libs/vps/force/reduce_patches.hpp"
DECLARATION = re.compile(rf"(?P<static>static )?constexpr (?P<type>{constants.NUMERIC}) (?=k[A-Z]\w*(?:\[\])? = )")
# Where the compiler has to know a number.
FIXED = re.compile(r"static_assert\([^;]*|\b(?:array|FixedVector)<[^;{]*>|\[[^\]]*\]", re.S)


def names_in(text):
    return set(re.findall(r"\bk[A-Z]\w*", text))


def key_of(row):
    return f"{row['file']}:{row['name']}"


def is_count(row):
    return row["value"].replace("'", "").isdigit()


def element(value, row, type_name):
    function = "StudiedCosine" if "cosine" in row["why"] else "Studied"
    return f'vps::{function}<{type_name}>({value}, "{key_of(row)}")'


class Variable:
    """The engine's sources, by file, in which constants are read when the program starts."""

    def __init__(self, root, rows):
        self.texts = {str(path.relative_to(root)): path.read_text(encoding="utf-8") for path in constants.sources(root)}
        code = {file: constants.without_comments(text) for file, text in self.texts.items()}
        fixed = {name for text in code.values() for found in FIXED.findall(text) for name in names_in(found)}
        self.fixed = [row for row in rows if row["name"] in fixed and is_count(row)]
        self.rows = {key_of(row): row for row in rows if row not in self.fixed}
        # What is computed from them is no constant either.
        self.computed = {row["name"] for row in self.rows.values()}
        declared = [c for file, text in self.texts.items() for c in constants.constants_of(file, text)]
        while more := {c.name for c in declared if names_in(c.value) & self.computed} - self.computed:
            self.computed |= more
        for file in self.texts:
            self.texts[file] = self._converted(file, self.texts[file])
        self.texts[IN_COPY] = (root / HEADER).read_text(encoding="utf-8")
        # Room for twice as many patches, which the engine's own limits are checked against.
        patches = (root / PATCHES).read_text(encoding="utf-8")
        self.texts[PATCHES] = re.sub(r"(kMaxPatches = )(\d+)", lambda found: found[1] + str(2 * int(found[2])), patches)

    def _converted(self, file, text):
        declared = list(constants.constants_of(file, text))
        edits = []
        for found in DECLARATION.finditer(constants.without_comments(text)):
            end = text.index(";", found.end())
            mine = [c for c in declared if found.end() <= c.begin < end]
            if not any(c.name in self.computed for c in mine):
                continue
            is_local = found.start() > text.rfind("\n", 0, found.start()) + 1
            how = "static inline const" if found["static"] else "static const" if is_local else "const"
            edits.append((found.start(), found.end(), f"{how} {found['type']} "))
            for c in mine:
                row = self.rows.get(f"{file}:{c.name}")
                if row is None or row["value"] != c.value:
                    continue
                value = text[c.begin:c.end]
                if value.startswith("{"):
                    value = "{" + ", ".join(element(v.strip(), row, found["type"]) for v in value[1:-1].split(",")) + "}"
                else:
                    value = element(value, row, found["type"])
                edits.append((c.begin, c.end, value))
        for row in self.rows.values():
            if row["file"] != file or not constants.is_unnamed(row):
                continue
            at = text.index(row["name"])
            begin = at + row["name"].index(row["value"])
            key = key_of(row).replace('"', "'")
            read = f"[] {{ static const auto v = vps::Studied<decltype({row['value']})>({row['value']}, \"{key}\"); return v; }}()"
            edits.append((begin, begin + len(row["value"]), read))
        for begin, end, new in sorted(edits, reverse=True):
            text = text[:begin] + new + text[end:]
        # Bodies of kernels are included within a namespace, after files that have it.
        include = f'#include "{IN_COPY.removeprefix("libs/")}"\n'
        if edits and file.endswith(".cpp"):
            text = include + text
        elif edits:
            text = text.replace("#pragma once\n", "#pragma once\n" + include, 1)
        return text


def copy_tree(root, to, texts):
    """With those texts in the place of files. Files that are the same keep their time, so that only what has changed is
    built."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "-coz", "--exclude-standard"], check=True, capture_output=True)
    names = {name for name in listed.stdout.decode().split("\0") if name and (root / name).is_file()} | texts.keys()
    for path in to.rglob("*"):
        name = str(path.relative_to(to))
        if path.is_file() and name not in names and not name.startswith("build/"):
            path.unlink()
    for name in names:
        content = texts[name].encode() if name in texts else (root / name).read_bytes()
        path = to / name
        if not path.exists() or path.read_bytes() != content:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
            if (root / name).exists():
                path.chmod((root / name).stat().st_mode)


class Bench:
    """A copy of the tree, and what is found with it."""

    def __init__(self, root, folder, variable):
        self.tree = folder / "main"
        self.build = self.tree / "build/release"
        self.log = folder / "log.txt"
        self.tree.mkdir(parents=True, exist_ok=True)
        copy_tree(root, self.tree, variable.texts)
        if not self.run("cmake", "--preset", "release", "-DVR_OOS_PCH=OFF", cwd=self.tree):
            raise SystemExit(f"the copy could not be configured: see {self.log}")

    def run(self, *command, cwd, **environment):
        with open(self.log, "a", encoding="utf-8") as file:
            words = [str(word) for word in command]
            try:
                subprocess.run(words, stdout=file, stderr=file, cwd=cwd, env=os.environ | environment, check=True, timeout=LONGEST_S)
            except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
                return False
            return True

    def is_built(self):
        return self.run("ninja", f"-j{os.cpu_count()}", "contact_training", "vps_test", cwd=self.build)

    def figures(self, plots, **environment):
        """Rows of training.csv, or None where it ends with an error. References stay in the folder of the plots."""
        table = plots / "training.csv"
        table.unlink(missing_ok=True)
        is_measured = self.run("bin/contact_training", plots, cwd=self.build, **environment)
        return constants.read_rows(table) if is_measured else None

    def claims(self, room, plots, **environment):
        """How many tests there are, and the names of those that fail."""
        report = plots / "tests.json"
        report.unlink(missing_ok=True)
        self.run("libs/vps/vps_test", f"--gtest_filter={CLAIMS[room].replace(' ', ':')}", f"--gtest_output=json:{report}",
                 cwd=self.build, TMPDIR=str(plots), **environment)
        if not report.exists():
            return "0", "all: they end with an error"
        suites = json.loads(report.read_text(encoding="utf-8"))["testsuites"]
        tests = [(f"{suite['name']}.{test['name']}", "failures" in test) for suite in suites for test in suite["testsuite"]]
        return str(len(tests)), " ".join(name for name, is_failed in tests if is_failed)

    def found(self, row, factor, plots, **environment):
        room = row["file"].rpartition("/")[0]
        claims = self.claims(room, plots, **environment) if factor in FACTORS else ("", "")
        return (self.figures(plots, **environment), *claims)

    def found_when_built(self, row, factor, plots):
        """With a number that the compiler has to know; None: it does not build."""
        path = self.tree / row["file"]
        text = path.read_text(encoding="utf-8")
        path.write_text(with_scaled(text, row, factor), encoding="utf-8")
        found = self.found(row, factor, plots) if self.is_built() else None
        path.write_text(text, encoding="utf-8")
        return found


def with_scaled(text, row, factor):
    """A number of which the compiler has to know the value."""
    for c in constants.constants_of(row["file"], text):
        if c.name == row["name"] and c.value == row["value"]:
            return text[:c.begin] + str(max(1, round(int(c.value.replace("'", "")) * float(factor)))) + text[c.end:]
    raise SystemExit(f"{row['file']}: {row['name']} is not {row['value']}; run constants.py --check")


def number_of_differences(before, after):
    return sum(a[key] != b[key] for a, b in zip(before, after) for key in a)


def ratio(after, before):
    """Below a millionth errors are rounding."""
    if max(float(after), float(before)) < 1e-6:
        return "1"
    return f"{float(after) / float(before):.3g}" if float(before) != 0.0 else "inf"


def rows_of(row, factor, before, found):
    figures, tests, failed = found or (None, "", "does not build")
    head = {"file": row["file"], "name": row["name"], "value": row["value"], "factor": factor, "tests": tests, "failed": failed}
    rows = []
    for queries, accuracy in KEPT:
        out = dict(head, queries=queries, accuracy=accuracy, differs="ends with an error", **dict.fromkeys(FIGURES, ""))
        if figures is not None:
            def of(table):
                wanted = {"queries": queries, "accuracy": accuracy, "contacts": "felt"}
                return next(r for r in table if all(r[key] == text for key, text in wanted.items()))
            out.update({key: ratio(of(figures)[column], of(before)[column]) for key, column in FIGURES.items()})
            out["differs"] = str(number_of_differences(before, figures))
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


def measure(root, folder, kinds, names):
    os.nice(10)
    wanted = [row for row in constants.read_rows(root / constants.CSV)
              if row["kind"] in kinds and (not names or row["name"] in names)]
    variable = Variable(root, wanted)
    bench = Bench(root, folder, variable)
    plots = queue.SimpleQueue()
    first = folder / "plots/0"
    first.mkdir(parents=True, exist_ok=True)
    before = bench.figures(first) if bench.is_built() else None
    if before is None:
        raise SystemExit(f"the copy could not be built or measured: see {bench.log}")
    plots.put(first)
    for k in range(1, os.cpu_count()):
        shutil.copytree(first, folder / f"plots/{k}", dirs_exist_ok=True)
        plots.put(folder / f"plots/{k}")

    def find(row, factor):
        mine = plots.get()
        try:
            if row in variable.fixed:
                return bench.found_when_built(row, factor, mine)
            return bench.found(row, factor, mine, VR_OOS_CONSTANT=key_of(row), VR_OOS_FACTOR=factor)
        finally:
            plots.put(mine)

    def take(row, factor, found):
        new = rows_of(row, factor, before, found)
        print(f"{row['name']} x {factor}: " + "; ".join(
            f"{r['queries']} p99 {r['p99']}, worst {r['worst']}, places {r['places']}, differs {r['differs']}" for r in new) +
            f"; failed {new[0]['failed'] or 'none'}", flush=True)
        if row["kind"] in constants.CHOSEN:
            keep(root / constants.SENSITIVITY, new)

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as at_once:
        tasks = [(row, factor) for row in wanted if row not in variable.fixed
                 for factor in FACTORS + (() if is_count(row) else NEARLY)]
        for (row, factor), found in zip(tasks, at_once.map(lambda task: find(*task), tasks)):
            take(row, factor, found)
    for row in variable.fixed:
        for factor in FACTORS:
            take(row, factor, find(row, factor))
