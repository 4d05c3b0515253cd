"""What the tests of scripts share. Each is called as NAME_test.py PROGRAM, with gpsrecon."""

import importlib.util
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = Path(sys.argv.pop(1)).resolve()
sys.path.insert(0, str(ROOT / "scripts"))
SKIPPED = 77


def skip_without(*modules):
    """Ends the test as skipped where a Python module is missing."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: {sys.executable} has no {', '.join(missing)}")
        sys.exit(SKIPPED)


def run_script(name, *arguments, **settings):
    """Runs a script with the Python of the test."""
    command = [sys.executable, ROOT / "scripts" / name, *arguments]
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, **settings)


def make_small_scans(folder):
    """A folder of data in little: three scans of a torus that go by the name of the koala, and the truth."""
    (folder / "scans").mkdir()
    (folder / "truth").mkdir()
    for grade in ("s1", "s2", "s3"):
        subprocess.run([PROGRAM, "scan", "shape:torus", folder / f"scans/koala.{grade}.ply", "--quality", grade,
                        "--points", "3000", "--truth", folder / "truth/koala.ply", "--quiet"], check=True)


def tables_of(text):
    """The tables in Markdown, as lists of rows of cells, without their heads."""
    tables = [[[cell.strip() for cell in line.strip("|").split("|")] for line in lines.splitlines()]
              for lines in re.findall(r"(?:^\|.*\n)+", text, re.M)]
    for rows in tables:
        assert len({len(row) for row in rows}) == 1, rows
    return [rows[2:] for rows in tables]


def without_sections(page):
    """A page without what scripts write into it."""
    return re.sub("^(<!-- [^\n]* -->\n).*?^(<!-- end -->)$", r"\1\2", page, flags=re.S | re.M)


class MeasuredPage(unittest.TestCase):
    """A copy of the page ROOT/`page_path`, into which `script` has written what it measured on small scans."""

    script, page_path = None, None

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.data = Path(folder.name)
        make_small_scans(cls.data)
        cls.before = (ROOT / cls.page_path).read_text()
        cls.path = cls.data / "page.md"
        cls.path.write_text(cls.before)
        result = cls.measure(cls.path)
        assert result.returncode == 0, result.stderr
        cls.page = cls.path.read_text()

    @classmethod
    def measure(cls, page, *arguments):
        return run_script(cls.script, "--program", PROGRAM, "--data", cls.data, "--quick", "--page", page, *arguments)
