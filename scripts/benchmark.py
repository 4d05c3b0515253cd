#!/usr/bin/python3
"""Compares gpsrecon with other reconstructions of the same points, in one run on one machine, and writes a page about it.

  accuracy  virtual scans with known truth: gpsrecon, normals + Poisson at several depths, advancing front, CGAL's Poisson
  budget    gpsrecon held to a tenth of the vertices of Poisson, at each depth
  growth    time and memory from 10^4 to 10^7 points of one surface
  ridge     the surface against the density ridge of its Gaussians

The Poisson reconstructions are PCL's, Open3D's if python3-open3d is there, and the program PoissonRecon if it is on the
PATH. All get normals by the program peer_normals, whose time counts. The scans are those of analytic shapes, made by
`gpsrecon scan`, and those that GPSRECON_DATA_DIR holds as scans/NAME.sN.ply with truth/NAME.ply.

Every measurement is a row of OUT/results.csv, written as soon as it is made: a run that was stopped goes on where it
was. Then OUT/results.json, OUT/benchmark.md and OUT/pictures/benchmark/ are made. Docs: docs/evidence/benchmark.md.

Exit codes: 0 done (a reconstruction that fails is a result), 2 usage, 3 a program that measures failed,
130 stopped.
"""

import argparse
import csv
import hashlib
import json
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmark_page import GROWTH_SHAPE, RIDGE_SAMPLES, peak, size_of, total, write_page
from lab.runner import ROOT, Failure, Gpsrecon, ProgramFailed, RunFailed, exit_code_of, output_of, run_measured
from lab.scans import SEED, Scan, add_data_option, scans_in

DEPTHS = (7, 8, 9, 10)
DETAILS = (0.25, 0.35, 0.5, 0.7, 1.4)  # besides 1, the default
GROWTH_DEPTH = 8
# Of the grades that are noisy, normals are estimated from more neighbours.
NEIGHBORS = {"s1": 18, "s2": 18, "s3": 36}

# Shapes with a third of the points of their grade, as on the regression board; for the quick run still fewer.
FULL_SHAPES = {"block.s2": 50_000, "fins.s1": 100_000, "gyroid.s2": 50_000, "ripple.s2": 50_000, "vase.s3": 25_000}
QUICK_SHAPES = {"block.s2": 20_000, "ripple.s1": 30_000, "vase.s3": 15_000}
# Where kernel and depth vary (Figure 14a), and errors are shown as histograms (Figure 13c).
FULL_SWEEPS = {"nefertiti.s1", "koala.s2", "spot.s3", "block.s2"}
QUICK_SWEEPS = {"block.s2"}
FULL_GROWTH = (10_000, 31_623, 100_000, 316_228, 1_000_000, 3_162_278, 10_000_000)
QUICK_GROWTH = (10_000, 100_000, 1_000_000)
RIDGE_SHAPES = {"ripple.s2": 50_000, "knot.s2": 50_000}
QUICK_RIDGE_SHAPES = {"ripple.s2": 20_000, "knot.s2": 20_000}

UNREADABLE_FILE = 3  # the exit code of gpsrecon

KEYS = ("part", "scan", "method", "setting")
NUMBERS = ("points", "vertices", "faces", "bytes_mesh", "bytes_covmesh", "normals_wall_s", "normals_cpu_s",
           "normals_memory_MB", "wall_s", "cpu_s", "memory_MB", "rms_mesh_to_truth", "rms_truth_to_mesh", "normal_angle",
           "self_mean", "self_median", "self_rms", "self_max", "components", "boundary_loops", "euler", "nonmanifold",
           "control_vertices", "ridge_mean", "ridge_median", "ridge_rms", "ridge_p95", "ridge_max",
           "ridge_lost", "sigma0", "load")
# status: ok, or what went wrong. The histograms are JSON: [[edges], [counts]] of shares of the diagonal.
COLUMNS = KEYS + ("status",) + NUMBERS + ("self_histogram", "truth_histogram")


# ---------------------------------------------------------------------------------------------------------------------
# Programs


