"""What the rows of scripts/benchmark.py say: the conclusions drawn from them, the page, and its pictures."""

import json
import sys

from lab.pages import section, table
from lab.pictures import pyplot, save
from lab.scans import SEED

GROWTH_SHAPE = "knot"
RIDGE_SAMPLES = 100_000
SLICE = 0.003  # half thickness of the slices shown of them, in extents


def total(row, key):
    """Of a method and the normals it needs."""
    return row[key] + (row[f"normals_{key}"] or 0)


def peak(row):
    return max(row["memory_MB"], row["normals_memory_MB"] or 0)


def size_of(row):
    """Vertices that are stored: those of the covariance mesh, where there is one."""
    return row["control_vertices"] if row["control_vertices"] != "" else row["vertices"]


def larger_rms(row):
    return max(row["rms_mesh_to_truth"], row["rms_truth_to_mesh"])


# ---------------------------------------------------------------------------------------------------------------------
# What the rows say


def select(rows, **wanted):
    return [row for row in rows if row["status"] == "ok" and all(row[key] == str(value) for key, value in wanted.items())]


def scan_names(rows, part):
    return list(dict.fromkeys(row["scan"] for row in rows if row["part"] == part))


def best_of(rows):
    """The row with the least larger RMS; None if there is none."""
    return min(rows, key=larger_rms, default=None)


def equal_accuracy(poisson, gpsrecon):
    """Per direction and for normals, whether gpsrecon is at least as accurate."""
    return tuple(gpsrecon[key] <= poisson[key] for key in ("rms_mesh_to_truth", "rms_truth_to_mesh", "normal_angle"))


def losses(rows, names):
    """Where gpsrecon, by default, is not the best: (scan, figure, its value, the other's, the other), and for others
    with several depths the depth that is most accurate."""
    found = []
    figures = (("RMS mesh to truth", "%", lambda r: r["rms_mesh_to_truth"]),
               ("RMS truth to mesh", "%", lambda r: r["rms_truth_to_mesh"]),
               ("normals", "°", lambda r: r["normal_angle"]), ("processor time", "s", lambda r: total(r, "cpu_s")),
               ("peak memory", "MB", peak), ("bytes of the result", "", stored_bytes))
    for scan in scan_names(rows, "accuracy"):
        ours = select(rows, part="accuracy", scan=scan, method="gpsrecon", setting="")
        for name in names:
            other = best_of(select(rows, part="accuracy", scan=scan, method=name))
            if name == "gpsrecon" or not ours or other is None:
                continue
            for title, unit, figure in figures:
                if figure(other) < figure(ours[0]):
                    found.append((scan, title, unit, figure(ours[0]), figure(other), other))
    return found


def stored_bytes(row):
    return row["bytes_covmesh"] if row["bytes_covmesh"] != "" else row["bytes_mesh"]


def growth_ratio(rows, method, small, large, figure):
    """figure(large) / figure(small) of the growth part; None if one is missing."""
    pair = [select(rows, part="growth", scan=f"{GROWTH_SHAPE}.s1@{size}", method=method) for size in (small, large)]
    return figure(pair[1][0]) / figure(pair[0][0]) if all(pair) else None


# ---------------------------------------------------------------------------------------------------------------------
# The page


def titles_of(rows, methods):
    known = {"gpsrecon": "gpsrecon", "pcl_poisson": "PCL Poisson", "open3d_poisson": "Open3D Poisson",
             "PoissonRecon": "PoissonRecon", "cgal_poisson": "CGAL Poisson", "cgal_front": "CGAL advancing front"}
    return {name: known.get(name, name) for name in dict.fromkeys([r["method"] for r in rows] + list(methods))}


def label(row, titles):
    setting = row["setting"]
    if row["method"] == "gpsrecon":
        return f"gpsrecon, detail {setting}" if setting else "gpsrecon"
    return titles[row["method"]] + (f", depth {setting}" if setting else "")


