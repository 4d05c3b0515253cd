#!/usr/bin/python3
"""Reconstructs all virtual scans, writes a table of what came out, and fails where a figure is worse than recorded.

The scans are those of analytic shapes, made by `gpsrecon scan`, and those that GPSRECON_DATA_DIR holds as
scans/NAME.sN.ply with truth/NAME.ply. Figures come from the reports of the chain and of `gpsrecon compare`. A figure is
worse when it exceeds the recorded one by more than its noise, which --update finds by repeating the reconstruction and
the comparison with other seeds. Docs: docs/evidence/board.md, docs/method/virtual-scans.md.

Exit codes: 0 nothing is worse, 1 something is (one line each), 2 usage, 3 a program failed.
"""

import argparse
import csv
import json
import os
import platform
import re
import sys
import tempfile
from pathlib import Path

from lab import pages
from lab.runner import GPSRECON, ROOT, Failure, Gpsrecon, exit_code_of
from lab.scans import SEED, Scan, add_data_option, scans_in

NOISE_SEEDS = (2, 3)

# Shapes and grades of scan, with a third of the points of the grade: enough to tell better from worse.
SHAPE_POINTS = {"s1": 100_000, "s2": 50_000, "s3": 25_000}
SHAPES = {
    "sphere": ("s1", "s2", "s3"), "torus": ("s2",), "knot": ("s2",), "ripple": ("s2",), "rounded-box": ("s2",),
    "block": ("s1", "s2", "s3"), "fins": ("s1",), "gyroid": ("s2",), "vase": ("s1", "s2", "s3"), "workpiece": ("s2",),
}
QUICK = {"sphere.s2", "rounded-box.s2", "block.s3", "vase.s3"}

# name: (title, unit, smallest noise relative, smallest noise absolute). In each less is better.
FIGURES = {
    "mesh_to_truth": ("RMS mesh to truth", "%", 0.01, 0.0),
    "truth_to_mesh": ("RMS truth to mesh", "%", 0.01, 0.0),
    "normal_angle": ("mean normal angle", "deg", 0.01, 0.0),
    "wrong_components": ("components, off by", "", 0.0, 0.0),
    "wrong_loops": ("boundary loops, off by", "", 0.0, 0.0),
    "wrong_euler": ("Euler number, off by", "", 0.0, 0.0),
    "nonmanifold": ("non-manifold edges and vertices", "", 0.0, 0.0),
    "vertices": ("control vertices", "", 0.02, 0.0),
    # Machines differ, and so does what else they do.
    "cpu_s": ("processor time", "s", 2.0, 2.0),
    "memory_MB": ("peak memory", "MB", 0.5, 10.0),
}


def find_scans(data, points):
    shapes = [Scan(f"{shape}.{grade}", points or SHAPE_POINTS[grade])
              for shape, grades in SHAPES.items() for grade in grades]
    return shapes + scans_in(data)


def measure(program, scan, truth_topology, seed, samples, work):
    """The figures of one reconstruction, and the topology they come from."""
    mesh = work / "mesh.ply"
    program.run(scan.points, mesh, "--seed", seed)
    chain = json.loads((work / "mesh.report.json").read_text())
    compared = json.loads(program.run("compare", mesh, scan.truth, "--samples", samples, "--seed", seed, "--report", "-"))
    reference, topology = compared["reference"], compared["mesh"]["topology"]
    found = topology["components"], topology["boundary_loops"], topology["euler"]
    wrong = [abs(a - b) for a, b in zip(found, truth_topology)]
    figures = {
        "mesh_to_truth": 100 * reference["mesh_to_reference"]["distance"]["rel"]["rms"],
        "truth_to_mesh": 100 * reference["reference_to_mesh"]["distance"]["rel"]["rms"],
        "normal_angle": reference["mesh_to_reference"]["normals"]["mean_deg"],
        "wrong_components": wrong[0],
        "wrong_loops": wrong[1],
        "wrong_euler": wrong[2],
        "nonmanifold": topology["nonmanifold_edges"] + topology["nonmanifold_vertices"],
        "vertices": chain["covmesh"]["vertices"],
        "cpu_s": chain["run"]["cpu_s"],
        "memory_MB": chain["run"]["peak_memory_bytes"] / 1e6,
    }
    return {name: round(value, 6) for name, value in figures.items()}, found


