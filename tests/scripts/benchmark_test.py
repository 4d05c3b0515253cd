"""The benchmark measures, goes on where it was stopped, and draws the right conclusions: benchmark_test.py PROGRAM"""

import importlib.util
import json
import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

from support import PROGRAM, ROOT, run_script

import benchmark
import benchmark_page

HAS_MATPLOTLIB = importlib.util.find_spec("matplotlib") is not None


def write_script(path, text):
    path.write_text("#!/bin/sh\n" + text)
    path.chmod(0o755)


def row(**figures):
    result = {column: "" for column in benchmark.COLUMNS}
    result.update(part="accuracy", scan="a", status="ok", setting="")
    result.update(figures)
    return result


class Whole(unittest.TestCase):
    """On a sphere, with stand-ins for the other programs: Poisson that returns the truth, another that finds
    nothing, and a front that fails."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        base = Path(cls.folder.name)
        cls.out, cls.programs, cls.path = base / "out", base / "programs", base / "path"
        cls.programs.mkdir()
        cls.path.mkdir()
        (cls.programs / "gpsrecon").symlink_to(PROGRAM)
        truth = base / "truth.ply"
        subprocess.run([PROGRAM, "scan", "shape:block", base / "unused.ply", "--truth", truth, "--quiet"], check=True)
        write_script(cls.programs / "peer_normals", 'test "$3" = 18 && cp "$1" "$2"\n')
        write_script(cls.programs / "peer_cgal_front", 'echo it is too steep >&2\nexit 9\n')
        write_script(cls.programs / "peer_cgal_poisson", """cat > "$2" <<END
