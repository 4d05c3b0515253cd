"""The package that the scripts share: lab_test.py PROGRAM"""

import contextlib
import io
import struct
import sys
import tempfile
import unittest
from pathlib import Path

import support

from lab import pages, runner, scans


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)


class Measured(unittest.TestCase):
    def test_measures_the_child_and_its_children(self):
        work = "x = bytearray(60 << 20)\nfor i in range(3_000_000): pass"
        cost = runner.run_measured(["sh", "-c", f"{sys.executable} -c '{work}'; true"], 60)
        self.assertGreater(cost["memory_MB"], 60)
        self.assertLess(cost["memory_MB"], 120)
        self.assertGreater(cost["cpu_s"], 0.02)

    def test_peak_memory_is_not_that_of_the_benchmark(self):
        ballast = bytearray(b"x" * (100 << 20))
        self.assertLess(runner.run_measured(["true"], 60)["memory_MB"], 30)
        del ballast

    def test_stops_what_takes_too_long_or_too_much(self):
        with self.assertRaisesRegex(runner.RunFailed, "stopped after 0.3 s"):
            runner.run_measured(["sleep", "20"], 0.3)
        with self.assertRaisesRegex(runner.RunFailed, "MemoryError"):
            runner.run_measured([sys.executable, "-c", "bytearray(2 << 30)"], 60, 1 << 30)
        with self.assertRaisesRegex(runner.RunFailed, "exit code 127: .*nowhere"):
            runner.run_measured(["/nowhere"], 60)
        with self.assertRaisesRegex(runner.RunFailed, "signal 15"):
            runner.run_measured(["sh", "-c", "kill -15 $$"], 60)


class Programs(InFolder):
    def test_returns_what_is_printed_in_the_folder(self):
        self.assertEqual(runner.output_of(["pwd", "-P"], self.folder), f"{self.folder.resolve()}\n")

    def test_a_failure_has_its_code_and_its_message(self):
        with self.assertRaisesRegex(runner.ProgramFailed, "^sh -c .*: exit code 3: it is too steep$") as raised:
            runner.output_of(["sh", "-c", "echo it is too steep >&2; exit 3"])
        self.assertEqual(raised.exception.code, 3)

    def test_gpsrecon_is_quiet_and_knows_its_threads(self):
        program = runner.Gpsrecon(support.PROGRAM, 1, self.folder)
        self.assertEqual(program.command("info"), [support.PROGRAM, "info", "--quiet", "--threads", 1])
        self.assertEqual(program.run("scan", "shape:sphere", "scan.ply", "--points", 100), "")
        self.assertTrue((self.folder / "scan.ply").exists())
        self.assertRegex(program.version(), r"^gpsrecon \d+\.\d+")

    def test_a_script_that_cannot_go_on_says_so_in_a_line(self):
        def fail(error):
            raise error

        for error in (runner.Failure("why"), runner.RunFailed("why"), OSError("why")):
            errors = io.StringIO()
            with contextlib.redirect_stderr(errors):
                self.assertEqual(runner.exit_code_of(lambda: fail(error)), 3)
            self.assertEqual(errors.getvalue(), "lab_test.py: why\n")
        self.assertEqual(runner.exit_code_of(lambda: 1), 1)
        with self.assertRaises(ZeroDivisionError):
            runner.exit_code_of(lambda: fail(ZeroDivisionError()))


class Scans(InFolder):
    def test_those_of_a_folder_have_their_truth(self):
        for path in ("scans/b.s2.ply", "scans/a.s3.ply", "scans/lost.s1.ply", "scans/a.ply", "truth/a.ply", "truth/b.ply"):
            (self.folder / path).parent.mkdir(exist_ok=True)
            (self.folder / path).touch()
        found = scans.scans_in(self.folder)
        self.assertEqual([(s.name, s.shape, s.grade) for s in found], [("a.s3", "a", "s3"), ("b.s2", "b", "s2")])
        self.assertEqual(found[0].points, self.folder / "scans/a.s3.ply")
        self.assertEqual(found[0].truth, self.folder / "truth/a.ply")
        self.assertEqual(scans.scans_in(None), [])

    def test_those_of_shapes_are_made_once(self):
        program = runner.Gpsrecon(support.PROGRAM)
        scan = scans.Scan("sphere.s3", 200)
        scan.make(program, self.folder)
        self.assertIn(b"element vertex 200\n", scan.points.read_bytes())
        self.assertIn(b"element face", scan.truth.read_bytes())
        scan.make(None, self.folder)


