"""The measurements of normals come out whole and plausible: normals_test.py PROGRAM

Exits with 77 (skipped) where the system's Python lacks what the script needs.
"""

import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import small_scans

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = Path(sys.argv.pop(1)).resolve()
SKIPPED = 77
PYTHON = "/usr/bin/python3"


def numbers(cell):
    return [float(word) for word in re.findall(r"\d+\.?\d*", cell)]


class Whole(unittest.TestCase):
    """A quick run on small scans."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        base = Path(cls.folder.name)
        small_scans.make(PROGRAM, base)
        cls.before = (ROOT / "docs/evidence/normals.md").read_text()
        cls.path = base / "normals.md"
        cls.path.write_text(cls.before)
        result = cls.run_script(cls.path, "--data", base)
        assert result.returncode == 0, result.stderr
        cls.page = cls.path.read_text()

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def run_script(cls, page, *arguments):
        command = [PYTHON, ROOT / "scripts/normals.py", "--program", PROGRAM, "--quick", "--page", page, *arguments]
        return subprocess.run(list(map(str, command)), capture_output=True, text=True)

    def tables(self, section):
        """Of a section of the page, as lists of rows of cells without their heads."""
        (text,) = re.findall(f"<!-- {section}: measured by scripts/normals.py -->\n(.*?)<!-- end -->", self.page, re.S)
        found = []
        for lines in re.findall(r"(?:^\|.*\n)+", text, re.M):
            rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines.splitlines()]
            self.assertEqual(len({len(row) for row in rows}), 1)
            found.append(rows[2:])
        return text, found

    def test_leaves_the_text_alone(self):
        between = lambda page: re.sub("(<!-- [a-z]+: .*? -->\n).*?(<!-- end -->)", r"\1\2", page, flags=re.S)
        self.assertEqual(between(self.page), between(self.before))
        self.assertNotEqual(self.page, self.before)

    def test_draws_what_the_page_shows(self):
        names = re.findall(r"\(pictures/([^)]*)\)", self.page)
        self.assertEqual(sorted(names), ["normals-block.png", "normals-error.png"])
        for name in names:
            data = (self.path.parent / "pictures" / name).read_bytes()
            self.assertTrue(data.startswith(b"\x89PNG") and len(data) > 5000, name)

    def test_creases(self):
        text, (methods, compressions) = self.tables("creases")
        self.assertIn("`shape:block`, 10,000 points", text)
        self.assertEqual([row[0].split(",")[0] for row in methods],
                         ["planes (12 points)", "planes (30 points)", "medians", "medians", "CSW", "CSW"])
        for name, mean, median, most, share, _ in methods:
            mean, median, most, share = (numbers(cell)[0] for cell in (mean, median, most, share))
            # Most points are on planes, and the rest is within the right angle between these.
            self.assertTrue(0 < median < mean < most < 90, name)
            self.assertLess(median, 5, name)
            self.assertTrue(most > 10 if share > 5 else most < 10, name)
        self.assertEqual([row[0] for row in compressions], ["1", "1.5", "2", "2.5", "3"])
        shares = [numbers(row[1])[0] for row in compressions]
        self.assertEqual(shares, sorted(set(shares), reverse=True))
        self.assertTrue(0 < shares[-1] and shares[0] < 100)

    def test_scans(self):
        text, (rows,) = self.tables("scans")
        self.assertEqual([row[0] for row in rows], ["koala s1", "koala s2", "koala s3"])
        for row in rows:
            for cell in row[1:4]:
                mean, median, most = numbers(cell)
                self.assertTrue(0 < median < most and 0 < mean < most < 90, row)
            self.assertLess(numbers(row[4])[0], 2, row)
        for method in (1, 2, 3):  # twelve times the noise, worse normals
            self.assertLess(numbers(rows[0][method])[0], numbers(rows[2][method])[0])
        self.assertRegex(text, r"pca \d+\.\d\d, weiszfeld \d+\.\d\d, csw \d+\.\d\d")

    def test_names_what_it_cannot_do(self):
        page = self.path.with_name("other.md")
        page.write_text("nothing here\n")
        result = self.run_script(page)
        self.assertEqual(result.returncode, 1)
        self.assertIn("other.md: has no place for creases", result.stderr)


if __name__ == "__main__":
    if subprocess.run([PYTHON, "-c", "import numpy, matplotlib, scipy"], capture_output=True).returncode != 0:
        print(f"skipped: {PYTHON} has no NumPy, SciPy or matplotlib")
        sys.exit(SKIPPED)
    unittest.main()
