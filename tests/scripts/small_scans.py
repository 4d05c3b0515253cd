"""A folder of data in little: three scans of a torus that go by the name of the koala, and the truth."""

import subprocess


def make(program, folder):
    (folder / "scans").mkdir()
    (folder / "truth").mkdir()
    for grade in ("s1", "s2", "s3"):
        subprocess.run([program, "scan", "shape:torus", folder / f"scans/koala.{grade}.ply", "--quality", grade, "--points",
                        "3000", "--truth", folder / "truth/koala.ply", "--quiet"], check=True)