ply
format ascii 1.0
element vertex 0
property float x
property float y
property float z
element face 0
property list uchar int vertex_indices
end_header
END
""")
        # Called as: PoissonRecon --in POINTS --out MESH --depth D
        write_script(cls.path / "PoissonRecon", f'test "$2" != "$4" && test -f "$2" && test "$6" -ge 7 && cp {truth} "$4"\n')
        cls.first = cls.run_benchmark()
        assert cls.first.returncode == 0, cls.first.stderr
        cls.rows = benchmark.Results.read(cls.out / "results.csv")
        cls.state = json.loads((cls.out / "results.json").read_text())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def run_benchmark(cls, *arguments):
        environment = {**os.environ, "PATH": f"{cls.path}:{os.environ['PATH']}"}
        return run_script("benchmark.py", "--quick", "--programs", cls.programs, "--out", cls.out, "--only", "^block.s2$",
                          "--points", 2500, "--samples", 2000, "--parts", "accuracy,budget",
                          "--methods", "gpsrecon,PoissonRecon,cgal_poisson,cgal_front", *arguments, env=environment)

    def lines(self):
        return (self.out / "results.csv").read_text().splitlines()

    def test_writes_csv_json_page_and_pictures(self):
        self.assertEqual(self.state["rows"], self.rows)
        page = (self.out / "benchmark.md").read_text()
        self.assertIn("### block.s2, 2,500 points", page)
        self.assertIn("PoissonRecon, depth 7", page)
        self.assertIn(self.state["machine"]["cpu"], page)
        for picture in ("effort", "histograms"):
            self.assertIn(f"(pictures/benchmark/{picture}.png)", page)
            if not HAS_MATPLOTLIB:
                self.assertIn("python3-matplotlib", self.first.stderr)
                continue
            self.assertEqual((self.out / f"pictures/benchmark/{picture}.png").read_bytes()[1:4], b"PNG")

    def test_measures_the_program_and_what_it_made(self):
        (ours,) = benchmark_page.select(self.rows, part="accuracy", method="gpsrecon", setting="")
        self.assertEqual(ours["points"], 2500)
        self.assertGreater(ours["cpu_s"], 0)
        self.assertGreater(ours["memory_MB"], 0)
        self.assertLess(ours["rms_mesh_to_truth"], 1)
        self.assertEqual(sum(json.loads(ours["self_histogram"])[1]), 2500)
        self.assertEqual(ours["normals_cpu_s"], "")
        self.assertLess(ours["control_vertices"], ours["vertices"])

    def test_others_get_normals_that_count_and_are_judged_alike(self):
        rows = benchmark_page.select(self.rows, part="accuracy", method="PoissonRecon")
        self.assertEqual([r["setting"] for r in rows], ["7", "8", "9", "10"])
        for r in rows:
            self.assertEqual((r["rms_mesh_to_truth"], r["rms_truth_to_mesh"]), (0, 0))  # it returns the truth
            self.assertNotEqual(r["normals_cpu_s"], "")
            # The noise of the scan is 0.1 % along the ray; its median 0.67 times that, shorter by the cosine.
            self.assertAlmostEqual(r["self_median"], 0.05, delta=0.02)

    def test_a_failure_is_a_result(self):
        (front,) = [r for r in self.rows if r["method"] == "cgal_front"]
        self.assertEqual(front["status"], "exit code 9: it is too steep")
        self.assertIn("exit code 9: it is too steep", (self.out / "benchmark.md").read_text())
        (nothing,) = [r for r in self.rows if r["method"] == "cgal_poisson"]
        self.assertRegex(nothing["status"], "^no mesh: holds no ")

    def test_budget_is_a_tenth_of_the_vertices_at_each_depth(self):
        rows = benchmark_page.select(self.rows, part="budget")
        self.assertEqual([r["setting"] for r in rows], [f"PoissonRecon {d}" for d in (7, 8, 9, 10)])
        poisson = benchmark_page.select(self.rows, part="accuracy", method="PoissonRecon")[0]
        for r in rows:
            self.assertLessEqual(r["control_vertices"], max(4, poisson["vertices"] // 10))

    def test_goes_on_where_it_was_stopped(self):
        before = self.lines()
        try:
            # All rows but the last, of which half was written.
            (self.out / "results.csv").write_text("\n".join(before[:-1]) + "\n" + before[-1][:20])
            self.run_benchmark()
            after = self.lines()
            self.assertEqual(after[:-1], before[:-1])  # times and all: nothing was measured again
            self.assertEqual(len(after), len(before))
            self.assertEqual(after[-1].split(",")[:4], before[-1].split(",")[:4])
        finally:
            (self.out / "results.csv").write_text("\n".join(before) + "\n")

    def test_when_stopped_stops_what_is_running(self):
        out, marker = self.out.parent / "stopped", self.out.parent / "front.pid"
        write_script(self.programs / "peer_cgal_poisson", f"echo $$ > {marker}\nexec sleep 100\n")
        try:
            command = [ROOT / "scripts/benchmark.py", "--quick", "--programs", self.programs, "--out", out, "--only", "^block",
                       "--points", "2500", "--samples", "2000", "--parts", "accuracy", "--methods", "cgal_poisson"]
            running = subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True)
            for _ in range(600):
                if marker.exists() and marker.read_text().strip():
                    break
                time.sleep(0.1)
            running.terminate()
            self.assertIn("goes on", running.communicate(timeout=60)[1])
            self.assertEqual(running.returncode, 130)
            # The system takes a moment to clear away what was killed; of itself it would sleep for longer.
            with self.assertRaises(ProcessLookupError):
                for _ in range(200):
                    os.kill(int(marker.read_text()), 0)
                    time.sleep(0.1)
            self.assertEqual(benchmark.Results.read(out / "results.csv"), [])
        finally:
            (self.programs / "peer_cgal_poisson").unlink()

    def test_writes_the_page_anew_but_for_the_notes(self):
        path = self.out / "benchmark.md"
        self.run_benchmark("--page-only")
        before = path.read_text()
        path.write_text("nothing left\n<!-- notes -->\nWhy so?\n<!-- end -->\nof it")
        result = self.run_benchmark("--page-only")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(path.read_text().replace("Why so?\n", ""), before)
        self.assertIn("Why so?", path.read_text())

    def test_refuses_to_mix_runs(self):
        result = self.run_benchmark("--samples", "3000")
        self.assertEqual(result.returncode, 3)
        self.assertIn("samples", result.stderr)
        self.assertIn("--restart", result.stderr)
        self.assertEqual(self.run_benchmark("--parts", "speed").returncode, 2)


class Rules(unittest.TestCase):
    """What is concluded, on made-up figures."""

    def test_normals_count(self):
        r = row(cpu_s=2.0, normals_cpu_s=3.0, memory_MB=50, normals_memory_MB=70)
        self.assertEqual((benchmark_page.total(r, "cpu_s"), benchmark_page.peak(r)), (5, 70))
        r = row(cpu_s=2.0, memory_MB=50)
        self.assertEqual((benchmark_page.total(r, "cpu_s"), benchmark_page.peak(r)), (2, 50))

    def test_equal_accuracy_is_judged_in_each_direction(self):
        poisson = row(rms_mesh_to_truth=0.02, rms_truth_to_mesh=0.03, normal_angle=2)
        verdict = lambda m, t, n: benchmark_page.equal_accuracy(
            poisson, row(rms_mesh_to_truth=m, rms_truth_to_mesh=t, normal_angle=n))
        self.assertEqual(verdict(0.02, 0.03, 2), (True, True, True))
        self.assertEqual(verdict(0.021, 0.01, 3), (False, True, False))
        self.assertEqual(verdict(0.01, 0.031, 1), (True, False, True))

    def figures(self, **changes):
        return row(**{**dict(method="gpsrecon", rms_mesh_to_truth=0.02, rms_truth_to_mesh=0.03, normal_angle=2.0, cpu_s=2.0,
                             memory_MB=50, bytes_mesh=9000, bytes_covmesh=800, vertices=100, control_vertices=10), **changes})

    def test_losses_are_against_the_most_accurate_depth(self):
        other = dict(method="pcl_poisson", bytes_covmesh="", control_vertices="")
        rows = [self.figures(),
                self.figures(**other, setting="7", rms_mesh_to_truth=0.9, cpu_s=1.0),  # faster, but not the best depth
                self.figures(**other, setting="8", rms_mesh_to_truth=0.01, cpu_s=1.5, normals_cpu_s=1.0)]
        found = benchmark_page.losses(rows, ["gpsrecon", "pcl_poisson"])
        self.assertEqual([f[:5] for f in found], [("a", "RMS mesh to truth", "%", 0.02, 0.01)])
        self.assertIn("| a | RMS mesh to truth | 0.0200 % | 0.0100 % | PCL Poisson, depth 8 |",
                      "\n".join(benchmark_page.loss_lines(rows, benchmark_page.titles_of(rows, []))))
        # The covariance mesh is what is stored.
        rows[2]["bytes_mesh"] = 799
        self.assertIn("bytes of the result", [f[1] for f in benchmark_page.losses(rows, ["pcl_poisson"])])
        rows[2]["status"] = "exit code 1"
        self.assertIn("processor time", [f[1] for f in benchmark_page.losses(rows, ["pcl_poisson"])])  # now depth 7 is the best

    def test_budget_table_pairs_each_depth(self):
        rows = [self.figures(method="pcl_poisson", setting="7", vertices=500), self.figures(method="pcl_poisson", setting="8"),
                self.figures(part="budget", setting="pcl_poisson 7", control_vertices=50, normal_angle=2.5),
                self.figures(part="budget", setting="pcl_poisson 8", rms_truth_to_mesh=0.04)]
        text = "\n".join(benchmark_page.budget_lines(rows, benchmark_page.titles_of(rows, [])))
        self.assertIn("| a | 7 | 500 | 0.0200 / 0.0300, 2.00° | 50 | **0.0200** / **0.0300**, 2.50° | yes |", text)
        self.assertRegex(text, r"\| a \| 8 \| .* \*\*0.0200\*\* / 0.0400, \*\*2.00°\*\* \| no \|")
        self.assertIn("Of 2 pairs gpsrecon is at least as accurate from mesh to truth in 2, from truth to mesh in 1, "
                      "in its normals in 1", text)

    def test_growth_ratio(self):
        rows = [self.figures(part="growth", scan=f"{benchmark_page.GROWTH_SHAPE}.s1@{n}", cpu_s=t)
                for n, t in ((1000, 2.0), (10000, 24.0))]
        ratio = lambda a, b: benchmark_page.growth_ratio(rows, "gpsrecon", a, b, lambda r: benchmark_page.total(r, "cpu_s"))
        self.assertEqual(ratio(1000, 10000), 12)
        self.assertIsNone(ratio(1000, 100000))

    def test_numbers_come_back_from_the_file(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "results.csv"
            results = benchmark.Results(path, say=lambda line: None)
            results.add("accuracy", "a", "gpsrecon", "", dict(vertices=7, cpu_s=1.5, status='odd, "quoted"'))
            results.add("growth", "a", "gpsrecon", 8, dict(cpu_s=1e-07, memory_MB=3))
            self.assertEqual(benchmark.Results(path).rows, results.rows)
            self.assertTrue(benchmark.Results(path).has("growth", "a", "gpsrecon", 8))
            self.assertFalse(benchmark.Results(path).has("growth", "a", "gpsrecon", 9))
            path.write_text("scan,colour\na,red\n")
            with self.assertRaisesRegex(benchmark.Failure, "another version"):
                benchmark.Results(path)


if __name__ == "__main__":
    unittest.main()
