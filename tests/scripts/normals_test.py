"""The measurements of normals come out whole and plausible: normals_test.py PROGRAM

Exits with 77 (skipped) where the script lacks a package.
"""

import re
import unittest

import support


def numbers(cell):
    return [float(word) for word in re.findall(r"\d+\.?\d*", cell)]


class Whole(support.MeasuredPage):
    """A quick run on small scans."""

    script, page_path = "normals.py", "docs/evidence/normals.md"

    def tables(self, section):
        """The text of a section of the page, and the tables in it."""
        (text,) = re.findall(f"<!-- {section}: measured by scripts/normals.py -->\n(.*?)<!-- end -->", self.page, re.S)
        return text, support.tables_of(text)

    def test_leaves_the_text_alone(self):
        self.assertEqual(support.without_sections(self.page), support.without_sections(self.before))
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
        result = self.measure(page)
        self.assertEqual(result.returncode, 3)
        self.assertIn("other.md: has no place for creases", result.stderr)


if __name__ == "__main__":
    support.skip_without("meshio", "matplotlib", "scipy")
    unittest.main()
