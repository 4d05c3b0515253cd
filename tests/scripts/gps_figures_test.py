"""Control meshes, measures and tables of the figures: gps_figures_test.py PROGRAM

Exits with 77 (skipped) where the script lacks a package.
"""

import collections
import math
import tempfile
import unittest
from pathlib import Path

import support

support.skip_without("numpy", "meshio")
import gps_figures as figures  # noqa: E402
import numpy as np  # noqa: E402


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def volume(positions, faces):
    """Of flat polygons, by fans."""
    total = 0.0
    for face in faces:
        for k in range(1, len(face) - 1):
            a, b, c = (positions[v] for v in (face[0], face[k], face[k + 1]))
            total += sum(x * y for x, y in zip(a, cross(b, c))) / 6
    return total


class ControlMeshes(unittest.TestCase):
    def check_closed(self, positions, faces):
        """Every edge once in each direction, every vertex in use, outside outside."""
        edges = collections.Counter((f[k], f[(k + 1) % len(f)]) for f in faces for k in range(len(f)))
        for (a, b), count in edges.items():
            self.assertEqual(count, 1)
            self.assertEqual(edges[b, a], 1)
        self.assertEqual({v for f in faces for v in f}, set(range(len(positions))))
        self.assertEqual(len(positions) - len(edges) // 2 + len(faces), 2)
        self.assertGreater(volume(positions, faces), 0)

    def test_closed(self):
        for shape in (figures.cube, figures.jack, figures.axe):
            positions, faces = shape()
            self.check_closed(positions, faces)
            self.check_closed(positions, figures.triangulated(positions, faces))

    def test_helix_is_a_closed_tube(self):
        positions, faces, _ = figures.helix()
        self.check_closed(positions, faces)

    def test_volumes_are_known(self):
        self.assertAlmostEqual(volume(*figures.cube()), 8)
        # A cube of side 1.8 and six bars of it that are 3.1 long.
        self.assertAlmostEqual(volume(*figures.jack()), 1.8 ** 3 + 6 * 3.1 * 1.8 ** 2)

    def test_triangles_have_the_volume_of_flat_polygons(self):
        positions, faces = figures.jack()
        self.assertAlmostEqual(volume(positions, figures.triangulated(positions, faces)), volume(positions, faces))

    def test_quads_are_split_along_the_shorter_diagonal(self):
        positions = [(0, 0, 0), (3, 1, 0), (4, 4, 0), (1, 3, 0)]
        self.assertEqual(figures.triangulated(positions, [(0, 1, 2, 3)]), [(1, 2, 3), (1, 3, 0)])


class Page(unittest.TestCase):
    def test_tables_replace_what_is_between_their_marks(self):
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.md"
            page.write_text("before\n<!-- numbers 10 -->\nold\n<!-- end -->\nafter\n"
                            "<!-- numbers 7 -->\nkept\n<!-- end -->\n")
            numbers = {"figure 10": {"pointy": {"covariance": "1,1,1", "apex_y": 1.5, "area": 2.25}}}
            for _ in range(2):
                figures.update_page(page, numbers, "loop")
                lines = page.read_text().splitlines()
                self.assertEqual(lines[0:2], ["before", "<!-- numbers 10 -->"])
                self.assertEqual(lines[4:], ["| pointy | `1,1,1` | 1.500000 | 2.2500 |", "<!-- end -->", "after",
                                             "<!-- numbers 7 -->", "kept", "<!-- end -->"])


class Measures(unittest.TestCase):
    def test_equal_covariances_on_a_flat_mesh_measure_as_the_mesh(self):
        """A flat square stays flat; with sharp corners and equal covariances its boundary stays, too."""
        with tempfile.TemporaryDirectory() as folder:
            run = figures.Program(support.PROGRAM, Path(folder), "loop")
            run.control("square.obj", [(0, 0, 2), (3, 0, 2), (3, 3, 2), (0, 3, 2), (1.5, 1.5, 2)],
                        [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])
            run("infer", "square.obj", "square.ply")
            run.edited("square.ply", "equal.ply", "--set", 0.5)
            means, covariances = figures.read_gaussians(run.folder / "equal.ply")
            self.assertEqual(means.shape, (5, 3))
            self.assertTrue((covariances == 0.25 * np.eye(3)).all())
            surface = run.loop_surface("equal.ply", 3)
            self.assertEqual(surface.positions.shape[1], 3)
            self.assertTrue(abs(surface.positions[:, 2] - 2).max() < 1e-6)
            self.assertLess(surface.largest_turn(), 1e-3)
            # Cone from the origin over the flat piece.
            self.assertAlmostEqual(surface.volume(), surface.area() * 2 / 3, places=5)
            self.assertLess(surface.area(), 9)
            self.assertGreater(surface.area(), 0.6 * 9)

    def test_two_gaussians_follow_equation_5(self):
        a, b = (np.array((-1.0, 0, 0)), np.diag((1.0, 0.1, 1))), (np.array((1.0, 2, 0)), np.diag((0.2, 3, 1)))
        curve = figures.product_curve(a, b, 3)
        self.assertTrue(np.allclose(curve[[0, 2]], [a[0], b[0]]))
        # In the middle each coordinate is the mean weighted by the precisions.
        self.assertTrue(np.allclose(curve[1], [(-1 + 5) / 6, (2 / 3) / (10 + 1 / 3), 0]))
        self.assertTrue(math.isclose(curve[1, 2], 0, abs_tol=1e-15))


if __name__ == "__main__":
    unittest.main()
