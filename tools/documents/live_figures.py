#!/usr/bin/env python3
"""Runs whole scenarios and writes what their reports say to docs/performance/live: `./dev bench live`.

  live_figures.py OOS [TABLE...]   OOS: the built program; TABLE: lockstep, methods, step, runs, processes, pictures, replay,
                                   window (all unless named; 1, 6, 2, 5, 6, 13, 4 and 2 minutes). processes needs root
                                   and what tests/lab needs.

VR_OOS_ROUNDS=1 in the environment measures once where otherwise the median of several runs is taken.
"""
import csv
import json
import os
import pathlib
import re
import signal
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
ROUNDS = {"pictures": int(os.environ.get("VR_OOS_ROUNDS", "5")), "lockstep": 3}

# By functions of their own, which return their rows.
REPLAY_S, REPLAY_FROM_S = 25, 20
LATE_S = 3.0  # before the swap of a viewer, and after it, in which late cycles are counted

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
STABLE_SHARE = ["stability", "least_stiffness_share"]
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
    ] + [("stable up to, times the stiffness", STABLE_SHARE),
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


def wait_for(condition, seconds, what):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    raise RuntimeError(f"{what}: not in {seconds} s")


def first_picture_s(folder, known=()):
    """When a viewer whose log is below that folder, and not known, had drawn its first picture, by the monotonic clock."""
    for log in folder.rglob("*.log"):
        found = re.search(r"first picture ([0-9.]+) s", log.read_text(errors="replace"))
        if found and log not in known:
            return float(found.group(1))
    return None


class Session:
    """Processes of a test, in a folder; all are ended with it."""

    def __init__(self, oos, folder):
        self.oos, self.folder, self.started = pathlib.Path(oos).absolute(), pathlib.Path(folder), []
        # Sessions of others on this machine are not found.
        self.environment = {**os.environ, "XDG_RUNTIME_DIR": str(folder)}

    def start(self, *words, **more):
        log = self.folder / f"{len(self.started)}_{words[0]}.log"
        with open(log, "w", encoding="utf-8") as said:  # `oos view` becomes visual_node
            self.started.append(subprocess.Popen([self.oos, *words], cwd=self.folder, stdout=said, text=True,
                                                 start_new_session=True, env=self.environment, **more))
        return self.started[-1]

    def start_display(self):
        """Before viewers, whose start is measured."""
        self.started.append(subprocess.Popen(["Xvfb", "-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp"],
                                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                             start_new_session=True))
        self.environment["DISPLAY"] = ":" + self.started[-1].stdout.readline().strip()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for one in reversed(self.started):
            if one.poll() is None:
                os.killpg(one.pid, signal.SIGTERM)
        for one in self.started:
            one.wait(timeout=60)


def replay_rows(oos):
    """A recording of module_replacement, replayed to a viewer of 1280x720 beside which no force loop runs."""
    columns = {}
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        subprocess.run([pathlib.Path(oos).absolute(), "run", ROOT / "scenarios/module_replacement", "--headless", "--out", out],
                       check=True)
        for head, more in [("native", ["--full_size"]), ("scaled", [])]:
            place = pathlib.Path(folder) / head
            place.mkdir()
            with Session(oos, place) as session:
                session.start_display()
                where = ["--registry", "tcp://127.0.0.1:7461", "--session", "61", "--no_encryption"]
                session.start("registry", *where)
                viewer = session.start("view", ROOT / "scenarios/module_replacement", *where, "--headless", "--size",
                                       "1280x720", *more)
                wait_for(lambda: first_picture_s(place), 60, "the first picture")
                replay = session.start("replay", out / "scene.mcap", *where, "--from", str(REPLAY_FROM_S),
                                       stdin=subprocess.PIPE)
                time.sleep(REPLAY_S)
                replay.communicate("quit\n", timeout=30)
                os.killpg(viewer.pid, signal.SIGTERM)
                found = wait_for(lambda: list(place.rglob("visual_node.json")), 60, "visual_node.json")
            columns[head] = json.loads(found[0].read_text(encoding="utf-8"))
    rows = [("pictures per second", ["fps"]), ("mean scale of a picture", ["render_scale"]),
            ("drawing a picture, ms, p50", ["draw_ms", "p50"]), ("processor time of a picture, ms", ["cpu_ms_per_frame"])]
    return [["what", *columns]] + [[what, *(value(one, path) for one in columns.values())] for what, path in rows]


def late_cycles(session):
    """Of the run so far, as haptic_node says it."""
    said = subprocess.run([session.oos, "topic", "echo", "figures/haptic_node", "--count", "1", "--seconds", "20"],
                          cwd=session.folder, capture_output=True, text=True, env=session.environment)
    figures = dict(zip(re.findall(r'^name: "(\w+)"', said.stdout, re.M), re.findall(r"^value: (\S+)", said.stdout, re.M)))
    if "misses" not in figures:
        raise RuntimeError(f"no late cycles in what haptic_node says: {said.stdout}{said.stderr}")
    return float(figures["misses"])


def window_rows(oos):
    """From `oos run` to its viewer's first picture; and, in a run that has viewers of its own choice, from a viewer's death to
    the first picture of the next."""
    scenario = ROOT / "scenarios/module_replacement"
    with tempfile.TemporaryDirectory() as folder, Session(oos, folder) as session:
        begin_s = time.monotonic()
        session.start("run", scenario, "--headless", "--out", session.folder / "out")
        first_s = wait_for(lambda: first_picture_s(session.folder), 90, "the first picture") - begin_s
    with tempfile.TemporaryDirectory() as folder, Session(oos, folder) as session:
        session.start_display()
        session.start("run", scenario, "--headless", "--without", "visual_node", "--out", session.folder / "out")
        wait_for((session.folder / "vr_oos/session.json").exists, 30, "the session")
        viewer = session.start("view", scenario, "--headless")
        wait_for(lambda: first_picture_s(session.folder), 90, "the first picture")
        time.sleep(12.0)  # into the first step, with contacts
        known = list(session.folder.rglob("*.log"))
        before = late_cycles(session)
        time.sleep(LATE_S)
        at_swap = late_cycles(session)
        swap_s = time.monotonic()
        os.killpg(viewer.pid, signal.SIGKILL)
        session.start("view", scenario, "--headless")
        swap_s = wait_for(lambda: first_picture_s(session.folder, known), 60, "the next viewer's first picture") - swap_s
        time.sleep(max(0.0, LATE_S - swap_s))
        after = late_cycles(session)
    return [["what", "measured"], ["from `oos run` to the first picture, s", f"{first_s:.3g}"],
            ["from a viewer's death to the first picture of the next, s", f"{swap_s:.3g}"],
            [f"late cycles in {LATE_S:g} s before that", f"{at_swap - before:g}"],
            ["late cycles in as long from then on", f"{after - at_swap:g}"]]


SPECIAL = {"replay": replay_rows, "window": window_rows}


def main():
    if len(sys.argv) < 2 or not set(sys.argv[2:]) <= set(TABLES) | set(SPECIAL):
        print(__doc__.strip())
        return 2
    folder = ROOT / "docs/performance/live"
    folder.mkdir(exist_ok=True)
    for table in sys.argv[2:] or [*TABLES, *SPECIAL]:
        if table in SPECIAL:
            rows = SPECIAL[table](sys.argv[1])
            with open(folder / f"{table}.csv", "w", newline="", encoding="utf-8") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)
            continue
        columns, traces = {}, {}
        for _ in range(ROUNDS.get(table, 1)):
            for scenario, options, heads in TABLES[table]:
                its, traces[heads[0]] = reports(sys.argv[1], scenario, options)
                for head, one in zip(heads, its):
                    columns.setdefault(head, []).append(one)
        if table == "processes":
            curves.write_shares(folder / "processes_t1.svg", "t1, ms", traces)
            shares = {head: float(middle([value(one, STABLE_SHARE) for one in its])) for head, its in columns.items()}
            curves.write_bars(folder / "processes_stability.svg", "stable up to, times the stiffness that is wanted", shares)
        with open(folder / f"{table}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["what", *columns])
            for what, path in ROWS[table]:
                writer.writerow([what, *(middle([value(one, path) for one in its]) for its in columns.values())])
    return 0


if __name__ == "__main__":
    sys.exit(main())
