"""Virtual scans with their truth: of analytic shapes, made by `gpsrecon scan`, and of the meshes in a folder of data,
which holds scans/NAME.sN.ply with truth/NAME.ply."""

import os
from pathlib import Path

SEED = 1
# Small curvature radii would make more triangles than the figures need.
TRUTH_TOLERANCE = {"gyroid": "0.01%", "knot": "0.005%"}


class Scan:
    """A scan NAME.GRADE of the folder `data`, or of the shape NAME with `size` points, which is made when needed."""

    def __init__(self, name, size=None, data=None):
        self.name, self.size = name, size
        self.shape, self.grade = name.rsplit(".", 1)
        self.points = data and data / "scans" / f"{name}.ply"
        self.truth = data and data / "truth" / f"{self.shape}.ply"

    def make(self, gpsrecon, work):
        """Makes points and truth in the folder `work`, once."""
        if self.points is not None:
            return
        self.points, self.truth = work / f"{self.name}.points.ply", work / f"{self.name}.truth.ply"
        gpsrecon.run("scan", f"shape:{self.shape}", self.points, "--quality", self.grade, "--points", self.size,
                     "--truth", self.truth, "--truth-tolerance", TRUTH_TOLERANCE.get(self.shape, "0.002%"),
                     "--seed", SEED)


def scans_in(data, kind=Scan):
    """The scans of a folder of data whose truth is there, by name; none where `data` is None."""
    scans = [kind(path.stem, None, data) for path in sorted(data.glob("scans/*.s[0-9].ply"))] if data else []
    return [scan for scan in scans if scan.truth.exists()]


def add_data_option(parser):
    folder = os.environ.get("GPSRECON_DATA_DIR")
    parser.add_argument("--data", type=Path, default=Path(folder) if folder else None,
                        help="folder with scans/ and truth/ (default: GPSRECON_DATA_DIR, else none)")
