#!/usr/bin/env python3
"""Runs whole scenarios and writes what their reports say to docs/performance/live: `./dev bench live`.

  live_figures.py OOS [TABLE...]   OOS: the built program; TABLE: lockstep, methods, step, runs, processes, pictures (all unless
                                   named; 1, 6, 2, 5, 6 and 13 minutes). processes needs root and what tests/lab needs.
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import curves

ROOT = pathlib.Path(__file__).resolve().parents[2]
BOTH = ["paper", "fast"]
COLOCATE = "haptic physics"
CACHE = os.environ.get("VR_OOS_CACHE", os.path.expanduser("~/.cache/vr_oos"))

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
    "step": [("module_replacement", ["--headless", "--without", "visual_node"], ["live"]),
             ("module_replacement", ["--lockstep"], ["lock-step"])],
    "runs": [("module_replacement", ["--headless"] + more, [head])
             for head, more in [("as it is", []), ("without visual_node", ["--without", "visual_node"]),
                                ("without real-time priority", ["--rt", "off"])]],
    # On three machines, haptic_node shares one with the bridge, and with physics_node if they are one process.
    "processes": [("module_replacement", ["--headless", "--without", "visual_node"], ["two processes"]),
                  ("module_replacement", ["--headless", "--without", "visual_node", "--colocate", COLOCATE], ["one process"]),
                  ("module_replacement", {}, ["two processes, three machines"]),
                  ("module_replacement", {"colocate": COLOCATE}, ["one process, three machines"])],
}

# Runs of each column, in turn: a machine whose load changes changes it for all of them. A cell is their median.
TABLES["pictures"] = [("module_replacement", ["--headless"], ["with pictures"]),
                      ("module_replacement", ["--headless", "--without", "visual_node"], ["without pictures"])]
ROUNDS = {"pictures": 5}

LATENCIES = [(f"{chain}, {part}", ["direct_ms" if chain == "direct loop, ms" else chain.split(",")[0] + "_ms", part])
             for chain in ["t1, ms", "direct loop, ms", "t2_state, ms", "t2_image, ms"]
             for part in ["mean", "p50", "p99", "n"]]
STEPS = [("haptic step in contact, µs, " + part, ["haptic", f"contact_{part}_us"]) for part in ["p50", "p99", "p9999", "max"]]
STEPS += [("every haptic step, µs, " + part, ["haptic", f"{part}_us"]) for part in ["p50", "p99", "p9999", "max"]]
CPU_TIMES = [("haptic step in contact, processor time, µs, " + part, ["haptic", f"contact_cpu_{part}_us"])
             for part in ["p50", "p99", "p9999", "max"]]
CPU_TIMES += [("every haptic step, processor time, µs, " + part, ["haptic", f"cpu_{part}_us"])
              for part in ["p50", "p99", "p9999", "max"]]
STOLEN = ("share of the processors' time that the machine's host took", ["haptic", "stolen_share"])
ROWS = {
    "lockstep": [("completed", ["completed"])] + CPU_TIMES + [("cycles in contact", ["haptic", "contact_cycles"])],
    "step": CPU_TIMES + STEPS + [STOLEN, ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"])],
    "methods": [("completed", ["completed"])] + CPU_TIMES + STEPS + LATENCIES[:4] + [
        ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"]),
        ("peak force on the hand, N", ["peak_force_N"])],
    "runs": LATENCIES + [
        ("pictures per second", ["pictures", "fps"]), ("mean scale of a picture", ["pictures", "render_scale"]),
        ("drawing a picture, ms, p50", ["pictures", "draw_p50_ms"])] + CPU_TIMES + STEPS + [
        STOLEN, ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"]),
        ("messages received", ["bus", "received"]), ("messages dropped", ["bus", "dropped"])],
    "pictures": LATENCIES[12:15] + [
        ("pictures per second", ["pictures", "fps"]), ("mean scale of a picture", ["pictures", "render_scale"]),
        ("drawing a picture, ms, p50", ["pictures", "draw_p50_ms"])] + STEPS[4:6] + [
        ("t1, ms, p50", ["t1_ms", "p50"]), ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"])],
    "processes": [("completed", ["completed"])] + LATENCIES[:8] + [
        (f"force loop, ms, {what}", ["stability", f"loop_{key}_ms"]) for what, key in [("delay", "delay"), ("jitter", "jitter")]
    ] + [("stable up to, times the stiffness", ["stability", "least_stiffness_share"]),
         ("passivity controller acted in, share", ["stability", "share_made_passive"])] + CPU_TIMES[:2] + STEPS[:2] + [
        ("haptic cycles", ["haptic", "cycles"]), ("of these late", ["haptic", "misses"])],
}


def value(report, path):
    for key in path:
        report = report.get(key) if isinstance(report, dict) else None
    if isinstance(report, bool):
        return "yes" if report else "no"
    return f"{report:.6g}" if isinstance(report, float) else "" if report is None else report


def middle(values):
    """The median by size, an odd number of them."""
    return sorted(values, key=lambda text: float(text) if text not in ("", "yes", "no") else 0.0)[len(values) // 2]


class Machines:
    """Namespaces that are machines, as in tests/lab, and a lab file for them."""

    def __init__(self, folder, attributes):
        self.folder = folder
        self.keeper = subprocess.Popen([ROOT / "tests/lab/machines", folder, "alpha", "beta", "gamma"])
        while not (folder / "up").exists():
            if self.keeper.poll() is not None:
                raise RuntimeError("the machines do not start; tests/lab/README.md says what they need")
            time.sleep(0.1)
        physics = "alpha" if "colocate" in attributes else "beta"
        places = [("device_bridge", "alpha"), ("haptic_node", "alpha"), ("physics_node", physics), ("logic_node", "gamma")]
        hosts = "".join(f'<host name="{name}" address="10.77.0.{11 + i}" ssh_config="{folder}/ssh_config" '
                        f'cache="{CACHE}"/>' for i, name in enumerate(["alpha", "beta", "gamma"]))
        nodes = "".join(f'<node name="{node}" host="{host}"/>' for node, host in places)
        given = "".join(f' {name}="{value}"' for name, value in attributes.items())
        (folder / "lab.xml").write_text(f'<lab name="measured"{given}>{hosts}<registry host="beta"/>{nodes}</lab>\n')

    def command(self, words):
        net = (self.folder / "launcher.pid").read_text().strip()
        return ["nsenter", f"--net=/proc/{net}/ns/net", "--", *words]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.keeper.kill()  # the kernel then ends all that is in them
        self.keeper.wait()


def t1_ms(folder):
    with open(folder / "latency.csv", newline="", encoding="utf-8") as file:
        return [float(row[-1]) * 1e-6 for row in csv.reader(file) if row[0] == "t1"]


def reports(oos, scenario, options):
    """Of one run; `options`: of `oos run`, or the attributes of a lab. Beside them t1 of each trace."""
    oos = pathlib.Path(oos).absolute()
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        path = ROOT / "scenarios" / scenario
        if isinstance(options, dict):
            with Machines(pathlib.Path(folder) / "machines", options) as machines:
                lab = pathlib.Path(folder) / "machines/lab.xml"
                subprocess.run(machines.command([oos, "launch", path, "--lab", lab, "--without", "visual_node", "--out", out]),
                               check=True)
        else:
            subprocess.run([oos, "run", path, *options, "--out", out], check=True)
        report = json.loads((out / "report.json").read_text(encoding="utf-8"))
        traces = t1_ms(out) if (out / "latency.csv").exists() else []
    return [report[method] for method in BOTH] if "both" in options else [report], traces


def main():
    if len(sys.argv) < 2 or not set(sys.argv[2:]) <= set(TABLES):
        print(__doc__.strip())
        return 2
    folder = ROOT / "docs/performance/live"
    folder.mkdir(exist_ok=True)
    for table in sys.argv[2:] or TABLES:
        columns, traces = {}, {}
        for _ in range(ROUNDS.get(table, 1)):
            for scenario, options, heads in TABLES[table]:
                its, traces[heads[0]] = reports(sys.argv[1], scenario, options)
                for head, one in zip(heads, its):
                    columns.setdefault(head, []).append(one)
        if table == "processes":
            curves.write_shares(folder / "processes_t1.svg", "t1, ms", traces)
        with open(folder / f"{table}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["what", *columns])
            for what, path in ROWS[table]:
                writer.writerow([what, *(middle([value(one, path) for one in its]) for its in columns.values())])
    return 0


if __name__ == "__main__":
    sys.exit(main())