class Pages(InFolder):
    TEXT = "before\n<!-- a -->\nold\n<!-- end -->\nbetween <!-- b -->\n<!-- b: 1.5 (x) -->\n<!-- end -->\nafter"

    def setUp(self):
        super().setUp()
        self.path = self.folder / "page.md"
        self.path.write_text(self.TEXT)

    def test_table(self):
        self.assertEqual(pages.table(["a", ""], [["1", "2"], ["3", "|"]]), "| a |  |\n|---|---|\n| 1 | 2 |\n| 3 | | |\n")
        self.assertEqual(support.tables_of("x\n" + pages.table(["a"], [["1"], ["2"]]) + "\ny"), [[["1"], ["2"]]])

    def test_sections_come_back_and_replacing_them_again_changes_nothing(self):
        new = {"a": "\\1 $& α\n", "b: 1.5 (x)": pages.table(["h"], [["<!-- a -->"]])}
        pages.replace_sections(self.path, new)
        once = self.path.read_text()
        for name, text in new.items():
            self.assertEqual(pages.section(once, name), text)
        self.assertEqual(once, self.TEXT.replace("old\n", new["a"]).replace("(x) -->\n", "(x) -->\n" + new["b: 1.5 (x)"]))
        pages.replace_sections(self.path, new)
        self.assertEqual(self.path.read_text(), once)
        pages.replace_sections(self.path, {"a": "old\n", "b: 1.5 (x)": ""})
        self.assertEqual(self.path.read_text(), self.TEXT)

    def test_writes_nothing_where_one_has_no_place(self):
        self.assertIsNone(pages.section(self.TEXT, "b"))  # not on a line of its own
        with self.assertRaisesRegex(runner.Failure, "page.md: has no place for b$"):
            pages.replace_sections(self.path, {"a": "new\n", "b": "new\n"})
        self.assertEqual(self.path.read_text(), self.TEXT)
        self.path.write_text(2 * (self.TEXT + "\n"))
        with self.assertRaisesRegex(runner.Failure, "several places for a"):
            pages.replace_sections(self.path, {"a": "new\n"})


class PlyFiles(InFolder):
    VERTICES = [(1.5, -2.25, 1 / 3, 7), (0.1, 1e-12, -3e8, 127), (0, 0, 1, 0), (4, 5, 6, 1), (1, 2, 3, 4)]

    def write(self, name, text, faces):
        """Doubles with a byte beside them, and polygons."""
        header = (f"ply\nformat {'ascii' if text else 'binary_little_endian'} 1.0\ncomment of a test\n"
                  f"element vertex {len(self.VERTICES)}\nproperty double x\nproperty double y\nproperty double z\n"
                  f"property uchar kind\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        if text:
            rows = [" ".join(map(repr, v)) for v in self.VERTICES] + [" ".join(map(str, (len(f), *f))) for f in faces]
            body = "".join(row + "\n" for row in rows).encode()
        else:
            body = b"".join([struct.pack("<3dB", *v) for v in self.VERTICES] +
                            [struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces])
        (self.folder / name).write_bytes(header.encode() + body)
        return ply.Ply(self.folder / name)

    def test_text_and_binary_hold_what_was_written(self):
        for text in (True, False):
            mesh = self.write("mesh.ply", text, [(0, 1, 2), (2, 1, 3), (4, 0, 1)])
            self.assertEqual(len(mesh), 5)
            self.assertEqual(mesh.positions.tolist(), [list(map(float, v[:3])) for v in self.VERTICES])
            self.assertEqual(mesh.vectors("kind").ravel().tolist(), [7, 127, 0, 1, 4])
            self.assertEqual(mesh.faces().tolist(), [[0, 1, 2], [2, 1, 3], [4, 0, 1]])
            self.assertTrue(mesh.has("kind") and not mesh.has("nx"))

    def test_polygons_of_several_sizes(self):
        for text in (True, False):
            mesh = self.write("mesh.ply", text, [(0, 1, 2, 3), (2, 1, 3), (4, 0, 1), (0, 1, 2, 3, 4)])
            self.assertEqual([face.tolist() for block in mesh.blocks for face in block],
                             [[0, 1, 2, 3], [2, 1, 3], [4, 0, 1], [0, 1, 2, 3, 4]])
            with self.assertRaisesRegex(ValueError, "faces of one size"):
                mesh.faces()

    def test_what_gpsrecon_writes_is_the_same_in_text_and_binary(self):
        program = runner.Gpsrecon(support.PROGRAM, folder=self.folder)
        for name, options in (("binary", []), ("text", ["--ascii"])):
            program.run("scan", "shape:torus", f"{name}.ply", "--points", 500, "--normals", "surface", *options)
            program.run("mixture", "binary.ply", f"{name}.mixture.ply", *options)
        self.assertIn(b"format ascii", (self.folder / "text.mixture.ply").read_bytes())
        binary, text = (ply.Ply(self.folder / f"{name}.ply") for name in ("binary", "text"))
        self.assertEqual(binary.positions.tolist(), text.positions.tolist())
        self.assertEqual(binary.normals().tolist(), text.normals().tolist())
        self.assertAlmostEqual(float((binary.normals() ** 2).sum()), 500, places=3)
        binary, text = (ply.Ply(self.folder / f"{name}.mixture.ply").covariances() for name in ("binary", "text"))
        self.assertEqual(binary.tolist(), text.tolist())
        self.assertEqual(binary.tolist(), binary.transpose(0, 2, 1).tolist())


if __name__ == "__main__":
    support.skip_without("meshio")
    from lab import ply
    unittest.main()
