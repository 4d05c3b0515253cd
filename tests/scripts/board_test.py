"""The regression board passes on what it recorded and fails on a worsened figure: board_test.py PROGRAM"""

import json
import tempfile
import unittest
from pathlib import Path

from support import PROGRAM, run_script

import board


class Board(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.record = Path(cls.folder.name) / "board.json"
        cls.table = Path(cls.folder.name) / "board.md"
        result = cls.run_board("--update", "--table", cls.table)
        assert result.returncode == 0, result.stderr
        cls.recorded = json.loads(cls.record.read_text())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def run_board(cls, *arguments, program=PROGRAM):
        return run_script("board.py", "--program", program, "--data", cls.folder.name, "--only", "^sphere.s3$",
                          "--points", 2500, "--samples", 5000, "--record", cls.record, *arguments)

    def with_figures(self, change):
        """Runs the board against changed figures of the record."""
        record = json.loads(json.dumps(self.recorded))
        change(record["scans"]["sphere.s3"]["figures"])
        self.record.write_text(json.dumps(record))
        return self.run_board()

    def test_passes_on_what_it_recorded(self):
        result = self.with_figures(lambda figures: None)
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_passes_within_the_noise_and_when_better(self):
        noise = self.recorded["scans"]["sphere.s3"]["noise"]

        def change(figures):
            figures["mesh_to_truth"] -= 0.9 * noise["mesh_to_truth"]
            figures["normal_angle"] *= 2
        self.assertEqual(self.with_figures(change).returncode, 0)

    def test_fails_on_each_worsened_figure_and_names_it(self):
        noise = self.recorded["scans"]["sphere.s3"]["noise"]
        titles = {"mesh_to_truth": "RMS mesh to truth", "truth_to_mesh": "RMS truth to mesh",
                  "normal_angle": "mean normal angle", "wrong_loops": "boundary loops", "wrong_euler": "Euler number",
                  "wrong_components": "components", "nonmanifold": "non-manifold", "vertices": "control vertices",
                  "memory_MB": "peak memory"}
        for figure, title in titles.items():
            def change(figures, figure=figure):
                figures[figure] -= 1.1 * noise[figure] + 1e-4
            result = self.with_figures(change)
            self.assertEqual(result.returncode, 1, figure)
            self.assertRegex(result.stderr, f"^worse: sphere.s3: {title}.*\n$")

    def test_table_has_the_scan(self):
        (row,) = [line for line in self.table.read_text().splitlines() if line.startswith("| sphere.s3 |")]
        figures = self.recorded["scans"]["sphere.s3"]["figures"]
        self.assertIn(f"| 2,500 | {figures['mesh_to_truth']:.4f} / {figures['truth_to_mesh']:.4f} |", row)
        self.assertIn("| 1 / 0 / 2 |", row)

    def test_tells_a_program_that_fails_from_a_regression(self):
        result = self.run_board(program="/bin/false")
        self.assertEqual(result.returncode, 3)
        self.assertIn("/bin/false", result.stderr)


class Rules(unittest.TestCase):
    """What is compared with what, on made-up figures."""

    def test_share_is_of_poissons_shallowest_depth_that_is_not_more_accurate(self):
        baseline = [{"scan": "a", "depth": d, "vertices": v, "rms_mesh_to_truth": m, "rms_truth_to_mesh": t}
                    for d, v, m, t in [("9", "4000", "0.02", "0.01"), ("7", "100", "0.05", "0.01"),
                                       ("8", "1000", "0.01", "0.03")]]
        share = lambda m, t: board.poisson_shares(
            "a", {"mesh_to_truth": m, "truth_to_mesh": t, "vertices": 50}, baseline)
        best = 50 / 4000
        self.assertEqual(share(0.04, 0.01), [0.5, best])  # depth 7: 0.05 is not below 0.04
        self.assertEqual(share(0.05, 0.01), [0.5, best])
        self.assertEqual(share(0.06, 0.01), [None, best])
        self.assertEqual(share(0.001, 0.05), [0.5, best])
        self.assertEqual(board.poisson_shares("b", {"mesh_to_truth": 1, "truth_to_mesh": 1}, baseline), [None, None])

    def test_targets_are_met_by_all_three_figures(self):
        targets = [{"scan": "a", "rms_mesh_to_truth": "0.1", "rms_truth_to_mesh": "0.2", "normal_angle": "3"}]
        text = lambda m, t, n: board.target_text(
            "a", {"mesh_to_truth": m, "truth_to_mesh": t, "normal_angle": n}, targets)
        self.assertEqual(text(0.1, 0.2, 3), "met")
        self.assertEqual(text(0.11, 0.2, 3.5), "missed: mesh to truth > 0.1, normals > 3")
        self.assertIn("truth to mesh > 0.2", text(0, 0.3, 0))

    def test_noise_is_twice_the_largest_deviation_but_not_below_the_floor(self):
        figures = {"mesh_to_truth": 1.0, "vertices": 100}
        repeats = [{"mesh_to_truth": 0.9, "vertices": 100}, {"mesh_to_truth": 1.05, "vertices": 100}]
        self.assertEqual(board.noise_of(figures, repeats), {"mesh_to_truth": 0.2, "vertices": 2})


if __name__ == "__main__":
    unittest.main()