OPEN3D_SCRIPT = """
import sys, open3d as o3d
cloud = o3d.io.read_point_cloud(sys.argv[1])
mesh, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=int(sys.argv[3]))
assert o3d.io.write_triangle_mesh(sys.argv[2], mesh)
"""


class Method:
    """A way to reconstruct. `command(points, mesh, setting)`; `points` have normals if it needs them."""

    def __init__(self, name, title, command, settings=("",), needs_normals=True):
        self.name, self.title, self.command = name, title, command
        self.settings, self.needs_normals = settings, needs_normals


class Programs:
    """What is there to run."""

    def __init__(self, folder, threads):
        self.folder = folder
        self.gpsrecon = Gpsrecon(folder / "gpsrecon", threads)
        if not self.gpsrecon.path.exists():
            raise Failure(f"{self.gpsrecon.path} is not there; build it with scripts/build.sh -DGPSRECON_BUILD_BENCHMARKS=ON")
        self.poissons = self.find_poissons()

    def tool(self, name):
        path = self.folder / name
        return path if path.exists() else None

    def reconstruct(self, points, mesh, *options):
        return self.gpsrecon.command(points, mesh, "--seed", SEED, *options)

    def find_poissons(self):
        """Poisson reconstructions, the most recent code first."""
        found = []
        binary = shutil.which("PoissonRecon")
        if binary:
            found.append(Method("PoissonRecon", "PoissonRecon (the authors' program)",
                                lambda points, mesh, depth: [binary, "--in", points, "--out", mesh, "--depth", depth],
                                DEPTHS))
        python = open3d_python()
        if python:
            found.append(Method("open3d_poisson", "Open3D (PoissonRecon inside)",
                                lambda points, mesh, depth: [python, "-c", OPEN3D_SCRIPT, points, mesh, depth], DEPTHS))
        pcl = self.tool("peer_pcl_poisson")
        if pcl:
            found.append(Method("pcl_poisson", "PCL (Kazhdan's code, 2013)",
                                lambda points, mesh, depth: [pcl, points, mesh, depth], DEPTHS))
        return found

    def methods(self):
        found = [Method("gpsrecon", "gpsrecon", lambda points, mesh, detail: self.reconstruct(
            points, mesh, *(["--detail", detail] if detail else [])), ("",) + DETAILS, False)]
        found += self.poissons
        cgal_poisson, front = self.tool("peer_cgal_poisson"), self.tool("peer_cgal_front")
        if cgal_poisson:
            found.append(Method("cgal_poisson", "Poisson on a Delaunay triangulation, CGAL",
                                lambda points, mesh, _: [cgal_poisson, points, mesh]))
        if front:
            found.append(Method("cgal_front", "advancing front, CGAL", lambda points, mesh, _: [front, points, mesh],
                                needs_normals=False))
        return found


def open3d_python():
    """A Python that has Open3D; None if there is none."""
    for python in (sys.executable, "/usr/bin/python3"):
        look = "import importlib.util, sys; sys.exit(importlib.util.find_spec('open3d') is None)"
        if os.path.exists(python) and subprocess.run([python, "-c", look], capture_output=True).returncode == 0:
            return python
    return None


# ---------------------------------------------------------------------------------------------------------------------
# Scans


class BenchmarkScan(Scan):
    normals = None  # of the points, measured by `oriented`

    def oriented(self, programs, work, timeout, memory_limit):
        """The points with normals, and what these cost; made once. Raises RunFailed, every time if it fails."""
        if isinstance(self.normals, RunFailed):
            raise self.normals
        if self.normals is None:
            tool, path = programs.tool("peer_normals"), work / f"{self.name}.normals.ply"
            if tool is None:
                raise Failure("peer_normals is not there; build it with scripts/build.sh -DGPSRECON_BUILD_BENCHMARKS=ON")
            try:
                cost = run_measured([tool, self.points, path, NEIGHBORS.get(self.grade, 18)], timeout, memory_limit)
            except RunFailed as failed:
                self.normals = RunFailed(f"normals: {failed}")
                raise self.normals
            self.normals = path, {f"normals_{key}": value for key, value in cost.items()}
        return self.normals