def accuracy_lines(rows, titles):
    lines = ["## Accuracy, time and size", "",
             "Per scan gpsrecon with default options, then the others. RMS of the distances, mesh to truth / truth to mesh, in % of the",
             "diagonal; mean normal angle; c / l / χ: components, boundary loops and Euler number; nm: non-manifold edges and vertices;",
             "RMS of the distances of the points to the mesh (\"self\"); vertices that are stored, and bytes: of gpsrecon those of the",
             "covariance mesh, and in brackets of the refined mesh. Processor (CPU) and wall time, file to file, and peak memory;",
             "normals included, which cost what is said in brackets.", ""]
    for scan in scan_names(rows, "accuracy"):
        body = []
        here = [r for r in rows if r["part"] == "accuracy" and r["scan"] == scan and
                not (r["method"] == "gpsrecon" and r["setting"])]
        for row in here:
            if row["status"] != "ok":
                body.append([label(row, titles), row["status"]] + [""] * 8)
                continue
            normals = f" ({row['normals_cpu_s']:.1f})" if row["normals_cpu_s"] != "" else ""
            mesh = f" ({row['bytes_mesh'] / 1e6:.2f})" if row["bytes_covmesh"] != "" else ""
            vertices = f" ({int(row['vertices']):,})" if row["control_vertices"] != "" else ""
            body.append([label(row, titles), f"{row['rms_mesh_to_truth']:.4f} / {row['rms_truth_to_mesh']:.4f}",
                         f"{row['normal_angle']:.2f}°",
                         f"{row['components']} / {row['boundary_loops']} / {row['euler']}", f"{row['nonmanifold']}",
                         f"{row['self_rms']:.4f}", f"{int(size_of(row)):,}{vertices}",
                         f"{stored_bytes(row) / 1e6:.2f}{mesh}",
                         f"{total(row, 'cpu_s'):.1f}{normals} / {total(row, 'wall_s'):.1f}", f"{peak(row):.0f}"])
        points = next((f", {int(r['points']):,} points" for r in here if r["points"] != ""), "")
        lines += [f"### {scan}{points}", "",
                  table(["", "RMS", "normals", "c / l / χ", "nm", "self", "vertices", "MB", "CPU / wall, s", "memory, MB"], body)]
    return lines


def budget_lines(rows, titles):
    body, wins, count = [], [0, 0, 0], 0
    methods = set()
    for scan in scan_names(rows, "budget"):
        for ours in [r for r in rows if r["part"] == "budget" and r["scan"] == scan]:
            method, depth = ours["setting"].rsplit(" ", 1)
            (poisson,) = select(rows, part="accuracy", scan=scan, method=method, setting=depth) or [None]
            if poisson is None:
                continue
            methods.add(titles.get(method, method))
            if ours["status"] != "ok":
                body.append([scan, depth, f"{int(poisson['vertices']):,}", "", "", ours["status"], "", ""])
                continue
            count += 1
            verdicts = equal_accuracy(poisson, ours)
            wins = [w + v for w, v in zip(wins, verdicts)]
            mark = lambda value, better, form: f"**{form.format(value)}**" if better else form.format(value)
            body.append([scan, depth, f"{int(poisson['vertices']):,}",
                         f"{poisson['rms_mesh_to_truth']:.4f} / {poisson['rms_truth_to_mesh']:.4f}, {poisson['normal_angle']:.2f}°",
                         f"{int(ours['control_vertices']):,}",
                         f"{mark(ours['rms_mesh_to_truth'], verdicts[0], '{:.4f}')} / {mark(ours['rms_truth_to_mesh'], verdicts[1], '{:.4f}')}, "
                         f"{mark(ours['normal_angle'], verdicts[2], '{:.2f}°')}",
                         "yes" if all(verdicts[:2]) else "no",
                         f"{ours['cpu_s']:.1f} / {total(poisson, 'cpu_s'):.1f}"])
    if not body:
        return []
    return ["## A tenth of the vertices, at each accuracy", "",
            f"`gpsrecon --budget` with a tenth of the vertices that {' and '.join(sorted(methods))} has at a depth. Bold where gpsrecon is at",
            "least as accurate; yes where it is in both directions. RMS mesh to truth / truth to mesh in % of the diagonal, mean normal angle.",
            f"Of {count} pairs gpsrecon is at least as accurate from mesh to truth in {wins[0]}, from truth to mesh in {wins[1]}, in its normals in {wins[2]}.", "",
            table(["scan", "depth", "vertices", "Poisson", "gpsrecon's", "gpsrecon", "both ways", "CPU, s"], body)]