def noise_of(figures, repeats):
    """Twice the largest deviation over the repeats, at least what FIGURES says."""
    noise = {}
    for name, value in figures.items():
        _, _, relative, absolute = FIGURES[name]
        spread = 0.0 if name in ("cpu_s", "memory_MB") else max((abs(r[name] - value) for r in repeats), default=0.0)
        noise[name] = round(max(2 * spread, relative * abs(value), absolute), 6)
    return noise


def regressions(name, figures, recorded):
    """One line for every figure that is worse than the recorded one by more than its noise."""
    lines = []
    for figure, value in figures.items():
        old, noise = recorded["figures"].get(figure), recorded["noise"].get(figure, 0)
        if old is not None and value > old + noise * (1 + 1e-9):
            title, unit, _, _ = FIGURES[figure]
            lines.append(f"{name}: {title} {value:g}{unit and ' '}{unit}, recorded {old:g} (noise {noise:g})")
    return lines


def read_tsv(path):
    if not path or not path.exists():
        return []
    with path.open() as file:
        return list(csv.DictReader((line for line in file if not line.startswith("#")), delimiter="\t"))


def poisson_shares(name, figures, baseline):
    """Our control vertices over Poisson's, at its shallowest depth that is not more accurate and at its most accurate one;
    by the larger of the two RMS. None where there is no such depth."""
    def larger(row):
        return max(float(row["rms_mesh_to_truth"]), float(row["rms_truth_to_mesh"]))

    ours = max(figures["mesh_to_truth"], figures["truth_to_mesh"])
    rows = sorted((row for row in baseline if row["scan"] == name), key=lambda row: int(row["depth"]))
    shallowest = next((row for row in rows if larger(row) >= ours), None)
    return [figures["vertices"] / int(row["vertices"]) if row else None
            for row in (shallowest, min(rows, key=larger, default=None))]


def target_text(name, figures, targets):
    for row in targets:
        if row["scan"] == name:
            pairs = [("mesh to truth", "mesh_to_truth", "rms_mesh_to_truth"),
                     ("truth to mesh", "truth_to_mesh", "rms_truth_to_mesh"), ("normals", "normal_angle", "normal_angle")]
            missed = [f"{title} > {row[column]}" for title, figure, column in pairs
                      if figures[figure] > float(row[column])]
            return "missed: " + ", ".join(missed) if missed else "met"
    return ""


