"""The measurements of projections come out whole and plausible: clop_test.py PROGRAM

Exits with 77 (skipped) where projection_lab is not beside the program, or the script lacks a package.
"""

import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import support
from support import ROOT

LAB = support.PROGRAM.with_name("projection_lab")
if not LAB.exists():
    print(f"skipped: {LAB} is not built")
    sys.exit(support.SKIPPED)
support.skip_without("meshio", "matplotlib", "PIL")
import clop  # noqa: E402
import image_points  # noqa: E402

PICTURES = ["clop.svg", "clop-repulsion.svg", "clop-subsample.svg", "clop-density.png"]


def fnv1a(data):
    value = 0xCBF29CE484222325
    for byte in data:
        value = ((value ^ byte) * 0x100000001B3) % (1 << 64)
    return f"{value:016x}"


def numbers(cell):
    return [float(word.replace(",", "")) for word in re.findall(r"[-+]?\d[\d,]*\.?\d*", cell)]


class Whole(support.MeasuredPage):
    """A quick run on small scans."""

    script, page_path = "clop.py", "docs/evidence/projection.md"

    @classmethod
    def measure(cls, page, *arguments):
        return super().measure(page, "--lab", LAB, "--particles", "1000", *arguments)

    def rows(self, part, columns, count):
        """Of a table of the page, as lists of its cells."""
        (text,) = re.findall(f"<!-- {part} -->\n(.*?)<!-- end -->", self.page, re.S)
        (rows,) = support.tables_of(text)
        self.assertEqual({len(row) for row in rows}, {columns})
        self.assertEqual(len(rows), count)
        return rows

    def test_leaves_the_text_alone(self):
        self.assertEqual(support.without_sections(self.page), support.without_sections(self.before))
        self.assertNotEqual(self.page, self.before)
        self.assertEqual(len(re.findall("<!-- end -->", self.page)), len(clop.PARTS))

    def test_draws_what_the_page_shows(self):
        self.assertEqual(sorted(re.findall(r"\(pictures/([^)]*)\)", self.page)), sorted(PICTURES))
        for name in PICTURES:
            data = (self.path.parent / "pictures" / name).read_bytes()
            self.assertTrue(data.startswith(b"\x89PNG" if name.endswith("png") else b"<?xml"), name)
            self.assertTrue(2000 < len(data) < 150000, name)

    def test_accuracy(self):
        for scan, points, projected, discrete, ratio in self.rows("accuracy", 5, 3):
            mean, median, signed = numbers(points)
            self.assertTrue(0 < median < mean and abs(signed) < mean / 2, scan)
            self.assertAlmostEqual(numbers(projected)[0] / numbers(discrete)[0], float(ratio), delta=0.006)
            # Noise of 0.02, 0.1 and 0.25 % of the diagonal along the ray: times 0.8 the mean of its size, and shorter by
            # the cosine, or longer where views are out of register.
            noise = {"s1": 0.02, "s2": 0.1, "s3": 0.25}[scan[-2:]]
            self.assertTrue(0.4 * noise < mean < noise, scan)
            if not scan.endswith("s1"):  # where there is noise it goes
                self.assertLess(numbers(projected)[0], mean)

    def test_compression(self):
        rows = self.rows("compression", 6, 12)
        for k, (alpha, levels, share, error, irregularity, _) in enumerate(rows):
            self.assertEqual((alpha, levels), (str(1 + k // 4), str((1, 2, 3, 5)[k % 4])))
            self.assertTrue(0 < float(share) < 1 and 0 < float(error) < 1 and 0 < float(irregularity) < 0.5)
            if k % 4:
                self.assertLess(float(share), float(rows[k - 1][2]))

    def test_repulsion(self):
        for _, irregularity, error, attraction, repulsion in self.rows("repulsion", 5, 3):
            self.assertTrue(0 < float(irregularity) < 0.5 and 0 < float(error) < 1)
            self.assertTrue(float(attraction) > 0 and float(repulsion) >= 0)

    def test_coherence(self):
        rows = self.rows("coherence", 9, 4)
        self.assertEqual([row[0] for row in rows], ["1,000", "1,000", "300", "300"])
        for row in rows:
            for cell in row[2:8]:
                median, low, high = numbers(cell)
                self.assertTrue(0 < low <= median <= high, cell)
            self.assertLess(numbers(row[7])[0], 0.5 * numbers(row[2])[0])
        # Until the second iteration both do the same. After it, one repels as before and the other anew.
        for every, second in (rows[:2], rows[2:]):
            self.assertEqual(every[2], second[2])
            self.assertNotEqual(every[3], second[3])

    def test_upsampling(self):
        counts = [numbers(row[1])[0] for row in self.rows("upsampling", 4, 3)]
        self.assertAlmostEqual(counts[0] / counts[1], 0.2, places=3)
        self.assertAlmostEqual(counts[2] / counts[1], 5, places=3)

    def test_ripple(self):
        rows = self.rows("ripple", 5, 4)
        self.assertEqual([row[0] for row in rows], ["0.05 %", "0.1 %", "0.2 %", "0.4 %"])
        means = [numbers(row[2])[0] for row in rows]
        for less, more in zip(means, means[1:]):  # as the noise, less where it crosses the crests
            self.assertAlmostEqual(more / less, 2, delta=0.05)

    def test_speed(self):
        clop_row, wlop_row, ratio = self.rows("speed", 7, 3)
        # Of times with one digit.
        for k in (2, 4):
            quotient, ours, theirs = float(ratio[k]), float(clop_row[k]), float(wlop_row[k])
            self.assertGreaterEqual(quotient + 0.05, (theirs - 0.05) / (ours + 0.05))
            if ours > 0.05:
                self.assertLessEqual(quotient - 0.05, (theirs + 0.05) / (ours - 0.05))

    def test_subsample(self):
        rows = self.rows("subsample", 6, 10)
        for k, (scan, particles, share, mixture, same, wide) in enumerate(rows):
            self.assertEqual((scan, share), ("koala.s2", ("100 %", "50 %", "25 %", "10 %", "5 %")[k % 5]))
            self.assertEqual(numbers(particles)[0] > 1000, k >= 5)
            self.assertEqual(bool(mixture and wide), k % 5 > 0)
            self.assertTrue(0 < numbers(same)[0] < 1)
            if mixture:
                self.assertLess(numbers(mixture)[1], numbers(same)[1])
                # The fewer points attract, the more particles gather at each.
                self.assertLess(1.1 * numbers(rows[k - 1][4])[1], numbers(same)[1])

    def test_density(self):
        rows = self.rows("density", 7, 16)
        for title, start in (("portrait", 0), ("gradient", 8)):
            picture, unprojected, *projected = rows[start:start + 8]
            self.assertEqual({row[0] for row in rows[start:start + 8]}, {title})
            self.assertEqual([row[1] for row in projected[:2]], ["LOP", "WLOP"])
            self.assertEqual(numbers(picture[4]), [1])
            self.assertGreater(numbers(picture[3])[0], 3)
            # A random subset is like the picture, an even one is not.
            random, even = numbers(unprojected[4])
            self.assertGreater(random, even + 0.4)
            # From either start, particles keep less of the picture where the weights are balanced.
            for off, on in zip(projected[::2], projected[1::2]):
                for plain, balanced in zip(numbers(off[3]), numbers(on[3])):
                    self.assertLess(balanced, plain, (off, on))

    def test_names_what_it_cannot_do(self):
        page = self.path.with_name("other.md")
        page.write_text("<!-- repulsion -->\n<!-- end -->\n")
        self.assertEqual(self.measure(page, "--parts", "repulsion").returncode, 0)
        self.assertIn("| in every second |", page.read_text())
        for parts, code, message in (("repulsion,nonsense", 2, "unknown parts: nonsense"),
                                     ("compression", 3, "other.md: has no place for compression")):
            result = self.measure(page, "--parts", parts)
            self.assertEqual(result.returncode, code)
            self.assertIn(message, result.stderr)


class Likeness(unittest.TestCase):
    def test_of_a_picture_to_itself_and_to_its_negative(self):
        darkness = clop.darkness_of(image_points.gradient)
        contrast, correlation, unevenness = clop.likeness(darkness, darkness)
        # The means of a linear function over the outer quarters of [0.04, 0.96], 0.115 from its ends.
        at = lambda x: image_points.LIGHTEST + (1 - image_points.LIGHTEST) * x
        self.assertAlmostEqual(contrast, at(0.96 - 0.115) / at(0.04 + 0.115))
        self.assertAlmostEqual(correlation, 1)
        self.assertAlmostEqual(clop.likeness([1 - d for d in darkness], darkness)[1], -1)
        # Twelve columns spread like numbers from 1 to 12, √((12² - 1)/12), a step being 0.92/12 wide.
        self.assertAlmostEqual(unevenness, (143 / 12) ** 0.5 * (at(1) - at(0)) * 0.92 / 12 / at(0.5))

    def test_cells(self):
        middle_of_the_first = 0.04 + 0.92 / 24
        counts = clop.cells_of([(middle_of_the_first, middle_of_the_first), (0.95, middle_of_the_first),
                                (0.95, 0.95), (0.95, 0.95), (0.03, 0.5), (0.5, 0.97), (-0.2, 0.5)])
        self.assertEqual((counts[0], counts[11], counts[-1], sum(counts)), (1, 1, 2, 4))


class ImagePoints(unittest.TestCase):
    def test_are_those_that_are_described(self):
        described = re.findall(r"^\| (\w+) \| ([\d,]+) \| (\d+) \| `(\w+)` \|", (ROOT / "datasets/README.md").read_text(), re.M)
        self.assertEqual([row[0] for row in described], list(image_points.PICTURES))
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "points.xyz"
            for picture, count, seed, expected in described:
                count = count.replace(",", "")
                subprocess.run([sys.executable, ROOT / "datasets/image_points.py", picture, out, "--points", count,
                                "--seed", seed], check=True)
                self.assertEqual(fnv1a(out.read_bytes()), expected)
                self.assertEqual(out.read_text().count("\n"), int(count))

    def test_are_as_dense_as_the_picture_is_dark(self):
        for picture in image_points.PICTURES.values():
            counts = clop.cells_of(image_points.points_of(picture, 40000, 7))
            darkness = clop.darkness_of(picture)
            scale = sum(counts) / sum(darkness)
            chi_squared = sum((c - scale * d) ** 2 / (scale * d) for c, d in zip(counts, darkness))
            # 143 degrees of freedom: five standard deviations. The mean of a cell from 64 places is off by less.
            self.assertLess(chi_squared, 143 + 5 * (2 * 143) ** 0.5)
            self.assertTrue(all(image_points.LIGHTEST <= d <= 1 for d in darkness))


if __name__ == "__main__":
    unittest.main()