def growth_lines(rows, titles):
    body = []
    for row in [r for r in rows if r["part"] == "growth"]:
        size = int(row["scan"].rsplit("@", 1)[1])
        if row["status"] != "ok":
            body.append([f"{size:,}", label(row, titles), row["status"], "", "", ""])
        else:
            body.append([f"{size:,}", label(row, titles), f"{total(row, 'cpu_s'):.2f}", f"{total(row, 'wall_s'):.2f}",
                         f"{peak(row):.0f}", f"{peak(row) * 1e6 / size:.0f}"])
    if not body:
        return []
    ratios = []
    for method in dict.fromkeys(r["method"] for r in rows if r["part"] == "growth"):
        values = [growth_ratio(rows, method, 100_000, 1_000_000, f) for f in (lambda r: total(r, "cpu_s"), peak)]
        if all(values):
            ratios.append(f"{titles[method]} {values[0]:.1f} in processor time and {values[1]:.1f} in memory")
    return ["## Growth", "", f"One surface (`shape:{GROWTH_SHAPE} --quality s1`) with more and more points; normals included. "
            "Below some 10 MB the figures for memory are", "those of the program that measures.", "",
            *(["From 10⁵ to 10⁶ points: " + "; ".join(ratios) + ".", ""] if ratios else []),
            "![Time and memory against the number of points](pictures/benchmark/growth.png)", "",
            table(["points", "", "CPU, s", "wall, s", "memory, MB", "bytes per point"], body)]


def ridge_lines(rows):
    body = [[r["scan"], r["setting"], f"{r['sigma0']:.4f}", f"{r['ridge_mean']:.4f}", f"{r['ridge_median']:.4f}", f"{r['ridge_p95']:.4f}",
             f"{r['ridge_max']:.4f}", f"{100 * r['ridge_lost'] / r['points']:.2f} %"] for r in select(rows, part="ridge")]
    if not body:
        return []
    return ["## Surface and density ridge", "",
            f"{RIDGE_SAMPLES:,} points, uniform by area on the Gaussian-product surface, moved to the ridge of the mixture of the same Gaussians by a",
            "subspace-constrained mean shift (`measure/ridge.h`; Ozertem and Erdogmus 2011). Distances in % of the diagonal, beside the kernel width σ₀;",
            "lost: points that come to no rest, because the ridge has an end or a jump there. Not fitted is the surface of the mixture as the",
            "publication has it; the fit then moves the Gaussians off the ridge on purpose, towards the points.", "",
            table(["scan", "Gaussians", "σ₀", "mean", "median", "95 %", "largest", "lost"], body),
            "![Sections of surface and ridge](pictures/benchmark/ridge.png)", "",
            "Sections through the surface before the fit (black) and where its points come to rest on the ridge (blue; red: lost), where",
            "the two are farthest apart.", ""]


