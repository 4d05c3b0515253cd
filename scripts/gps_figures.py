#!/usr/bin/python3
"""Reproduces the modelling figures of the paper on Gaussian-product subdivision surfaces, as pictures with numbers.

    scripts/gps_figures.py [--program FILE] [--out FOLDER] [--page FILE] [--work FOLDER] [--only 5,9,...]
                           [--scheme catmull-clark|loop]

Figures 5, 6, 7, 9, 10, 11 and 12 of Preiner et al. 2019, on shapes that the script makes itself; figure 7 needs
meshes/tweety.off in the folder that the environment variable GPSRECON_DATA_DIR names, and is left out without it. All
surfaces come from the program gpsrecon; the script makes control meshes, measures and draws. It prints the commands it
runs, and writes FIGURE.png and numbers.json to --out. Docs: docs/evidence/figures.md.

Packages (scripts/install_packages.sh develop): python3-meshio python3-matplotlib python3-vtk9 xvfb xauth. Without a
display it starts one of its own.

Exit codes: 0 done, 2 usage, 3 a program failed, or the page has no place for a table.
"""

import argparse
import itertools
import json
import math
import os
import shlex
import sys
import tempfile
from pathlib import Path

import numpy as np

from lab.pages import replace_sections, table
from lab.pictures import pyplot, save
from lab.ply import Ply
from lab.runner import GPSRECON, ROOT, Gpsrecon, exit_code_of
from lab.scenes import add_caption, in_display, set_lights, write

LEVELS = 5  # of the surfaces that are drawn: finer than a pixel
SCHEMES = {"catmull-clark": "Catmull-Clark", "loop": "Loop"}
COLORS = {"surface": (0.80, 0.74, 0.64), "linear": (0.62, 0.71, 0.80), "gaussian": (0.16, 0.38, 0.78),
          "wire": (0.25, 0.25, 0.25)}


# ---- the program, and the files it reads and writes ----


class Program:
    """Runs gpsrecon in one folder, and tells the commands. `scheme` is that of figures 5, 9, 11 and 12."""

    def __init__(self, path, folder, scheme):
        self.gpsrecon, self.folder, self.scheme = Gpsrecon(path, folder=folder), folder, scheme

    def __call__(self, *words):
        print("    gpsrecon " + shlex.join(map(str, words)), flush=True)
        self.gpsrecon.run(*words)

    def control(self, name, positions, faces):
        """Writes a control mesh, in triangles if the scheme needs them."""
        write_obj(self.folder / name, positions, triangulated(positions, faces) if self.scheme == "loop" else faces)

    def surface(self, covmesh, levels=LEVELS):
        """The limit surface of a covariance mesh."""
        return self.subdivide(covmesh, levels, "--scheme", self.scheme)

    def loop_surface(self, covmesh, levels=LEVELS, *options):
        """The same of a triangle mesh, whatever the scheme of the others."""
        return self.subdivide(covmesh, levels, *options)

    def subdivide(self, covmesh, levels, *options):
        out = f"{Path(covmesh).stem}.surface.ply"
        self("subdivide", covmesh, out, "--levels", levels, *options)
        return Surface(self.folder / out)

    def edited(self, covmesh, out, *steps):
        self("covmesh", covmesh, out, *steps)
        return out