def table(results, version, samples, data):
    baseline = read_tsv(data / "poisson-baseline.tsv" if data else None)
    targets = read_tsv(data / "targets.tsv" if data else None)
    lines = [
        "# Regression board",
        "",
        "Written by `scripts/board.py`; do not edit. Virtual scans, reconstructed with default options and measured against the",
        "surface they were made from. How the scans are made: [virtual scans](../method/virtual-scans.md).",
        "",
        "* RMS of the distances, mesh to truth and truth to mesh, in % of the diagonal of the truth; mean normal angle.",
        "* c / l / χ: components, boundary loops and Euler number of the mesh, in bold where the truth has others (in brackets);",
        "  nm: non-manifold edges and vertices.",
        "* Control vertices; over the vertices of screened Poisson at its shallowest depth that is not more accurate (by the "
        "larger",
        "  of the two RMS), and at its most accurate depth; whether the targets are met. For scans of which these are known.",
        "* Processor time and peak memory of the chain, file to file.",
        "",
        f"{version}, {samples} samples each way, on {platform.machine()} with {os.cpu_count()} processors.",
        "", "",
    ]
    head = ["scan", "points", "RMS", "normals", "c / l / χ", "nm", "vertices", "of Poisson's", "targets", "time", "memory"]
    rows = []
    for name, (figures, found, truth, points) in results.items():
        topology = " / ".join(map(str, found))
        if found != truth:
            topology = f"**{topology}** ({' / '.join(map(str, truth))})"
        shares = poisson_shares(name, figures, baseline)
        share_text = " / ".join("–" if s is None else f"{s:.2f}" for s in shares) if any(shares) else ""
        rows.append([
            name, f"{points:,}", f"{figures['mesh_to_truth']:.4f} / {figures['truth_to_mesh']:.4f}",
            f"{figures['normal_angle']:.2f}°", topology, f"{figures['nonmanifold']}", f"{figures['vertices']:,}",
            share_text, target_text(name, figures, targets), f"{figures['cpu_s']:.1f} s", f"{figures['memory_MB']:.0f} MB"])
    return "\n".join(lines) + pages.table(head, rows)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=GPSRECON)
    add_data_option(parser)
    parser.add_argument("--quick", action="store_true", help="a few small scans only; writes no table unless told to")
    parser.add_argument("--only", metavar="REGEX", help="scans of such names only; writes no table unless told to")
    parser.add_argument("--update", action="store_true", help="record the figures and their noise")
    parser.add_argument("--record", type=Path, default=ROOT / "docs/evidence/board.json")
    parser.add_argument("--table", type=Path, help="where the table goes (default: docs/evidence/board.md)")
    parser.add_argument("--points", type=int, help="points of the scans of shapes (default: by grade)")
    parser.add_argument("--samples", type=int, default=200_000, help="samples of each comparison, each way")
    parser.add_argument("--threads", type=int, default=2)
    return parser.parse_args()


def run_board(options):
    program = Gpsrecon(options.program, options.threads)
    record = json.loads(options.record.read_text()) if options.record.exists() else {"scans": {}}
    wanted = [scan for scan in find_scans(options.data, options.points)
              if (not options.quick or scan.name in QUICK) and (not options.only or re.search(options.only, scan.name))]
    if not wanted:
        raise Failure("there is no such scan")
    results, worse = {}, []
    for scan in wanted:
        with tempfile.TemporaryDirectory(prefix="gpsrecon-board-") as folder:
            work = Path(folder)
            scan.make(program, work)
            (info,) = json.loads(program.run("info", scan.truth, "--json"))
            truth = tuple(info["topology"][key] for key in ("components", "boundary_loops", "euler"))
            figures, found = measure(program, scan, truth, SEED, options.samples, work)
            points = json.loads((work / "mesh.report.json").read_text())["input"]["points"]
            results[scan.name] = figures, found, truth, points
            print(f"{scan.name}: {figures['mesh_to_truth']:.4f} / {figures['truth_to_mesh']:.4f} %, "
                  f"{figures['normal_angle']:.2f} deg, {figures['vertices']} vertices", flush=True)
            if options.update:
                repeats = [measure(program, scan, truth, seed, options.samples, work)[0] for seed in NOISE_SEEDS]
                record["scans"][scan.name] = {"figures": figures, "noise": noise_of(figures, repeats)}
            elif scan.name in record["scans"]:
                worse += regressions(scan.name, figures, record["scans"][scan.name])
            else:
                print(f"{scan.name}: nothing is recorded of it", file=sys.stderr)
    if options.update:
        record["noise"] = (f"twice the largest deviation when reconstruction and comparison are repeated with the seeds "
                           f"{', '.join(map(str, NOISE_SEEDS))} instead of {SEED}; at least 1 % of distances and angles and "
                           "2 % of vertices; processor time may triple and memory grow by half")
        record["version"], record["samples"] = program.version(), options.samples
        options.record.write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
    whole = not options.quick and not options.only
    if options.table or whole:
        text = table(results, program.version(), options.samples, options.data)
        (options.table or ROOT / "docs/evidence/board.md").write_text(text)
    for line in worse:
        print(f"worse: {line}", file=sys.stderr)
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(exit_code_of(lambda: run_board(parse_arguments())))