def loss_lines(rows, titles):
    found = losses(rows, titles)
    lines = ["## Where gpsrecon loses", "",
             "Figures of gpsrecon with default options that are worse than those of another method, for Poisson at its most accurate depth.", ""]
    if not found:
        return lines + ["None.", ""]
    form = lambda value, unit: f"{value:.4f} %" if unit == "%" else f"{value:,.0f}" if unit == "" else f"{value:.2f} {unit}"
    rows = [[scan, title, form(ours, unit), form(theirs, unit), label(other, titles)]
            for scan, title, unit, ours, theirs, other in found]
    return lines + [table(["scan", "figure", "gpsrecon", "other", "of"], rows)]


def picture_lines(rows, sweeps):
    if not sweeps:
        return []
    return ["## Errors and effort", "",
            "Shares of the points of a scan by their distance from the surface, and of samples of the surface by their distance from the truth:", "",
            "![Histograms of errors](pictures/benchmark/histograms.png)", "",
            "Processor time against error while the kernel width (`--detail`) and the depth vary; the flags say the peak memory. Left the RMS of the",
            "distances of the points, as the publication has it, which noise and outliers dominate; right the RMS from truth to mesh.", "",
            "![Time against error](pictures/benchmark/effort.png)", ""]


def notes_of(target):
    """What was added to a page by hand, between two marks; it stays there when the page is written again."""
    return (section(target.read_text(), "notes") or "") if target.exists() else ""


def page(rows, machine, methods, notes=""):
    titles = titles_of(rows, methods)
    sweeps = sweep_scans(rows)
    lines = ["# Benchmark", "",
             "Written by `scripts/benchmark.py`, all but the notes. gpsrecon against other reconstructions of the same points, in one run on one machine.",
             "(The programs that time single stages are run by `scripts/benchmark.sh`.)", "",
             "    scripts/benchmark.py --quick    # minutes; into build/benchmark/quick",
             "    scripts/benchmark.py            # about an hour; into build/benchmark/full",
             "    scripts/benchmark.py --publish  # and onto this page", "",
             f"* The {'quick' if machine['quick'] else 'full'} run of {machine['version']}; one run of each reconstruction, seed {SEED}, {machine['threads']} threads; {machine['samples']:,} samples each way.",
             f"* {machine['cpu']}, {machine['cores']} cores, {machine['memory_GB']:.0f} GB; {machine['compiler']}; {machine['system']}.",
             f"* Load of the machine during the measurements: {load_text(rows)}. Under load the wall times say little; processor times are what to compare.",
             "* Methods: " + "; ".join(f"{titles[name]}: {text}" for name, text in methods.items()) + ".",
             "* Normals for Poisson: planes of 18 neighbours (36 for s3), oriented along a minimum spanning tree, by CGAL.",
             "* Processor time, wall time and peak memory of whole processes, from files to files. That of gpsrecon includes its report,",
             "  which measures the distance of every point. Bytes are those of the files as each program writes them: coordinates as float,",
             "  of covariance meshes and Open3D as double.", "",
             "<!-- notes -->", *notes.splitlines(), "<!-- end -->", "",
             *accuracy_lines(rows, titles), *budget_lines(rows, titles), *picture_lines(rows, sweeps),
             *growth_lines(rows, titles), *ridge_lines(rows), *loss_lines(rows, titles)]
    return "\n".join(lines).rstrip() + "\n"


def load_text(rows):
    loads = [row["load"] for row in rows if row["load"] != ""]
    return f"{min(loads):.1f} to {max(loads):.1f}" if loads else "not known"


def sweep_scans(rows):
    return [scan for scan in scan_names(rows, "accuracy")
            if len(select(rows, part="accuracy", scan=scan, method="gpsrecon")) > 1]


# ---------------------------------------------------------------------------------------------------------------------
# Pictures


COLORS = {"gpsrecon": "black", "pcl_poisson": "tab:red", "open3d_poisson": "tab:orange", "PoissonRecon": "tab:purple",
          "cgal_poisson": "tab:blue", "cgal_front": "tab:green"}