class Surface:
    """A mesh in a PLY file as arrays: positions (n, 3), normals (n, 3), faces (m, k)."""

    def __init__(self, path):
        mesh = Ply(path)
        self.positions, self.normals, self.faces = mesh.positions, mesh.normals(), mesh.faces()

    def triangles(self):
        fan = [self.faces[:, [0, k, k + 1]] for k in range(1, self.faces.shape[1] - 1)]
        return np.concatenate(fan)

    def area(self):
        a, b, c = (self.positions[self.triangles()[:, k]] for k in range(3))
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())

    def volume(self):
        a, b, c = (self.positions[self.triangles()[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    def edges(self):
        ends = np.concatenate([np.stack([self.faces[:, k], np.roll(self.faces, -1, axis=1)[:, k]], axis=1)
                               for k in range(self.faces.shape[1])])
        return np.unique(np.sort(ends, axis=1), axis=0)

    def largest_turn(self):
        """Largest angle in degrees between the normals at the two ends of an edge."""
        e = self.edges()
        cosine = np.einsum("ij,ij->i", self.normals[e[:, 0]], self.normals[e[:, 1]])
        return float(np.degrees(np.arccos(np.clip(cosine, -1, 1)).max()))


def read_gaussians(path):
    """Means and covariances of a covariance mesh."""
    mesh = Ply(path)
    return mesh.positions, mesh.covariances()


def write_obj(path, positions, faces):
    with open(path, "w", encoding="ascii") as file:
        for p in positions:
            file.write("v " + " ".join(repr(float(x)) for x in p) + "\n")
        for face in faces:
            file.write("f " + " ".join(str(v + 1) for v in face) + "\n")


def triangulated(positions, faces):
    """Quads split along their shorter diagonal, other polygons into fans."""
    triangles = []
    for face in faces:
        across = lambda i, j: math.dist(positions[face[i]], positions[face[j]])
        start = 1 if len(face) == 4 and across(1, 3) < across(0, 2) else 0
        turned = face[start:] + face[:start]
        triangles += [(turned[0], turned[k], turned[k + 1]) for k in range(1, len(face) - 1)]
    return triangles


# ---- control meshes ----


def cube():
    """Corner k at (+-1, +-1, +-1) by the bits of k, six quads."""
    positions = [(2 * (k & 1) - 1, 2 * (k >> 1 & 1) - 1, 2 * (k >> 2 & 1) - 1) for k in range(8)]
    return positions, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def boundary_of_cells(cells, x, y, z):
    """The quads between filled and empty cells of a grid with the given planes; only the vertices in use."""
    index, positions, faces = {}, [], []

    def vertex(i, j, k):
        if (i, j, k) not in index:
            index[i, j, k] = len(positions)
            positions.append((x[i], y[j], z[k]))
        return index[i, j, k]

    for i, j, k in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                neighbor = [i, j, k]
                neighbor[axis] += 2 * side - 1
                if tuple(neighbor) in cells:
                    continue
                corners = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    at = [i, j, k]
                    at[axis] += side
                    at[(axis + 1) % 3] += u
                    at[(axis + 2) % 3] += v
                    corners.append(vertex(*at))
                faces.append(tuple(corners if side else reversed(corners)))
    return positions, faces


def jack():
    """Three crossing bars: vertices of valence 3, at their ends, 4 and 6, where they cross."""
    planes = [-4.0, -0.9, 0.9, 4.0]
    cells = {(1, 1, 1), (0, 1, 1), (2, 1, 1), (1, 0, 1), (1, 2, 1), (1, 1, 0), (1, 1, 2)}
    return boundary_of_cells(cells, planes, planes, planes)


def cone():
    """An apex (vertex 0) over a ring of eight."""
    d = 1.41421
    positions = [(0, 1.5, 0), (d, -1.5, -d), (0, -1.5, -2), (-d, -1.5, -d), (-2, -1.5, 0), (-d, -1.5, d), (0, -1.5, 2),
                 (d, -1.5, d), (2, -1.5, 0)]
    return positions, [(0, i, i + 1) for i in range(1, 8)] + [(0, 8, 1)]


HELIX = {"radius": 1.0, "pitch": 1.1, "tube": 0.32}


def helix_point(angle):
    return (HELIX["radius"] * math.cos(angle), HELIX["radius"] * math.sin(angle),
            HELIX["pitch"] * angle / (2 * math.pi))


def helix():
    """A tube of eight sides along two turns of a helix whose rings come in close pairs: every other quad is thin."""
    sides, wide, thin = 8, math.radians(52), math.radians(8)
    angles = []
    while not angles or angles[-1] < 4 * math.pi:
        angles.append(angles[-1] + (wide if len(angles) % 2 == 0 else thin) if angles else 0.0)
    positions, faces = [], []
    slope = HELIX["pitch"] / (2 * math.pi)
    for angle in angles:
        tangent = np.array((-HELIX["radius"] * math.sin(angle), HELIX["radius"] * math.cos(angle), slope))
        tangent /= np.linalg.norm(tangent)
        outward = np.array((math.cos(angle), math.sin(angle), 0))
        up = np.cross(outward, tangent)
        for s in range(sides):
            turn = 2 * math.pi * s / sides
            offset = HELIX["tube"] * (math.cos(turn) * outward + math.sin(turn) * up)
            positions.append(tuple(np.array(helix_point(angle)) + offset))
    at = lambda ring, side: ring * sides + side % sides
    for ring in range(len(angles) - 1):
        for s in range(sides):
            faces.append((at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1)))
    faces.append(tuple(at(0, s) for s in range(sides)))
    faces.append(tuple(at(len(angles) - 1, s) for s in reversed(range(sides))))
    return positions, faces, angles


def axe():
    """Head and handle of quads, and two triangles where the head ends in the two cusps of the blade, the last two
    vertices."""
    head = [(-0.8, 0.55, 0.30), (0.2, 0.55, 0.30), (1.1, 0.60, 0.20)]  # x, half height, half width
    positions, faces = [], []
    for x, h, w in head:
        positions += [(x, h, w), (x, h, -w), (x, -h, -w), (x, -h, w)]
    at = lambda station, corner: 4 * station + corner
    faces.append((at(0, 0), at(0, 1), at(0, 2), at(0, 3)))
    for s in (0, 1):
        for c in range(4):
            if s == 0 and c == 2:
                continue  # where the handle goes down
            faces.append((at(s, c), at(s + 1, c), at(s + 1, (c + 1) % 4), at(s, (c + 1) % 4)))
    ring = [at(0, 2), at(1, 2), at(1, 3), at(0, 3)]
    for y in (-2.2, -4.0):
        below = list(range(len(positions), len(positions) + 4))
        positions += [(-0.65, y, -0.24), (0.05, y, -0.24), (0.05, y, 0.24), (-0.65, y, 0.24)]
        faces += [(ring[k], ring[(k + 1) % 4], below[(k + 1) % 4], below[k]) for k in range(4)]
        ring = below
    faces.append(tuple(ring))
    top, bottom = len(positions), len(positions) + 1
    positions += [(2.3, 1.25, 0.0), (2.3, -1.25, 0.0)]
    faces += [(at(2, 0), top, at(2, 1)), (at(2, 2), bottom, at(2, 3)), (at(2, 1), top, bottom, at(2, 2)),
              (at(2, 3), bottom, top, at(2, 0))]
    return positions, faces


# ---- drawing ----


class View:
    """What one part of a picture shows."""

    def __init__(self, caption, surface=None, color="surface", wire=None, gaussians=None, scale=1.0, stripes=None,
                 opacity=1.0):
        self.caption, self.surface, self.color, self.wire = caption, surface, COLORS[color], wire
        self.gaussians, self.scale, self.stripes, self.opacity = gaussians, scale, stripes, opacity


def draw(path, views, columns, size, direction, up, zoom=1.25, box=None):
    """Views in a grid, all from the same side and at the same scale. `size` is that of one view in pixels."""
    import vtkmodules.vtkRenderingFreeType  # noqa: F401 (implementations are registered by importing them)
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
    from vtkmodules.vtkFiltersSources import vtkSphereSource
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper, vtkRenderer, vtkRenderWindow

    direction, up = (np.array(v, float) / np.linalg.norm(v) for v in (direction, up))

    def cells_of(lists):
        flat = np.concatenate([np.concatenate(([len(f)], f)) for f in lists]).astype(np.int64)
        cells = vtkCellArray()
        cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(flat, deep=True))
        return cells

    def points_of(positions):
        points = vtkPoints()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(positions, float), deep=True))
        return points

    def surface_actor(view):
        data = vtkPolyData()
        data.SetPoints(points_of(view.surface.positions))
        faces = view.surface.faces
        flat = np.concatenate([np.full((len(faces), 1), faces.shape[1]), faces], axis=1).astype(np.int64).ravel()
        cells = vtkCellArray()
        cells.ImportLegacyFormat(numpy_to_vtkIdTypeArray(flat, deep=True))
        data.SetPolys(cells)
        data.GetPointData().SetNormals(numpy_to_vtk(np.ascontiguousarray(view.surface.normals), deep=True))
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetColor(*view.color)
        look.SetOpacity(view.opacity)
        look.SetInterpolationToPhong()
        look.SetAmbient(0.12)
        look.SetDiffuse(0.8)
        look.SetSpecular(0.25)
        look.SetSpecularPower(30)
        if view.stripes:
            axis, count = view.stripes
            n = view.surface.normals
            toward = direction
            reflected = 2 * (n @ toward)[:, None] * n - toward
            data.GetPointData().SetScalars(numpy_to_vtk(reflected @ np.array(axis, float), deep=True))
            table = vtkLookupTable()
            table.SetNumberOfTableValues(2 * count)
            for k in range(2 * count):
                table.SetTableValue(k, *((0.1, 0.1, 0.15) if k % 2 else (0.97, 0.97, 0.95)), 1)
            mapper.SetLookupTable(table)
            mapper.SetScalarRange(-1, 1)
            mapper.InterpolateScalarsBeforeMappingOn()
            look.SetAmbient(0.45)
            look.SetDiffuse(0.55)
            look.SetSpecular(0)
        return actor

    def wire_actors(wire, solid):
        positions, faces = wire
        data = vtkPolyData()
        data.SetPoints(points_of(positions))
        data.SetLines(cells_of([list(f) + [f[0]] for f in faces]))
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(data)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(*COLORS["wire"])
        actor.GetProperty().SetLineWidth(1.3)
        actor.GetProperty().LightingOff()
        yield actor
        if not solid:
            return
        # Faces just behind their edges.
        filled = vtkPolyData()
        filled.SetPoints(points_of(positions))
        filled.SetPolys(cells_of(faces))
        mapper = vtkPolyDataMapper()
        mapper.SetInputData(filled)
        mapper.SetResolveCoincidentTopologyToPolygonOffset()
        mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2, 2)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(0.95, 0.95, 0.95)
        actor.GetProperty().SetAmbient(0.5)
        actor.GetProperty().SetDiffuse(0.5)
        actor.GetProperty().SetInterpolationToFlat()
        yield actor

    def gaussian_actors(view):
        means, covariances = view.gaussians
        for mean, covariance in zip(means, covariances):
            values, vectors = np.linalg.eigh(covariance)
            vectors = vectors * np.linalg.det(vectors)  # no mirror, which would turn normals inward
            matrix = vtkMatrix4x4()
            # Thinner than a pixel nothing is drawn.
            axes = vectors * np.maximum(view.scale * np.sqrt(values), 0.012)
            for i in range(3):
                for j in range(3):
                    matrix.SetElement(i, j, axes[i, j])
                matrix.SetElement(i, 3, mean[i])
            sphere = vtkSphereSource()
            sphere.SetRadius(1)
            sphere.SetThetaResolution(24)
            sphere.SetPhiResolution(16)
            mapper = vtkPolyDataMapper()
            mapper.SetInputConnection(sphere.GetOutputPort())
            actor = vtkActor()
            actor.SetMapper(mapper)
            actor.SetUserMatrix(matrix)
            actor.GetProperty().SetColor(*COLORS["gaussian"])
            actor.GetProperty().SetOpacity(0.5)
            actor.GetProperty().BackfaceCullingOn()
            yield actor

    window = vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    rows = -(-len(views) // columns)
    window.SetSize(columns * size[0], rows * size[1])
    window.SetAlphaBitPlanes(1)

    everything = []
    for view in views:
        everything += [view.surface.positions] if view.surface else []
        everything += [np.array(view.wire[0], float)] if view.wire else []
    corners = np.concatenate(everything) if box is None else np.array(list(itertools.product(*zip(*box))), float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    center = 0.5 * (low + high)
    right = np.cross(up, direction)
    right /= np.linalg.norm(right)
    true_up = np.cross(direction, right)
    extent_up = np.abs((corners - center) @ true_up).max()
    extent_right = np.abs((corners - center) @ right).max()

    for number, view in enumerate(views):
        renderer = vtkRenderer()
        row, column = divmod(number, columns)
        renderer.SetViewport(column / columns, 1 - (row + 1) / rows, (column + 1) / columns, 1 - row / rows)
        renderer.SetBackground(1, 1, 1)
        if view.surface:
            renderer.AddActor(surface_actor(view))
        if view.wire:
            for actor in wire_actors(view.wire, solid=view.surface is None):
                renderer.AddActor(actor)
        if view.gaussians:
            for actor in gaussian_actors(view):
                renderer.AddActor(actor)
        add_caption(renderer, view.caption, size[0], 14)
        set_lights(renderer, (((0.5, 0.8, 1.0), 0.85), ((-0.9, 0.1, 0.7), 0.35)))
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        distance = 10 * np.linalg.norm(high - low)
        camera.SetFocalPoint(*(center - 0.06 * extent_up * true_up))
        camera.SetPosition(*(center - 0.06 * extent_up * true_up + distance * direction))
        camera.SetViewUp(*true_up)
        camera.SetParallelScale(zoom * max(extent_up, extent_right * size[1] / size[0]))
        renderer.ResetCameraClippingRange()
        window.AddRenderer(renderer)
    write(window, path)


# ---- the figures ----


def figure_5(run, out):
    """Reflection lines on the linear and on the Gaussian-product surface of three crossing bars."""
    positions, faces = jack()
    run.control("jack.obj", positions, faces)
    run("infer", "jack.obj", "jack.ply")
    run.edited("jack.ply", "jack-linear.ply", "--set", 1)
    numbers = {}
    surfaces = {}
    for name in ("jack-linear", "jack"):
        turns = {}
        for level in (3, 4, 5, 6):
            surfaces[name] = run.surface(name + ".ply", level)
            turns[level] = surfaces[name].largest_turn()
        numbers[name] = {"area": surfaces[name].area(), "volume": surfaces[name].volume(),
                         "largest_turn_degrees_by_level": turns}
    stripes = ((0.3, 1.0, 0.2), 7)
    views = [View("control mesh and Gaussians", wire=(positions, faces),
                  gaussians=read_gaussians(run.folder / "jack.ply")),
             View(SCHEMES[run.scheme], surfaces["jack-linear"], stripes=stripes),
             View("Gaussian-product " + SCHEMES[run.scheme], surfaces["jack"], stripes=stripes)]
    draw(out / "figure-5.png", views, 3, (340, 340), (0.75, 0.5, 1), (0, 1, 0), zoom=1.1)
    return numbers


def product_curve(a, b, count):
    """Eq. 5 between two Gaussians (mean, covariance)."""
    t = np.linspace(0, 1, count)
    curve = []
    for s in t:
        pa, pb = (1 - s) * np.linalg.inv(a[1]), s * np.linalg.inv(b[1])
        curve.append(np.linalg.solve(pa + pb, pa @ a[0] + pb @ b[0]))
    return np.array(curve)


def figure_6(run, out):
    """Two Gaussians and the curve between them, as their shapes change.

    (a) tangential variance down, (b) orthogonal variance up, (c) orthogonal variance down. The curve is an edge of a
    triangle with sharp corners, on which nothing else acts.
    """
    plt = pyplot()
    from matplotlib.patches import Ellipse
    slope = math.radians(50)
    along = [np.array((math.cos(slope), math.sin(slope), 0)), np.array((math.cos(slope), -math.sin(slope), 0))]
    mean = [np.array((-1.0, 0, 0)), np.array((1.0, 0, 0))]
    levels = 6
    write_obj(run.folder / "two.obj", [(-1, 0, 0), (1, 0, 0), (0, 0, -1)], [(0, 1, 2)])
    run("infer", "two.obj", "two.ply")

    def covariance(side, tangential, orthogonal):
        t = along[side]
        o = np.array((-t[1], t[0], 0))
        return tangential ** 2 * np.outer(t, t) + orthogonal ** 2 * np.outer(o, o) + np.diag((0, 0, 0.25))

    def word(c):
        return ",".join(repr(float(x)) for x in (c[0, 0], c[0, 1], c[0, 2], c[1, 1], c[1, 2], c[2, 2]))

    studies = {"a": [(0.9, 0.12), (0.45, 0.12), (0.22, 0.12), (0.12, 0.12)],
               "b": [(0.9, 0.12), (0.9, 0.24), (0.9, 0.42)],
               "c": [(0.9, 0.12), (0.9, 0.05), (0.9, 0.02)]}
    titles = {"a": "(a) tangential variance down", "b": "(b) orthogonal variance up",
              "c": "(c) orthogonal variance down"}
    numbers = {}
    figure, axes = plt.subplots(1, 3, figsize=(11, 3.6), dpi=90)
    for axis, (study, shapes) in zip(axes, studies.items()):
        for number, (tangential, orthogonal) in enumerate(shapes):
            c = [covariance(side, tangential, orthogonal) for side in (0, 1)]
            name = f"two-{study}{number}.ply"
            run.edited("two.ply", name, "--select", 0, "--set", word(c[0]), "--select", 1, "--set", word(c[1]))
            surface = run.loop_surface(name, levels, "--corners", "sharp")
            curve = surface.positions[np.abs(surface.positions[:, 2]) < 1e-6]
            curve = curve[np.argsort(curve[:, 0])]
            expected = product_curve((mean[0], c[0]), (mean[1], c[1]), 2 ** levels + 1)
            expected = expected[np.argsort(expected[:, 0])]
            # Radius of the circle through the three points in the middle.
            p = curve[len(curve) // 2 - 1:len(curve) // 2 + 2, :2]
            sides = [np.linalg.norm(p[i] - p[i - 1]) for i in range(3)]
            cross = abs(np.cross(p[1] - p[0], p[2] - p[0]))
            numbers[f"{study}{number}"] = {
                "tangential": tangential, "orthogonal": orthogonal, "height": float(curve[:, 1].max()),
                "middle_radius": float(np.prod(sides) / (2 * cross)) if cross > 1e-6 * max(sides) ** 2 else None,
                "distance_to_equation_5": float(np.abs(curve - expected).max())}
            color = plt.cm.viridis(number / max(1, len(shapes) - 1) * 0.85)
            axis.plot(curve[:, 0], curve[:, 1], color=color, lw=2,
                      label=f"σ along {tangential}, across {orthogonal}")
            for side in (0, 1):
                axis.add_patch(Ellipse(mean[side][:2], 2 * tangential, 2 * orthogonal,
                                       angle=math.degrees(slope) * (1, -1)[side], fill=False, ec=color, lw=1, ls="--"))
        axis.set_title(titles[study], fontsize=10)
        axis.set_aspect("equal")
        axis.set_xlim(-1.8, 1.8)
        axis.set_ylim(-0.9, 1.5)
        axis.legend(fontsize=7, loc="lower center", frameon=False)
        axis.axis("off")
    figure.tight_layout()
    save(figure, out / "figure-6.png")
    print(f"  figure-6.png: {(out / 'figure-6.png').stat().st_size / 1000:.0f} kB", flush=True)
    return numbers


def figure_7(run, out):
    """Loop and Gaussian-product Loop surface of one coarse mesh."""
    data = os.environ.get("GPSRECON_DATA_DIR")
    tweety = Path(data) / "meshes" / "tweety.off" if data else None
    if tweety is None or not tweety.exists():
        print("  left out: GPSRECON_DATA_DIR names no folder with meshes/tweety.off", flush=True)
        return None
    run("infer", tweety, "tweety.ply")
    run.edited("tweety.ply", "tweety-linear.ply", "--set", 0.1)
    run.edited("tweety.ply", "tweety.obj")
    numbers, surfaces = {}, {}
    for name in ("tweety-linear", "tweety"):
        rows = {}
        for level in (1, 2, 3, 4):
            surface = surfaces[name] = run.loop_surface(name + ".ply", level, "--loop-weights", "warren")
            rows[level] = {"vertices": len(surface.positions), "area": surface.area(), "volume": surface.volume()}
        numbers[name] = rows
    lines = [line.split() for line in (run.folder / "tweety.obj").read_text().splitlines()]
    wire = ([tuple(map(float, words)) for kind, *words in lines if kind == "v"],
            [tuple(int(word) - 1 for word in words) for kind, *words in lines if kind == "f"])
    views = [View("control mesh and Gaussians", wire=wire, gaussians=read_gaussians(run.folder / "tweety.ply")),
             View("Loop", surfaces["tweety-linear"], "linear"), View("Gaussian-product Loop", surfaces["tweety"])]
    draw(out / "figure-7.png", views, 3, (320, 380), (1, 0.1, 0.7), (0, 1, 0), zoom=1.1)
    return numbers


def figure_9(run, out):
    """Surfaces of one cube with different covariances."""
    positions, faces = cube()
    run.control("cube.obj", positions, faces)
    run("infer", "cube.obj", "cube.ply")
    ball = ["--set", 0.3]

    def along(directions, factor):
        """A step for each corner: its variance along a direction of its own, times a factor."""
        words = []
        for k, d in directions.items():
            words += ["--select", k, "--flatten", f"{d[0]},{d[1]},{d[2]}:{factor}"]
        return words

    even = (0, 3, 5, 6)  # the corners of one of the two tetrahedra in the cube
    at = lambda corners: ",".join(map(str, corners))
    outward = dict(enumerate(positions))
    sideways = {k: (x, 0, z) for k, (x, y, z) in outward.items()}
    around = {k: (z, 0, -x) for k, (x, y, z) in outward.items()}
    only = lambda directions, corners: {k: directions[k] for k in corners}
    shapes = {
        "one covariance for all": ["--set", "0.15,0.6,0.3"],
        "equal balls": ball,
        "small balls, one tetrahedron": ball + ["--select", at(even), "--scale", 0.02],
        "a needle": ball + ["--select", 7, "--scale", 0.02] + along(only(outward, [7]), 100),
        "discs across diagonals": ball + along(outward, 0.2),
        "discs, one tetrahedron": ball + along(only(outward, even), 0.15),
        "discs around the axis": ball + along(sideways, 0.02),
        "two discs, side by side": ball + ["--select", "3,6", "--flatten", "1,0,0:0.01"],
        "ellipsoids, turned by column": ["--select", "0,2,5,7", "--set", "0.02,0.3,1", "--select", "1,3,4,6", "--set",
                                         "1,0.3,0.02"],
        "discs, half of them turned": (ball + along(only(around, range(4)), 0.02)
                                       + along(only(sideways, range(4, 8)), 0.02)),
    }
    numbers, views, first = {}, [], None
    for number, (caption, steps) in enumerate(shapes.items()):
        name = f"cube-{number}.ply"
        run.edited("cube.ply", name, *steps)
        surface = run.surface(name)
        first = surface if first is None else first
        numbers[caption] = {"area": surface.area(), "volume": surface.volume(),
                            "largest_turn_degrees": surface.largest_turn(),
                            "distance_to_first": float(np.abs(surface.positions - first.positions).max())}
        views.append(View(caption, surface, "linear" if number == 0 else "surface", (positions, faces),
                          read_gaussians(run.folder / name)))
    draw(out / "figure-9.png", views, 5, (220, 240), (0.55, 0.45, 1), (0, 1, 0), box=((-1.3,) * 3, (1.3,) * 3))
    return numbers


def figure_10(run, out):
    """Surfaces of one cone with different covariances at its apex."""
    positions, faces = cone()
    write_obj(run.folder / "cone.obj", positions, faces)
    run("infer", "cone.obj", "cone.ply")
    apex = {"isotropic: Loop": "0.01,0,0,0.01,0,0.01", "pointy": "1e-5,0,0,1e-5,0,1e-5",
            "concave ridge": "0.001,0,0,0.01,0,0.01", "smooth plateau": "0.01,0,0,0.001,0,0.01",
            "sharp plateau": "1,0,0,1e-5,0,1"}
    numbers, views = {}, []
    for number, (caption, covariance) in enumerate(apex.items()):
        name = f"cone-{number}.ply"
        run.edited("cone.ply", name, "--set", 0.1, "--select", 0, "--set", covariance)
        surface = run.loop_surface(name, LEVELS, "--loop-weights", "warren")
        numbers[caption] = {"covariance": covariance, "apex_y": float(surface.positions[0, 1]), "area": surface.area()}
        views.append(View(caption, surface, "linear" if number == 0 else "surface", (positions, faces),
                          read_gaussians(run.folder / name), scale=2 if number < 4 else 1))
    draw(out / "figure-10.png", views, 5, (210, 240), (0.4, 0.35, 1), (0, 1, 0), zoom=1.15)
    return numbers


def helix_deviation(surface, angles):
    """Distance of the surface from the axis of the tube, without the first and last quarter turn: mean and standard
    deviation."""
    fine = np.linspace(angles[0], angles[-1], 20001)
    axis = np.array([helix_point(angle) for angle in fine])
    coarse = axis[::20]
    distances = []
    for p in surface.positions:
        near = 20 * np.linalg.norm(coarse - p, axis=1).argmin()
        first = max(0, near - 20)
        distance = np.linalg.norm(axis[first:near + 21] - p, axis=1)
        foot = fine[first + distance.argmin()]
        if angles[0] + np.pi / 2 < foot < angles[-1] - np.pi / 2:
            distances.append(distance.min())
    return {"mean_radius": float(np.mean(distances)), "deviation_of_radius": float(np.std(distances))}


def figure_11(run, out):
    """A helix with thin quads: its linear and its Gaussian-product surface."""
    positions, faces, angles = helix()
    run.control("helix.obj", positions, faces)
    run("infer", "helix.obj", "helix.ply", "--bias", 0.3)
    run.edited("helix.ply", "helix-linear.ply", "--set", 1)
    numbers, surfaces = {}, {}
    for name in ("helix-linear", "helix"):
        surfaces[name] = run.surface(name + ".ply", 4)
        numbers[name] = {"area": surfaces[name].area(), "volume": surfaces[name].volume(),
                         **helix_deviation(run.surface(name + ".ply", 3), angles)}
    views = [View("control mesh", wire=(positions, faces)),
             View(SCHEMES[run.scheme], surfaces["helix-linear"], "linear"),
             View("Gaussian-product " + SCHEMES[run.scheme], surfaces["helix"])]
    draw(out / "figure-11.png", views, 3, (320, 340), (1, 0.4, 0.55), (0, 0, 1), zoom=1.1)
    return numbers


def blade(surface, behind):
    """Where the middle of the blade ends, and how thick it is a given distance behind that."""
    p = surface.positions
    middle = p[np.abs(p[:, 1]) < 0.05]
    tip = middle[:, 0].max()
    d = tip - middle[:, 0]
    order = np.argsort(d)
    thickness = {str(b): float(2 * np.interp(b, d[order], np.abs(middle[order, 2]))) for b in behind}
    return {"tip_x": float(tip), "thickness": thickness}


def figure_12(run, out):
    """An axe: linear, with inferred Gaussians, and with its two cusps flattened along their smallest axes."""
    positions, faces = axe()
    run.control("axe.obj", positions, faces)
    run("infer", "axe.obj", "axe.ply", "--bias", 0.3)
    run.edited("axe.ply", "axe-linear.ply", "--set", 1)
    cusps = "nearest:2:2.3,0,0"
    run.edited("axe.ply", "axe-sharp.ply", "--select", cusps, "--flatten", "smallest:0.001")
    numbers, views = {}, [View("control mesh and Gaussians", wire=(positions, faces),
                               gaussians=read_gaussians(run.folder / "axe.ply"))]
    for name, caption in (("axe-linear", SCHEMES[run.scheme]), ("axe", "inferred Gaussians"),
                          ("axe-sharp", "cusps flattened")):
        surface = run.surface(name + ".ply")
        numbers[name] = {"area": surface.area(), "volume": surface.volume(),
                         "largest_turn_degrees": surface.largest_turn(),
                         **blade(run.surface(name + ".ply", 6), (0.02, 0.05, 0.1, 0.2))}
        views.append(View(caption, surface, "linear" if name == "axe-linear" else "surface"))
    draw(out / "figure-12.png", views, 4, (250, 380), (0.75, 0.35, 1), (0, 1, 0), zoom=1.05)
    return numbers


FIGURES = {5: figure_5, 6: figure_6, 7: figure_7, 9: figure_9, 10: figure_10, 11: figure_11, 12: figure_12}


# ---- the numbers as tables ----


def tables(figure, n, scheme):
    """The numbers `n` of a figure in Markdown."""
    kinds = {"linear": SCHEMES[scheme], "gaussian": "Gaussian-product " + SCHEMES[scheme]}
    if figure == 5:
        levels = list(n["jack"]["largest_turn_degrees_by_level"])
        return table(["largest turn of the normal along an edge at level", *map(str, levels), "area", "volume"],
                     [[kinds[kind], *(f"{n[name]['largest_turn_degrees_by_level'][level]:.2f}°" for level in levels),
                       f"{n[name]['area']:.3f}", f"{n[name]['volume']:.3f}"]
                      for kind, name in (("linear", "jack-linear"), ("gaussian", "jack"))])
    if figure == 6:
        radius = lambda r: "straight" if r is None else f"{r:.5f}"
        return table(["", "σ along", "σ across", "height of the curve", "radius of curvature in the middle",
                      "distance to Eq. 5"],
                     [[f"({key[0]})", str(v["tangential"]), str(v["orthogonal"]), f"{v['height']:.5f}",
                       radius(v["middle_radius"]), f"{v['distance_to_equation_5']:.0e}"] for key, v in n.items()])
    if figure == 7:
        return table(["level", "vertices", "Loop volume", "Loop area", "GPS volume", "GPS area"],
                     [[str(level), f"{v['vertices']:,}", f"{n['tweety-linear'][level]['volume']:.6f}",
                       f"{n['tweety-linear'][level]['area']:.6f}", f"{v['volume']:.6f}", f"{v['area']:.6f}"]
                      for level, v in n["tweety"].items()])
    if figure == 9:
        return table(["covariances", "area", "volume", "largest turn along an edge", "distance to the first"],
                     [[key, f"{v['area']:.3f}", f"{v['volume']:.3f}", f"{v['largest_turn_degrees']:.1f}°",
                       f"{v['distance_to_first']:.1g}"] for key, v in n.items()])
    if figure == 10:
        return table(["apex", "covariance of the apex", "y of the apex", "area"],
                     [[key, f"`{v['covariance']}`", f"{v['apex_y']:.6f}", f"{v['area']:.4f}"] for key, v in n.items()])
    if figure == 11:
        return table(["", "mean radius of the tube", "standard deviation", "of the mean"],
                     [[kinds[kind], f"{n[name]['mean_radius']:.4f}", f"{n[name]['deviation_of_radius']:.4f}",
                       f"{100 * n[name]['deviation_of_radius'] / n[name]['mean_radius']:.1f} %"]
                      for kind, name in (("linear", "helix-linear"), ("gaussian", "helix"))])
    depths = list(n["axe"]["thickness"])
    names = {"axe-linear": kinds["linear"], "axe": "inferred Gaussians", "axe-sharp": "cusps flattened"}
    return table(["", "x of the edge", *(f"thickness {d} behind it" for d in depths), "volume"],
                 [[caption, f"{n[name]['tip_x']:.3f}", *(f"{n[name]['thickness'][d]:.4f}" for d in depths),
                   f"{n[name]['volume']:.3f}"] for name, caption in names.items()])


def update_page(page, numbers, scheme):
    """Puts the tables into the sections `numbers N` of a page."""
    replace_sections(page, {f"numbers {n}": tables(n, numbers[f"figure {n}"], scheme)
                            for n in FIGURES if f"figure {n}" in numbers})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=GPSRECON, help="gpsrecon to use")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/evidence/pictures/gps", help="folder for pictures and numbers")
    parser.add_argument("--page", type=Path, help="Markdown file in which to update the tables, such as docs/evidence/figures.md")
    parser.add_argument("--work", type=Path, help="folder to keep meshes in; default: a temporary one")
    parser.add_argument("--scheme", choices=SCHEMES, default="catmull-clark",
                        help="of figures 5, 9, 11 and 12; loop splits their polygons into triangles")
    parser.add_argument("--only", default=",".join(map(str, FIGURES)), help="numbers of figures, separated by commas")
    arguments = parser.parse_args()
    try:
        wanted = [int(word) for word in arguments.only.split(",")]
    except ValueError:
        wanted = [0]
    if not set(wanted) <= set(FIGURES):
        parser.error(f"--only: expected numbers among {', '.join(map(str, FIGURES))}, got '{arguments.only}'")
    if not arguments.program.is_file():
        parser.error(f"--program: there is no {arguments.program}; build it, or name another")
    in_display()

    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / "numbers.json"
    numbers = json.loads(file.read_text()) if file.exists() else {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.work or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        run = Program(arguments.program.resolve(), folder.resolve(), arguments.scheme)
        for number in wanted:
            print(f"figure {number}: {FIGURES[number].__doc__.splitlines()[0]}", flush=True)
            measured = FIGURES[number](run, arguments.out)
            if measured is not None:
                numbers[f"figure {number}"] = json.loads(json.dumps(measured))
    ordered = {f"figure {n}": numbers[f"figure {n}"] for n in FIGURES if f"figure {n}" in numbers}
    file.write_text(json.dumps(ordered, indent=1) + "\n")
    if arguments.page:
        update_page(arguments.page, ordered, arguments.scheme)
    return 0


if __name__ == "__main__":
    sys.exit(exit_code_of(main))