def scans_of(shapes):
    return [BenchmarkScan(name, size) for name, size in shapes.items()]


# ---------------------------------------------------------------------------------------------------------------------
# Results


class Results:
    """The rows of a run, kept in a file as they come, and told to `say`."""

    def __init__(self, path, say=lambda line: print(line, flush=True)):
        self.path, self.rows, self.say = path, [], say
        if path.exists():
            self.rows = self.read(path)
            # A run that was killed may have left half a line behind.
            self.write(path, self.rows)
        else:
            self.write(path, [])

    @staticmethod
    def write(path, rows):
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)

    @staticmethod
    def read(path):
        text = path.read_text()
        if text.split("\n", 1)[0].strip() != ",".join(COLUMNS):
            raise Failure(f"{path} was written by another version of this program; begin anew with --restart")
        whole = text[: text.rfind("\n") + 1]
        rows = []
        for row in csv.DictReader(whole.splitlines()):
            if None in row or None in row.values():
                continue
            rows.append({key: number(value) if key in NUMBERS else value for key, value in row.items()})
        return rows

    def has(self, *key):
        return any(tuple(row[k] for k in KEYS) == tuple(map(str, key)) for row in self.rows)

    def add(self, part, scan, method, setting, figures):
        row = {column: "" for column in COLUMNS}
        row.update({k: str(v) for k, v in zip(KEYS, (part, scan, method, setting))}, status="ok",
                   load=round(os.getloadavg()[0], 2))
        row.update(figures)
        with self.path.open("a", newline="") as file:
            csv.DictWriter(file, COLUMNS).writerow(row)
        self.rows.append(row)
        self.say(describe(row))


def number(text):
    return "" if text == "" else float(text) if re.search(r"[.eni]", text) else int(text)


def describe(row):
    name = " ".join(row[key] for key in KEYS if row[key] != "")
    if row["status"] != "ok":
        return f"{name}: {row['status']}"
    parts = []
    if row["cpu_s"] != "":
        parts.append(f"{total(row, 'cpu_s'):.1f} s CPU, {peak(row):.0f} MB")
    if row["rms_mesh_to_truth"] != "":
        parts.append(f"{row['rms_mesh_to_truth']:.4f} / {row['rms_truth_to_mesh']:.4f} %")
    if row["vertices"] != "":
        parts.append(f"{size_of(row)} vertices")
    if row["ridge_mean"] != "":
        parts.append(f"mean {row['ridge_mean']:.4f} %, {row['ridge_lost']} lost")
    return f"{name}: {', '.join(parts)}"


# ---------------------------------------------------------------------------------------------------------------------
# Measuring


