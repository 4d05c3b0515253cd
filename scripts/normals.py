#!/usr/bin/python3
"""Measures the normals that `gpsrecon normals` estimates, and writes the figures into docs/evidence/normals.md.

    scripts/normals.py [--program build/release/bin/gpsrecon] [--data DIR] [--page docs/evidence/normals.md] [--quick]

A shape with creases is scanned virtually, with and without errors, and its normals are compared with the exact ones:
those of planes, of spherical medians, and of continuous medians for two kernel sizes and several compressions of the
mixture. With --data, a folder that holds scans/NAME.sN.ply and truth/NAME.ply, also those of virtual scans of meshes.
With --quick few points and one mesh are measured, to see that it works: give it a page of its own. Needs meshio,
matplotlib and, for --data, scipy.

Exit codes: 0 done, 2 usage, 3 a program failed, or the page has no place for a section.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from lab.pages import replace_sections, table
from lab.pictures import pyplot, save
from lab.ply import Ply
from lab.runner import GPSRECON, ROOT, Gpsrecon, exit_code_of, run_measured

PAGE = ROOT / "docs/evidence/normals.md"
NAMES = ["nefertiti", "koala", "hammer", "spot"]
KERNELS = (0.011, 0.022)  # of the diagonal, those of the paper's Figure 16
JUDGED = 30000  # points of a scan of a mesh that are compared


def degrees_between(a, b):
    """Between axes."""
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.abs((a * b).sum(1))))


class Runner:
    """Runs gpsrecon with files in `folder`."""

    def __init__(self, program, folder):
        self.gpsrecon, self.folder = Gpsrecon(program), folder

    def scan(self, name, *options):
        path = self.folder / f"{name}.ply"
        self.gpsrecon.run("scan", f"shape:{name}", path, *options)
        return path

    def normals(self, points, *options):
        """And the CPU seconds that they took."""
        out = self.folder / "out.ply"
        taken = run_measured(self.gpsrecon.command("normals", points, out, *options))
        return Ply(out).normals(), taken["cpu_s"]

    def compression(self, points, *options):
        """Gaussians per point."""
        out = self.folder / "mixture.ply"
        self.gpsrecon.run("mixture", points, out, *options)
        return len(Ply(out)) / len(Ply(points))


def figures(errors):
    return [f"{errors.mean():.2f}°", f"{np.median(errors):.2f}°", f"{np.percentile(errors, 95):.1f}°",
            f"{100 * (errors > 10).mean():.1f} %"]


def draw_block(panels, positions, truth, path):
    """A corner of the block seen from above, coloured by the errors of the normals."""
    view = np.array([0.35, 0.45, 0.82])
    view /= np.linalg.norm(view)
    right = np.cross([0, 0, 1], view)
    right /= np.linalg.norm(right)
    up = np.cross(view, right)
    front = np.nonzero(truth @ view > 0)[0]
    front = front[np.argsort(positions[front] @ view)]
    figure, axes = pyplot().subplots(1, len(panels), figsize=(4.2 * len(panels), 3.4), layout="constrained")
    for axis, (title, errors) in zip(axes, panels):
        dots = axis.scatter(positions[front] @ right, positions[front] @ up, s=6, linewidths=0, c=errors[front],
                            cmap="inferno_r", vmin=0, vmax=20)
        axis.set(title=title, aspect="equal", xlim=(-1.3, 1.3), ylim=(-0.6, 1.4))
        axis.axis("off")
    figure.colorbar(dots, ax=axes, label="error, degrees", shrink=0.8)
    save(figure, path, dpi=75)


def draw_curves(curves, compressions, path):
    figure, (left, right) = pyplot().subplots(1, 2, figsize=(11, 3.8))
    for label, errors in curves:
        left.plot(np.sort(errors), 100 - 100 * np.arange(len(errors)) / len(errors), label=label)
    left.set(xscale="log", yscale="log", xlim=(0.1, 90), ylim=(0.1, 100), xlabel="error of the normal, degrees",
             ylabel="points with a larger one, %")
    left.legend()
    for label, shares, means in compressions:
        right.plot(100 * np.array(shares), means, "o-", label=label)
    right.set(xscale="log", xlabel="Gaussians, % of the points", ylabel="mean error, degrees", ylim=(0, None))
    right.legend()
    figure.tight_layout()
    save(figure, path, dpi=80)


def measure_block(runner, count, pictures):
    points = runner.scan("block", "--points", count, "--noise", "0.02%", "--normals", "surface")
    scan = Ply(points)
    positions, truth = scan.positions, scan.normals()
    text = (f"A virtual scan of `shape:block`, {count:,} points, noise 0.02 % of the diagonal. The exact normals are known. "
            "The kernels are those of the paper's Figure 16, 1.1 % and 2.2 % of the diagonal.\n\n")
    rows, curves, panels = [], [], []
    cases = [("planes (12 points)", "pca", ["--neighbors", 12]), ("planes (30 points)", "pca", ["--neighbors", 30])]
    for h in KERNELS:
        cases.append((f"medians, h = {100 * h:.1f} %", "weiszfeld", ["--support-radius", f"{100 * h:g}%"]))
    for h in KERNELS:
        cases.append((f"CSW, h = {100 * h:.1f} %", "csw", ["--support-radius", f"{100 * h:g}%"]))
    for label, method, options in cases:
        normals, seconds = runner.normals(points, "--method", method, *options, "--orient", "mst")
        errors = degrees_between(normals, truth)
        rows.append([label] + figures(errors) + [f"{seconds:.1f} s"])
        curves.append((label, errors))
        if label.endswith("(30 points)") or method == "csw":
            panels.append((label, errors))
    text += table(["normals", "mean", "median", "95 %", "above 10°", "CPU"], rows) + "\n"
    text += "![A corner of the block, coloured by the errors](pictures/normals-block.png)\n\n"
    draw_block(panels, positions, truth, pictures / "normals-block.png")

    text += ("Compression costs accuracy on the whole, though on the planes larger Gaussians average more noise away. "
             "Without flat levels, for several bounds α of the divergence of Gaussians that merge, up to five levels:\n\n")
    rows, compressions = [], [(f"h = {100 * h:.1f} %", [], []) for h in KERNELS]
    for alpha in (1, 1.5, 2, 2.5, 3):
        mixture = ["--alpha", alpha, "--hem-levels", 5, "--flat-levels", 0]
        share = runner.compression(points, *mixture)
        row = [f"{alpha}", f"{100 * share:.1f} %"]
        for h, (_, shares, means) in zip(KERNELS, compressions):
            normals, _ = runner.normals(points, "--method", "csw", "--support-radius", f"{100 * h:g}%",
                                        "--orient", "none", *mixture)
            errors = degrees_between(normals, truth)
            shares.append(share)
            means.append(errors.mean())
            row += [figures(errors)[i] for i in (0, 1, 3)]
        rows.append(row)
    head = ["α", "Gaussians"]
    for h in KERNELS:
        head += [f"h = {100 * h:.1f} %: mean", "median", "above 10°"]
    text += table(head, rows) + "\n"
    text += "![Errors of normals](pictures/normals-error.png)\n"
    draw_curves(curves, compressions, pictures / "normals-error.png")
    return text


def nearest_normals(points, corners, faces):
    """Normals of the faces nearest to the points, and the distances."""
    from scipy.spatial import cKDTree

    triangles = corners[faces]
    candidates = cKDTree(triangles.mean(1)).query(points, 12, workers=-1)[1]
    a, b, c = (triangles[candidates, k] for k in range(3))
    p = points[:, None, :]
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-300)
    inside = np.ones(candidates.shape, bool)
    distance = np.full(candidates.shape, np.inf)
    for s, e in ((a, b), (b, c), (c, a)):
        along = ((p - s) * (e - s)).sum(2) / np.maximum(((e - s) ** 2).sum(2), 1e-300)
        foot = s + np.clip(along, 0, 1)[..., None] * (e - s)
        distance = np.minimum(distance, np.linalg.norm(p - foot, axis=2))
        inside &= (np.cross(e - s, p - s) * normal).sum(2) >= 0
    distance = np.where(inside, np.abs(((p - a) * normal).sum(2)), distance)
    best = distance.argmin(1)
    each = np.arange(len(points))
    return normal[each, best], distance[each, best]


def measure_scans(runner, data, names):
    text = ("Virtual scans of meshes, 300,000, 150,000 and 75,000 points, with noise of 0.02, 0.1 and 0.25 % of the diagonal; "
            "s2 and s3 with errors of registration and outliers. Normals at every n-th point, about "
            f"{JUDGED:,} of them, against that of the nearest face of the truth; points farther than 1 % of the diagonal "
            "from it do not count. All options at their defaults. Mean / median / 95 %; *turned*: normals that the minimum "
            "spanning tree leaves on the wrong side, of those from planes.\n\n")
    rows, seconds = [], {method: [] for method in ("pca", "weiszfeld", "csw")}
    for name in names:
        truth = Ply(data / "truth" / f"{name}.ply")
        corners, faces = truth.positions, truth.faces()
        diagonal = np.linalg.norm(corners.max(0) - corners.min(0))
        for grade in ("s1", "s2", "s3"):
            scan = data / "scans" / f"{name}.{grade}.ply"
            positions = Ply(scan).positions
            judged = slice(None, None, max(1, len(positions) // JUDGED))
            exact, distance = nearest_normals(positions[judged], corners, faces)
            near = distance < 0.01 * diagonal
            row, turned = [f"{name} {grade}"], 0
            for method in seconds:
                orient = "mst" if method == "pca" else "none"
                normals, used = runner.normals(scan, "--method", method, "--orient", orient)
                seconds[method].append(used / len(positions) * 1e5)
                errors = degrees_between(normals[judged][near], exact[near])
                row.append(f"{errors.mean():.2f}° / {np.median(errors):.2f}° / {np.percentile(errors, 95):.1f}°")
                if method == "pca":
                    turned = ((normals[judged][near] * exact[near]).sum(1) < 0).mean()
            rows.append(row + [f"{100 * turned:.2f} %"])
    text += table(["scan", "pca", "weiszfeld", "csw", "turned"], rows) + "\n"
    text += "CPU seconds per 100,000 points, whole process, mean over these scans: " + ", ".join(
        f"{method} {np.mean(used):.2f}" for method, used in seconds.items()) + " (pca with the tree).\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=GPSRECON)
    parser.add_argument("--data", type=Path, help="folder of scans and truth; without it that section stays")
    parser.add_argument("--page", type=Path, default=PAGE, help="its sections are replaced, and the pictures beside it")
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    pictures = arguments.page.parent / "pictures"
    pictures.mkdir(parents=True, exist_ok=True)

    def write(name, text):
        replace_sections(arguments.page, {f"{name}: measured by scripts/normals.py": f"\n{text}\n"})

    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(arguments.program, Path(folder))
        write("creases", measure_block(runner, 10000 if arguments.quick else 100000, pictures))
        if arguments.data:
            write("scans", measure_scans(runner, arguments.data, NAMES[1:2] if arguments.quick else NAMES))
    return 0


if __name__ == "__main__":
    sys.exit(exit_code_of(main))
