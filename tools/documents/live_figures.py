#!/usr/bin/env python3
"""Runs whole scenarios and writes what their reports say to docs/performance/live: `./dev bench live`.

  live_figures.py OOS [TABLE...]   OOS: the built program; TABLE: lockstep, methods, runs (all unless named; 1, 6 and 5 minutes)
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOTH = ["paper", "fast"]

# Table: scenario, options of `oos run`, and the heads of its columns; --method both makes two.
TABLES = {
    "lockstep": [(scenario, ["--lockstep", "--method", "both"], [f"{short}, {method}" for method in BOTH])
                 for scenario, short in [("touch", "touch"), ("peg_in_hole", "peg_in_hole"),
                                         ("peg_in_hole/tight.xml", "peg_in_hole/tight"),
                                         ("module_replacement", "module_replacement")]],
    "methods": [(scenario, ["--headless", "--without", "visual_node", "--method", "both"],
                 [f"{short}, {method}" for method in BOTH])
                for scenario, short in [("module_replacement", "module_replacement"),
                                        ("peg_in_hole/tight.xml", "peg_in_hole/tight")]],
    "runs": [("module_replacement", ["--headless"] + more, [head])
             for head, more in [("as it is", []), ("without visual_node", ["--without", "visual_node"]),
                                ("without real-time priority", ["--rt", "off"])]],
}

LATENCIES = [(f"{chain}, {part}", ["direct_ms" if chain == "direct loop, ms" else chain.split(",")[0] + "_ms", part])
             for chain in ["t1, ms", "direct loop, ms", "t2_state, ms", "t2_image, ms"]
             for part in ["mean", "p50", "p99", "n"]]
STEPS = [("haptic step in contact, µs, " + part, ["haptic", f"contact_{part}_us"]) for part in ["p50", "p99", "max"]]
STEPS += [("every haptic step, µs, " + part, ["haptic", f"{part}_us"]) for part in ["p50", "p99", "max"]]
ROWS = {
    # Without real-time priority the tails come from the machine's other load.
    "lockstep": [("completed", ["completed"]), STEPS[0], STEPS[3], ("cycles in contact", ["haptic", "contact_cycles"])],
    "methods": [("completed", ["completed"])] + STEPS + LATENCIES[:4] + [
        ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"]),
        ("peak force on the hand, N", ["peak_force_N"])],
    "runs": LATENCIES + STEPS + [
        ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"]),
        ("messages received", ["bus", "received"]), ("messages dropped", ["bus", "dropped"])],
}


def value(report, path):
    for key in path:
        report = report.get(key) if isinstance(report, dict) else None
    if isinstance(report, bool):
        return "yes" if report else "no"
    return f"{report:.6g}" if isinstance(report, float) else "" if report is None else report


def reports(oos, scenario, options):
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([oos, "run", ROOT / "scenarios" / scenario, *options, "--out", out], check=True)
        report = json.loads((pathlib.Path(out) / "report.json").read_text(encoding="utf-8"))
    return [report[method] for method in BOTH] if "both" in options else [report]


def main():
    if len(sys.argv) < 2 or not set(sys.argv[2:]) <= set(TABLES):
        print(__doc__.strip())
        return 2
    folder = ROOT / "docs/performance/live"
    folder.mkdir(exist_ok=True)
    for table in sys.argv[2:] or TABLES:
        columns = {}
        for scenario, options, heads in TABLES[table]:
            columns.update(zip(heads, reports(sys.argv[1], scenario, options)))
        with open(folder / f"{table}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["what", *columns])
            for what, path in ROWS[table]:
                writer.writerow([what, *(value(report, path) for report in columns.values())])
    return 0


if __name__ == "__main__":
    sys.exit(main())