class Benchmark:
    def __init__(self, options, programs, results, work):
        self.options, self.programs, self.results, self.work = options, programs, results, work

    def judge(self, mesh, scan):
        """Accuracy against truth, both ways, and distances of the points to the mesh (shares of the diagonal, in %)."""
        samples = ["--samples", self.options.samples, "--seed", SEED, "--report", "-"]
        truth = json.loads(self.programs.gpsrecon.run("compare", mesh, scan.truth, *samples))
        own = json.loads(self.programs.gpsrecon.run("compare", mesh, scan.points, *samples))["points_to_surface"]
        there, back = truth["reference"]["mesh_to_reference"], truth["reference"]["reference_to_mesh"]
        topology = truth["mesh"]["topology"]
        rounded = lambda value: round(100 * value, 6)
        return {
            "points": int(own["count"]), "vertices": truth["mesh"]["vertices"], "faces": truth["mesh"]["faces"],
            "rms_mesh_to_truth": rounded(there["distance"]["rel"]["rms"]),
            "rms_truth_to_mesh": rounded(back["distance"]["rel"]["rms"]),
            "normal_angle": round(there["normals"]["mean_deg"], 4),
            "self_mean": rounded(own["rel"]["mean"]), "self_median": rounded(own["rel"]["median"]),
            "self_rms": rounded(own["rel"]["rms"]), "self_max": rounded(own["rel"]["max"]),
            "components": topology["components"], "boundary_loops": topology["boundary_loops"],
            "euler": topology["euler"],
            "nonmanifold": topology["nonmanifold_edges"] + topology["nonmanifold_vertices"],
            "self_histogram": json.dumps([own["histogram"]["edges_rel"], own["histogram"]["counts"]]),
            "truth_histogram": json.dumps([there["distance"]["histogram"]["edges_rel"],
                                           there["distance"]["histogram"]["counts"]]),
        }

    def covmesh_of(self, mesh):
        """Bytes and size of the covariance mesh beside a mesh of gpsrecon."""
        covmesh = mesh.with_name(mesh.stem + ".covmesh.ply")
        report = json.loads(mesh.with_name(mesh.stem + ".report.json").read_text())
        return {"bytes_covmesh": covmesh.stat().st_size, "control_vertices": report["covmesh"]["vertices"]}

    def measure(self, part, scan, method, setting, command=None, judged=True):
        """One row, unless it is there. `command` replaces the method's."""
        if self.results.has(part, scan.name, method.name, setting):
            return
        limits = self.options.timeout, self.options.memory_limit
        scan.make(self.programs.gpsrecon, self.work)
        with tempfile.TemporaryDirectory(dir=self.work) as folder:
            mesh, figures = Path(folder) / "mesh.ply", {}
            try:
                points = scan.points
                if method.needs_normals:
                    points, cost = scan.oriented(self.programs, self.work, *limits)
                    figures.update(cost)
                figures.update(run_measured(command(points, mesh) if command else method.command(points, mesh, setting),
                                            *limits))
                figures["bytes_mesh"] = mesh.stat().st_size
                if method.name == "gpsrecon":
                    figures.update(self.covmesh_of(mesh))
                if judged:
                    figures.update(self.judge(mesh, scan))
            except ProgramFailed as failed:
                if failed.code != UNREADABLE_FILE or f"error: {mesh}: " not in str(failed):
                    raise
                figures["status"] = f"no mesh: {str(failed).rsplit(': ', 1)[-1]}"
            except RunFailed as failed:
                figures["status"] = str(failed)
            self.results.add(part, scan.name, method.name, setting, figures)

    def accuracy(self, scans, sweeps):
        for scan in scans:
            for method in self.wanted(self.programs.methods()):
                for setting in method.settings:
                    if method.name == "gpsrecon" and setting != "" and scan.name not in sweeps:
                        continue
                    self.measure("accuracy", scan, method, setting)

    def budget(self, scans):
        """gpsrecon with a tenth of the vertices of Poisson at each depth; of all that are there, the first."""
        for scan in scans:
            for method in self.wanted(self.programs.poissons)[:1]:
                for row in list(self.results.rows):
                    if (row["part"], row["scan"], row["method"], row["status"]) != ("accuracy", scan.name, method.name, "ok"):
                        continue
                    wanted = max(4, int(row["vertices"]) // 10)
                    gpsrecon = Method("gpsrecon", "gpsrecon", None, needs_normals=False)
                    self.measure("budget", scan, gpsrecon, f"{method.name} {row['setting']}",
                                 lambda points, mesh: self.programs.reconstruct(points, mesh, "--budget", wanted))

    def growth(self, sizes):
        for size in sizes:
            scan = BenchmarkScan(f"{GROWTH_SHAPE}.s1", size)
            scan.name += f"@{size}"  # what tells the rows apart
            depths = {method.name: GROWTH_DEPTH for method in self.programs.poissons}
            for method in self.wanted(self.programs.methods()):
                # Of CGAL's Poisson one size more would take longer than all else.
                if method.name == "cgal_poisson" or (method.name != "gpsrecon" and size > self.options.peer_points):
                    continue
                self.measure("growth", scan, method, depths.get(method.name, ""), judged=False)
            for path in self.work.glob(f"{scan.name}.*"):
                path.unlink()

    def ridge(self, scans):
        tool = self.programs.tool("ridge_of_covmesh")
        for scan in scans if tool else []:
            for setting, options in (("fitted", []), ("not fitted", ["--no-fit"])):
                if self.results.has("ridge", scan.name, "gpsrecon", setting):
                    continue
                scan.make(self.programs.gpsrecon, self.work)
                mesh = self.work / "ridge.ply"
                sample_file = self.options.out / f"ridge.{scan.name}.{setting.replace(' ', '-')}.ply"
                self.programs.gpsrecon.run(scan.points, mesh, "--seed", SEED, *options)
                covmesh = mesh.with_name("ridge.covmesh.ply")
                found = json.loads(output_of([tool, covmesh, RIDGE_SAMPLES, sample_file]))
                figures = {f"ridge_{key}": round(100 * found[f"{key}_rel"], 6)
                           for key in ("mean", "median", "rms", "p95", "max")}
                figures.update(ridge_lost=found["lost"], sigma0=round(100 * found["sigma0_rel"], 6),
                               points=found["samples"])
                self.results.add("ridge", scan.name, "gpsrecon", setting, figures)

    def wanted(self, methods):
        return [m for m in methods if not self.options.methods or m.name in self.options.methods]


# ---------------------------------------------------------------------------------------------------------------------
# The run


def build_programs():
    """Installs what is missing, builds what has changed, and returns the folder of the programs."""
    for command in (["scripts/install_packages.sh", "benchmark"],
                    ["scripts/build.sh", "-DGPSRECON_BUILD_BENCHMARKS=ON", "benchmark_programs"]):
        if subprocess.run(command, cwd=ROOT, stdout=sys.stderr).returncode != 0:
            raise Failure(f"{' '.join(command)} failed")
    return ROOT / "build/release/bin"


def describe_machine(programs, options):
    info = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    model = re.search(r"^model name\s*: (.*)$", info, re.M)
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    compiler = subprocess.run(["c++", "--version"], capture_output=True, text=True).stdout if shutil.which("c++") else ""
    release = Path("/etc/os-release")
    system = re.search(r'^PRETTY_NAME="(.*)"$', release.read_text(), re.M) if release.exists() else None
    return {
        "version": programs.gpsrecon.version(),
        "program": hashlib.sha256(programs.gpsrecon.path.read_bytes()).hexdigest()[:16],
        "cpu": model.group(1) if model else platform.machine(), "cores": os.cpu_count(), "memory_GB": memory / 2**30,
        "compiler": compiler.splitlines()[0] if compiler else "compiler not known",
        "system": system.group(1) if system else platform.system(), "threads": options.threads,
        "samples": options.samples, "quick": options.quick,
    }


def same_run(out, machine, methods, restart):
    """Rows of one table must be of one machine and program: throws where they would not be."""
    file = out / "machine.json"
    if restart:
        (out / "results.csv").unlink(missing_ok=True)
    elif file.exists():
        before = json.loads(file.read_text())["machine"]
        changed = [key for key in machine if before.get(key) != machine[key]]
        if changed:
            raise Failure(f"{out} holds a run with another {', '.join(changed)}; finish it with what it was begun with, or "
                          "begin anew with --restart")
    file.write_text(json.dumps({"machine": machine, "methods": methods}, indent=1) + "\n")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="three small scans, up to 10^6 points: minutes")
    parser.add_argument("--out", type=Path, help="folder of the results (default: build/benchmark/full or quick)")
    parser.add_argument("--programs", type=Path,
                        help="folder of gpsrecon and the programs peer_* (default: build/release/bin, after building them)")
    add_data_option(parser)
    parser.add_argument("--parts", default="accuracy,budget,growth,ridge", help="which parts, separated by commas")
    parser.add_argument("--only", metavar="REGEX", help="scans of such names only")
    parser.add_argument("--methods", type=lambda text: text.split(","), default=[], metavar="NAME,...",
                        help="such methods only: gpsrecon, PoissonRecon, open3d_poisson, pcl_poisson, cgal_poisson, cgal_front")
    parser.add_argument("--points", type=int, help="points of the scans of shapes (default: by scan)")
    parser.add_argument("--samples", type=int, default=200_000, help="samples of each comparison, each way")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--timeout", type=float, default=1800, help="seconds after which a reconstruction has failed")
    parser.add_argument("--peer-points", type=int, default=1_000_000,
                        help="most points that others than gpsrecon get in the growth part (normals take 2 GB at 10^6)")
    parser.add_argument("--memory-limit", type=float,
                        help="address space a reconstruction may take, in GB (default: 0.9 of the memory)")
    parser.add_argument("--restart", action="store_true", help="forget what OUT holds")
    parser.add_argument("--page-only", action="store_true", help="measure nothing, write the page from what OUT holds")
    parser.add_argument("--publish", action="store_true", help="also write docs/evidence/benchmark.md and its pictures")
    options = parser.parse_args()
    options.parts = options.parts.split(",")
    for part in options.parts:
        if part not in ("accuracy", "budget", "growth", "ridge"):
            parser.error(f"--parts: there is no part {part}")
    options.out = options.out or ROOT / "build/benchmark" / ("quick" if options.quick else "full")
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    options.memory_limit = int(options.memory_limit * 1e9 if options.memory_limit else 0.9 * memory)
    return options


