"""Summary tables over many CSV files, for people to read; figures.py writes them."""
import csv

PAIRS = ["ball_on_box", "peg_pressed", "peg_free", "gear_on_pin", "nut_pressed", "ring_on_ring", "bunny_light", "bunny_near",
         "bunny_deep", "fandisk_on_bunny", "module_on_bracket"]
MESHES = {"block_with_hole": "block with a hole", "factory_nut_m16_tight_subdiv_3x": "M16 nut", "stanford_bunny": "bunny"}


def read(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def short(value):
    return f"{float(f'{float(value):.3g}'):g}" if value else ""


def contact_pairs(folder):
    """Time and error of both methods at voxel size s and 65,536 points; times are of consecutive poses."""
    rows = [["pair", "`paper`, µs", "`fast` 2 %, µs", "`fast` 10 %, µs", "`fast` is faster, times: 2 %, 10 %",
             "`fast` 2 %, 10 %, 99th percentile, µs", "force off, `paper`: median, worst, %", "force off, `fast` 2 %: median, worst, %",
             "force off, `fast` 10 %: median, worst, %"]]
    shown = (("paper", "s; 65536 points"), ("fast", "s; 65536 points"), ("fast", "s; 65536 points; 10 %"))
    for pair in PAIRS:
        of = {(row["method"], row["setting"]): row for row in read(folder / f"{pair}.csv")}
        if not all(entrant in of for entrant in shown):
            continue
        times = [float(of[entrant]["consecutive_p50_us"]) for entrant in shown]
        rows.append([pair.replace("_", " "), *(short(time) for time in times),
                     ", ".join(short(times[0] / time) for time in times[1:]),
                     ", ".join(short(of[entrant]["consecutive_p99_us"]) for entrant in shown[1:])])
        for entrant in shown:
            parts = [of[entrant][f"magnitude_error_{part}"] for part in ("p50", "max")]
            rows[-1].append(", ".join(short(100 * float(part)) for part in parts) if all(parts) else "")
    return rows


def three(row, name):
    """An error's median, 99th percentile and worst, in percent."""
    parts = [row[f"{name}_{part}"] for part in ("p50", "p99", "max")]
    return ", ".join(short(100 * float(part)) for part in parts) if all(parts) else ""


def parts_of(row, what):
    return f"{row['set'].replace('_', ' ')}: {row[what].replace('_', ' ')}"


def held_out(folder, file, what):
    """Errors and times of `paper` with 65,536 points and of `fast` asked for 2 and 10 %, for each kind of parts or of poses, the two
    sets apart."""
    shown = (("paper", "s; 65536 points"), ("fast", "10 %"), ("fast", "2 %"))
    names = ("`paper`", "`fast` 10 %", "`fast` 2 %")
    rows = [[what, "poses", "force off, `paper`: median, 99th percentile, worst, %",
             *(f"{error} off, {name}, %" for error in ("force", "moment") for name in names[1:]), "within twice, 2 %",
             *(f"{name}, µs" for name in names)]]
    measured = read(folder / file)
    for part in ("held_out", "training"):
        of = {(row[what], row["method"], row["setting"]): row for row in measured if row["set"] == part}
        for name in dict.fromkeys(row[what] for row in measured):
            three_rows = [of.get((name, *entrant)) for entrant in shown]
            if all(three_rows):
                paper, *fast = three_rows
                rows.append([parts_of(paper, what), paper["poses"], *(three(row, "force") for row in three_rows),
                             *(three(row, "moment") for row in fast), f"{100 * float(fast[1]['within_twice']):.4g} %",
                             *(short(row["p50_us"]) for row in three_rows)])
    return rows


ACCURACY_COLUMNS = ["method", "asked for, or points", "force off: median, 99th percentile, worst, %", "moment off, %", "within",
                    "within twice", "reached", "points tested, 16 for a place", "µs", "99th percentile, µs"]


def accuracy_cells(row):
    shares = [row[share] for share in ("within_estimate", "within_twice", "reached")]
    return [f"`{row['method']}`", row["setting"].removeprefix("s; "), three(row, "force"), three(row, "moment"),
            *(f"{100 * float(share):.4g} %" if share else "" for share in shares),
            short(row["places_p50"]), short(row["p50_us"]), short(row["p99_us"])]


def accuracies(folder):
    """What an accuracy costs, over all families and over the poses that are felt."""
    rows = [["poses", *ACCURACY_COLUMNS]]
    measured = read(folder / "heldout.csv")
    for part in ("held_out", "training"):
        for row in (row for name in ("all", "felt") for row in measured if row["set"] == part and row["family"] == name):
            rows.append([parts_of(row, "family"), *accuracy_cells(row)])
    return rows


def scene_pairs(folder):
    """What an accuracy costs in the shipped scenes."""
    rows = [["pair", "poses", *ACCURACY_COLUMNS]]
    for row in read(folder / "scene_pairs.csv"):
        rows.append(["all" if row["pair"] == "felt" else row["pair"], row["poses"], *accuracy_cells(row)])
    return rows


def builds(folder):
    """Build time and memory of a field beside OpenVDB's level set of the same voxels, band and threads."""
    of = {(row["mesh"], row["voxels"], row["threads"], row["method"]): row for row in read(folder / "build.csv")}
    rows = [["mesh", "voxels", "threads", "times as fast as OpenVDB", "stored, MB", "OpenVDB, MB", "peak over stored"]]
    for (mesh, voxels, threads, method), ours in of.items():
        if method == "OpenVDB":
            continue
        other = of[mesh, voxels, threads, "OpenVDB"]
        stored = float(ours["stored_bytes"])
        rows.append([MESHES.get(mesh, mesh), voxels, threads, short(float(other["time_s"]) / float(ours["time_s"])),
                     short(stored / 1e6), short(float(other["stored_bytes"]) / 1e6), short(float(ours["peak_bytes"]) / stored)])
    return rows


def tables(performance):
    """Path and text of each summary."""
    summaries = (("pairs", contact_pairs), ("builds", builds),
                 ("heldout_families", lambda folder: held_out(folder, "heldout.csv", "family")),
                 ("heldout_poses", lambda folder: held_out(folder, "heldout_kinds.csv", "kind")), ("heldout_accuracies", accuracies),
                 ("scene_accuracies", scene_pairs))
    sources = {"heldout_families": "heldout.csv", "heldout_poses": "heldout_kinds.csv", "heldout_accuracies": "heldout.csv",
               "scene_accuracies": "scene_pairs.csv"}
    for name, rows in summaries:
        if (performance / "vps").is_dir() and (name not in sources or (performance / "vps" / sources[name]).is_file()):
            yield performance / "vps" / f"{name}.csv", rows(performance / "vps")