def draw(rows, out, pictures, methods):
    """All pictures there is something for."""
    try:
        plt = pyplot({"font.size": 9, "axes.grid": True, "grid.alpha": 0.3, "savefig.dpi": 110, "figure.autolayout": True})
    except ImportError:
        print("benchmark.py: there is no matplotlib (python3-matplotlib), so there are no pictures", file=sys.stderr)
        return
    pictures.mkdir(parents=True, exist_ok=True)
    titles, scans = titles_of(rows, methods), sweep_scans(rows)
    if scans:
        draw_effort(plt, rows, scans, titles, pictures / "effort.png")
        draw_histograms(plt, rows, scans, titles, pictures / "histograms.png")
    if select(rows, part="growth"):
        draw_growth(plt, rows, titles, pictures / "growth.png")
    if select(rows, part="ridge"):
        draw_ridge(plt, rows, out, pictures / "ridge.png")


# Offsets of the flags of consecutive points, so that they do not cover each other.
FLAG_PLACES = ((5, 9), (5, -13), (-34, 12), (-34, -16))


def draw_effort(plt, rows, scans, titles, path):
    """Figure 14a."""
    figure, axes = plt.subplots(len(scans), 2, figsize=(11, 3.8 * len(scans)), squeeze=False)
    for line, scan in zip(axes, scans):
        for axis, key in zip(line, ("self_rms", "rms_truth_to_mesh")):
            for method in titles:
                here = sorted(select(rows, part="accuracy", scan=scan, method=method),
                              key=lambda r: float(r["setting"] or 1))
                if not here:
                    continue
                xs, ys = [r[key] for r in here], [total(r, "cpu_s") for r in here]
                axis.plot(xs, ys, "o-", color=COLORS.get(method), label=titles[method], markersize=4, linewidth=1)
                for k, (x, y, r) in enumerate(zip(xs, ys, here)):
                    setting = r["setting"] or ("1" if method == "gpsrecon" else "")
                    axis.annotate(f"{setting}{': ' if setting else ''}{peak(r):.0f} MB", (x, y), xytext=FLAG_PLACES[k % len(FLAG_PLACES)],
                                  textcoords="offset points", fontsize=6, color=COLORS.get(method),
                                  arrowprops={"arrowstyle": "-", "linestyle": "--", "linewidth": 0.5, "color": COLORS.get(method)})
            axis.set(xscale="log", yscale="log", xlabel="RMS, points to mesh, %" if key == "self_rms" else "RMS, truth to mesh, %",
                     ylabel="processor time, s", title=scan)
            axis.margins(0.22)
        line[0].legend(fontsize=7)
    save(figure, path)


def draw_histograms(plt, rows, scans, titles, path):
    """Figure 13c. Of several Poisson reconstructions the first."""
    poissons = [method for method in titles if method not in ("gpsrecon", "cgal_poisson", "cgal_front")]
    shown = [method for method in titles if method not in poissons[1:]]
    figure, axes = plt.subplots(len(scans), 2, figsize=(11, 3.2 * len(scans)), squeeze=False)
    for line, scan in zip(axes, scans):
        for axis, key, text in zip(line, ("self_histogram", "truth_histogram"), ("points to mesh", "mesh to truth")):
            for method in shown:
                # The advancing front goes through all points: all their distances are 0.
                if method == "cgal_front" and key == "self_histogram":
                    continue
                here = select(rows, part="accuracy", scan=scan, method=method)
                here = [r for r in here if r["setting"] == ""] if method == "gpsrecon" else here
                for k, row in enumerate(here):
                    edges, counts = json.loads(row[key])
                    share = [100 * c / sum(counts) for c in counts]
                    # The first bin has no lower edge and the last no upper one: they get the width of their neighbours.
                    bounds = [100 * e for e in [edges[0] / 2, *edges, edges[-1] * 2]]
                    axis.stairs(share, bounds, color=COLORS.get(method), label=label(row, titles), linewidth=1.8 if method == "gpsrecon" else 1,
                                linestyle=["-", "--", ":", "-."][k % 4])
            axis.set(xscale="log", xlabel=f"distance, {text}, % of the diagonal", ylabel="share, %", title=scan)
            axis.set_xlim(left=5e-4)
        line[1].legend(fontsize=6)
    save(figure, path)