def run(options):
    options.out.mkdir(parents=True, exist_ok=True)
    if options.page_only:
        state = json.loads((options.out / "machine.json").read_text())
        machine, methods = state["machine"], state["methods"]
        rows = Results.read(options.out / "results.csv")
    else:
        programs = Programs(options.programs or build_programs(), options.threads)
        machine = describe_machine(programs, options)
        methods = {m.name: m.title for m in programs.methods() if not options.methods or m.name in options.methods}
        same_run(options.out, machine, methods, options.restart)
        results = Results(options.out / "results.csv")
        if not any("poisson" in name.lower() for name in methods):
            print("benchmark.py: there is no Poisson to compare with", file=sys.stderr)
        chosen = lambda scans: [s for s in scans if not options.only or re.search(options.only, s.name)]
        scans = chosen(scans_of(QUICK_SHAPES) if options.quick else
                       scans_of(FULL_SHAPES) + scans_in(options.data, BenchmarkScan))
        ridge_scans = chosen(scans_of(QUICK_RIDGE_SHAPES if options.quick else RIDGE_SHAPES))
        if options.data and (options.data / "scans/koala.s2.ply").exists():
            ridge_scans += chosen([BenchmarkScan("koala.s2", None, options.data)])
        if options.points:
            for scan in scans + ridge_scans:
                scan.size = scan.size and options.points
        with tempfile.TemporaryDirectory(prefix="gpsrecon-benchmark-") as folder:
            benchmark = Benchmark(options, programs, results, Path(folder))
            if "accuracy" in options.parts:
                for scan in scans:
                    benchmark.accuracy([scan], QUICK_SWEEPS if options.quick else FULL_SWEEPS)
                    if "budget" in options.parts:
                        benchmark.budget([scan])
            if "ridge" in options.parts:
                benchmark.ridge(ridge_scans)
            if "growth" in options.parts and not options.only:
                benchmark.growth(QUICK_GROWTH if options.quick else FULL_GROWTH)
        rows = results.rows
    (options.out / "results.json").write_text(
        json.dumps({"machine": machine, "methods": methods, "rows": rows}, indent=1) + "\n")
    write_page(options.out, options.out / "benchmark.md", rows, machine, methods)
    if options.publish:
        write_page(options.out, ROOT / "docs/evidence/benchmark.md", rows, machine, methods)


def main():
    # As for Ctrl-C: what is running is stopped, too.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        run(parse_arguments())
        return 0
    except KeyboardInterrupt:
        print("benchmark.py: stopped; the same command goes on where it was", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(exit_code_of(main))
