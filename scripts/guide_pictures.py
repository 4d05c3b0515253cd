#!/usr/bin/python3
"""Draws the pictures of the guide, docs/guide/pictures, with the commands that the guide shows.

    scripts/guide_pictures.py [--program FILE] [--out FOLDER] [--only stages,open,...]

All data are virtual scans, made by the program itself. Packages (scripts/install_packages.sh develop): python3-vtk9 xvfb
xauth. Without a display it starts one of its own.

Exit codes: 0 done, 2 usage, 3 a program failed.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from lab.runner import GPSRECON, ROOT, Gpsrecon, exit_code_of
from lab.scenes import BLUE, RED, Panel, draw, in_display, read, shaded

EXAMPLE = ROOT / "datasets/manifest.json"


def points_panel(run, points, direction, size, caption=""):
    """Points, shaded by their normals, in `size` pixels."""
    run("normals", points, "lit.ply", "--method", "pca")
    return Panel(caption).add(shaded(read(run.folder / "lit.ply"), direction), colored=True, size=size)


def stages(run, out):
    """From the points of the example to its surface."""
    example = next(d for d in json.loads(EXAMPLE.read_text())["datasets"] if d["file"] == "example.ply")
    run("scan", example["surface"], "scan.ply", *example["options"].split(), "--seed", example["seed"],
        "--truth", "truth.ply")
    run("scan.ply", "surface.ply")
    run("compare", "surface.ply", "truth.ply", "--heatmap", "errors.ply")
    run("mixture", "scan.ply", "m.ply", "--ellipsoids", "ellipsoids.ply", "--ellipsoid-scale", 1.5)
    run("triangulate", "m.ply", "t.ply")
    surface = read(run.folder / "surface.ply")
    view = {"direction": (0.9, -1, 0.55), "up": (0, 0, 1), "box": surface.GetBounds(), "size": (560, 480), "zoom": 1.4}
    draw(out / "stage-points.png", [points_panel(run, "scan.ply", view["direction"], 1.2)], **view)
    draw(out / "stage-mixture.png", [Panel().add(read(run.folder / "ellipsoids.ply"), BLUE)], **view)
    draw(out / "stage-covmesh.png", [Panel().add(read(run.folder / "t.ply"), flat=True, edges=True)], **view)
    draw(out / "stage-surface.png", [Panel().add(surface)], **view)
    draw(out / "stage-error.png", [Panel().add(read(run.folder / "errors.ply"), colored=True)], **view)


def open_surface(run, out):
    """An open vase, seen from above: its back faces are red."""
    direction = 1, -0.4, 0.75
    run("scan", "shape:vase", "vase.ply", "--quality", "s2", "--sensors")
    run("vase.ply", "surface.ply")
    surface = read(run.folder / "surface.ply")
    draw(out / "open.png",
         [points_panel(run, "vase.ply", direction, 1, "points"),
          Panel("surface, back faces red, rim blue").add(surface, back=RED).add_boundary(surface, BLUE)],
         direction, (0, 0, 1), surface.GetBounds(), (420, 420), 0.95)


def noisy(run, out):
    """A scan with noise, bias, registration errors and outliers, and its surface."""
    direction = 0.1, -0.2, 1
    run("scan", "shape:knot", "noisy.ply", "--quality", "s3", "--points", 50000)
    run("noisy.ply", "surface.ply")
    surface = read(run.folder / "surface.ply")
    draw(out / "noisy.png", [points_panel(run, "noisy.ply", direction, 2, "points"), Panel("surface").add(surface)],
         direction, (0, 1, 0), surface.GetBounds(), (420, 400), 0.95)


def sparse(run, out):
    """Few points: the default kernel, and one by the spacing."""
    direction = 1, -0.75, 0.8
    run("scan", "shape:block", "sparse.ply", "--points", 3000, "--noise", "0.1%")
    run("sparse.ply", "default.ply")
    run("sparse.ply", "narrow.ply", "--sigma0", "0.35sp")
    surface = read(run.folder / "narrow.ply")
    draw(out / "sparse.png",
         [points_panel(run, "sparse.ply", direction, 4, "3,000 points"),
          Panel("default kernel").add(read(run.folder / "default.ply")), Panel("kernel of 0.35 spacings").add(surface)],
         direction, (0, 0, 1), surface.GetBounds(), (330, 300), 0.95)


def thin(run, out):
    """Fins from thick to thin; boundary loops are red."""
    direction = 0.6, 1, 0.6
    run("scan", "shape:fins", "fins.ply", "--quality", "s1", "--points", 100000)
    run("fins.ply", "surface.ply")
    surface = read(run.folder / "surface.ply")
    draw(out / "thin.png",
         [points_panel(run, "fins.ply", direction, 1, "points"),
          Panel("surface, boundary loops red").add(surface).add_boundary(surface)],
         direction, (0, 0, 1), surface.GetBounds(), (460, 380), 0.95)


PICTURES = {"stages": stages, "open": open_surface, "noisy": noisy, "sparse": sparse, "thin": thin}


class Program(Gpsrecon):
    """Tells the commands it runs."""

    def __call__(self, *words):
        print("    gpsrecon " + " ".join(map(str, words)), flush=True)
        self.run(*words)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=GPSRECON, help="gpsrecon to use")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/guide/pictures", help="folder for the pictures")
    parser.add_argument("--only", default=",".join(PICTURES), help="names of pictures, separated by commas")
    arguments = parser.parse_args()
    wanted = arguments.only.split(",")
    if not set(wanted) <= set(PICTURES):
        parser.error(f"--only: expected names among {', '.join(PICTURES)}, got '{arguments.only}'")
    if not arguments.program.is_file():
        parser.error(f"--program: there is no {arguments.program}; build it, or name another")
    in_display()

    arguments.out.mkdir(parents=True, exist_ok=True)
    for name in wanted:
        print(f"{name}: {PICTURES[name].__doc__.splitlines()[0]}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            PICTURES[name](Program(arguments.program.resolve(), folder=Path(folder)), arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(exit_code_of(main))