def draw_growth(plt, rows, titles, path):
    figure, axes = plt.subplots(1, 2, figsize=(11, 4))
    for axis, value, text in zip(axes, (lambda r: total(r, "cpu_s"), peak), ("processor time, s", "peak memory, MB")):
        for method in titles:
            here = sorted((int(r["scan"].rsplit("@", 1)[1]), value(r)) for r in select(rows, part="growth", method=method))
            if here:
                axis.plot(*zip(*here), "o-", color=COLORS.get(method), label=titles[method])
        axis.set(xscale="log", yscale="log", xlabel="points", ylabel=text)
        axis.legend(fontsize=8)
    save(figure, path)


def read_ridge(path):
    """Rows of (point of the ridge, point of the surface, arrived) of a file that ridge_of_covmesh wrote."""
    from lab.ply import Ply
    samples = Ply(path)
    surface, (arrived,) = samples.vectors("surface_x", "surface_y", "surface_z"), samples.vectors("arrived").T
    return list(zip(samples.positions, surface, arrived > 0))


def draw_ridge(plt, rows, out, path):
    """Figures 2 and 15: a thin slice, across the second largest extent, through the sample that moved farthest; beside it
    the surroundings of that sample."""
    files = [(row["scan"], out / f"ridge.{row['scan']}.not-fitted.ply")
             for row in select(rows, part="ridge", setting="not fitted")]
    files = [(scan, file) for scan, file in files if file.exists()]
    if not files:
        return
    figure, axes = plt.subplots(len(files), 2, figsize=(11, 4.2 * len(files)), squeeze=False)
    for line, (scan, file) in zip(axes, files):
        samples = read_ridge(file)
        extent = [max(s[1][k] for s in samples) - min(s[1][k] for s in samples) for k in range(3)]
        across = sorted(range(3), key=lambda k: extent[k])[1]
        u, v = [k for k in range(3) if k != across]
        far = max(samples, key=lambda s: sum((a - b) ** 2 for a, b in zip(s[0], s[1])) if s[2] else 0)
        here = [s for s in samples if abs(s[1][across] - far[1][across]) < SLICE * extent[across]]
        arrived, lost = [s for s in here if s[2]], [s for s in here if not s[2]]
        half = 0.06 * max(extent[u], extent[v])
        for axis, size, title in zip(line, (3, 14), (scan, f"{scan}, detail")):
            for s in arrived:
                axis.plot([s[0][u], s[1][u]], [s[0][v], s[1][v]], color="tab:blue", linewidth=0.8)
            axis.scatter([s[1][u] for s in here], [s[1][v] for s in here], s=size, color="black", label="surface", linewidths=0, zorder=2)
            axis.scatter([s[0][u] for s in arrived], [s[0][v] for s in arrived], s=size / 2.5, color="tab:blue", label="ridge",
                         linewidths=0, zorder=3)
            axis.scatter([s[0][u] for s in lost], [s[0][v] for s in lost], s=14, color="tab:red", marker="x", label="lost", linewidths=1)
            axis.set_aspect("equal")
            axis.set_title(title)
        line[1].set(xlim=(far[1][u] - half, far[1][u] + half), ylim=(far[1][v] - half, far[1][v] + half))
        line[1].legend(fontsize=7)
    save(figure, path)


def write_page(out, target, rows, machine, methods):
    """The page as a file, its pictures beside it."""
    target.parent.mkdir(parents=True, exist_ok=True)
    draw(rows, out, target.parent / "pictures/benchmark", methods)
    target.write_text(page(rows, machine, methods, notes_of(target)))
    print(f"wrote {target}")
