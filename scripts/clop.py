#!/usr/bin/python3
"""Measures projections with the program projection_lab and writes the tables and pictures of docs/evidence/projection.md.

    scripts/clop.py --lab build/release/bin/projection_lab --data DIR [--program build/release/bin/gpsrecon]
                    [--parts NAME,...] [--quick] [--page docs/evidence/projection.md]

DIR holds scans/NAME.sN.ply and truth/NAME.ply. Build the program with scripts/build.sh
-DGPSRECON_BUILD_BENCHMARKS=ON projection_lab. Without --page nothing is written. With --quick little is measured, to
see that it works. Needs meshio, and matplotlib for the pictures.

Exit codes: 0 done, 2 usage, 3 a program failed, or the page has no place for a table.
"""

import argparse
import io
import json
import math
import statistics
import sys
import tempfile
from pathlib import Path

from lab.pages import replace_sections, table
from lab.pictures import pyplot, save
from lab.ply import Ply
from lab.runner import ROOT, Gpsrecon, exit_code_of, output_of

sys.path.insert(0, str(ROOT / 'datasets'))
import image_points  # noqa: E402

SHAPES = ['nefertiti', 'koala', 'hammer', 'spot']
BLUE, ORANGE, GREEN, GRAY = '#31688e', '#d95f02', '#1b9e77', '#999999'


class Lab:
    def __init__(self, program, data):
        self.program, self.data = program, data

    def run(self, scan, **settings):
        return self.run_on(self.data / 'scans' / f'{scan}.ply', self.data / 'truth' / f'{scan[:-3]}.ply', **settings)

    def run_on(self, points, truth, **settings):
        words = [self.program, points, 'truth', truth]
        for name, value in settings.items():
            words += [name, value]
        return json.loads(output_of(words))


class Bench:
    """What the parts share, and how much they do."""

    def __init__(self, lab, program, particles, quick):
        self.lab, self.program, self.particles, self.quick = lab, program, particles, quick
        self.shapes = SHAPES[1:2] if quick else SHAPES


def errors(run):
    e = run['errors']
    return f"{e['mean_percent']:.4f} / {e['median_percent']:.4f} / {e['signed_mean_percent']:+.4f}"


# Every part returns its table and how to draw its pictures, by name.


def accuracy(bench):
    """Distances from the truth, mean / median / signed mean in % of the diagonal."""
    rows, runs = [], {}
    for grade in ('s1', 's2', 's3'):
        for shape in bench.shapes:
            scan = f'{shape}.{grade}'
            none, clop, wlop = (bench.lab.run(scan, method=m, count=bench.particles) for m in ('none', 'clop', 'wlop'))
            runs[scan] = none, clop, wlop
            rows.append([scan, errors(none), errors(clop), errors(wlop),
                         f"{clop['errors']['mean_percent'] / wlop['errors']['mean_percent']:.2f}"])
    return table(['scan', 'points', 'CLOP', 'WLOP', 'CLOP / WLOP'], rows), {'clop.svg': lambda: draw_accuracy(runs)}


def draw_accuracy(runs):
    shape = next(iter(runs)).split('.')[0]
    figure, axes = pyplot().subplots(1, 2, figsize=(9, 3.2), constrained_layout=True)
    for axis, scan in zip(axes, (f'{shape}.s2', f'{shape}.s3')):
        for name, run, color in zip(('points', 'CLOP', 'WLOP'), runs[scan], (GRAY, BLUE, ORANGE)):
            density, limit = run['errors']['density_per_percent'], run['errors']['density_limit_percent']
            n = len(density)
            axis.plot([limit * (2 * (i + 0.5) / n - 1) for i in range(n)], density, color=color, label=name)
        axis.set(xlabel='signed distance, % of the diagonal', ylabel='density', title=scan)
    axes[0].legend(frameon=False)
    return figure


def compression(bench):
    rows = []
    for alpha in (1, 2, 3):
        for levels in (1, 2, 3, 5):
            run = bench.lab.run('koala.s2', method='clop', count=bench.particles, alpha=alpha, levels=levels)
            rows.append([str(alpha), str(levels), f"{run['attracting'] / run['points']:.3f}",
                         f"{run['errors']['mean_percent']:.4f}", f"{run['irregularity']:.3f}",
                         f"{run['cpu_s']['mixture']:.1f} + {run['cpu_s']['project']:.1f}"])
    return table(['α', 'levels', 'Gaussians / points', 'mean error, %', 'irregularity', 'CPU s'], rows), {}


INTERVALS = {'in every iteration': 1, 'in every second': 2, 'in every fourth': 4}


def repulsion(bench):
    rows = []
    for name, interval in INTERVALS.items():
        run = bench.lab.run('koala.s2', method='clop', count=bench.particles, interval=interval, split=1)
        rows.append([name, f"{run['irregularity']:.3f}", f"{run['errors']['mean_percent']:.4f}",
                     f"{run['cpu_s']['attraction']:.2f}",
                     f"{max(0.0, run['cpu_s']['project'] - run['cpu_s']['attraction']):.2f}"])
    return table(['repulsion recomputed', 'irregularity', 'mean error, %', 'CPU s of the attraction',
                  'and of the repulsion'], rows), {}


def coherence(bench):
    """Per iteration, how even the particles are and how much their repulsion changes."""
    counts = bench.particles, 3 * bench.particles // 10
    series = {(count, name): bench.lab.run('koala.s2', method='clop', count=count, interval=interval, series=1)['series']
              for count in counts for name, interval in INTERVALS.items() if count == counts[0] or interval < 4}
    rows = []
    for (count, name), entries in series.items():
        if name == 'in every fourth':
            continue
        change = {e['iteration']: e['coherence'] for e in entries if 'coherence' in e}
        last = max(change)
        shown = 2, 3, 8, 9, last - 2, last
        rows.append([f'{count:,}', name] + [f'{change[k][2]:.2f} ({change[k][1]:.2f} to {change[k][3]:.2f})' for k in shown] +
                    [f"{entries[-1]['irregularity']:.3f}"])
    head = ['particles', 'repulsion recomputed', *(f'ΔR after iteration {k}' for k in shown), 'irregularity']
    return table(head, rows), {'clop-repulsion.svg': lambda: draw_coherence(series, counts)}


def draw_coherence(series, counts):
    figure, axes = pyplot().subplots(1, 3, figsize=(11, 3.2), constrained_layout=True)
    colors = dict(zip(INTERVALS, (BLUE, ORANGE, GREEN)))
    for (count, name), entries in series.items():
        first = count == counts[0]
        axes[0].plot([e['iteration'] for e in entries], [e['irregularity'] for e in entries], color=colors[name],
                     linestyle='-' if first else '--', label=name if first else None)
    axes[0].set(xlabel='iteration', ylabel='irregularity')
    axes[0].set_title(f'solid: {counts[0]:,}, dashed: {counts[1]:,} particles', fontsize=10)
    axes[0].legend(frameon=False, title='repulsion recomputed')
    for axis, count in zip(axes[1:], counts):
        for name in list(colors)[:2]:
            entries = [e for e in series[count, name] if 'coherence' in e]
            iterations = [e['iteration'] for e in entries]
            axis.plot(iterations, [e['coherence'][2] for e in entries], color=colors[name], label=name)
            axis.fill_between(iterations, [e['coherence'][1] for e in entries], [e['coherence'][3] for e in entries],
                              color=colors[name], alpha=0.2, linewidth=0)
        axis.set(xlabel='iteration', ylabel='ΔR, median and quartiles', ylim=(0, None))
        axis.set_title(f'{count:,} particles', fontsize=10)
    for axis in axes:
        axis.set_xticks(range(1, 16, 2))
    return figure


def ripple(bench):
    """A train of waves with rising noise, all points projected."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for noise in (0.0005, 0.001, 0.002, 0.004):
            scan = Path(folder) / 'ripple.ply'
            Gpsrecon(bench.program).run('scan', 'shape:ripple', scan, '--points', 3000 if bench.quick else 40000,
                                        '--noise', f'{100 * noise:g}%')
            runs = [bench.lab.run_on(scan, 'shape:ripple', method=m) for m in ('none', 'clop', 'wlop')]
            rows.append([f'{100 * noise:g} %', f"{100 * runs[1]['h_rel']:.1f} %"] + [errors(run) for run in runs])
    return table(['noise', 'h', 'points', 'CLOP', 'WLOP'], rows), {}


def upsampling(bench):
    rows = []
    for ratio in (0.2, 1, 5):
        run = bench.lab.run('koala.s3', method='clop', ratio=ratio)
        rows.append([f'{100 * ratio:.0f} %', f"{run['particles']:,}", f"{run['irregularity']:.3f}",
                     f"{run['errors']['mean_percent']:.4f}"])
    return table(['particles', 'number', 'irregularity', 'mean error, %'], rows), {}


def speed(bench):
    scan, count = ('koala.s2', bench.particles) if bench.quick else ('nefertiti.s1', 100000)
    clop = bench.lab.run(scan, method='clop', count=count, iterations=15, split=1)
    wlop = bench.lab.run(scan, method='wlop', count=count, iterations=15, interval=1, cutoff=1, split=1)

    def row(name, run):
        c = run['cpu_s']
        mixture = c.get('mixture', 0)
        return [name, f"{mixture:.1f}", f"{c['attraction']:.1f}", f"{max(0.0, c['project'] - c['attraction']):.1f}",
                f"{mixture + c['project']:.1f}",
                f"{run['peak_memory_bytes'] / (run['points'] + run['particles']):.0f} B",
                f"{run['errors']['mean_percent']:.4f}"]

    total = wlop['cpu_s']['project'] / (clop['cpu_s']['mixture'] + clop['cpu_s']['project'])
    attraction = wlop['cpu_s']['attraction'] / clop['cpu_s']['attraction']
    rows = [row('CLOP, repulsion in every second iteration, up to h/2', clop),
            row('WLOP, repulsion in every iteration, up to h', wlop),
            ['WLOP / CLOP', '', f'{attraction:.1f}', '', f'{total:.1f}', '', '']]
    head = ['', 'mixture', 'attraction', 'repulsion', 'total', 'memory per point + particle', 'mean error, %']
    return table(head, rows), {}


SHARES = 0.5, 0.25, 0.1, 0.05
ALPHAS = 2, 2.5, 3  # the first that compresses enough


def subsample(bench):
    """WLOP on some of the points, CLOP on as many Gaussians."""
    rows, runs = [], {}
    for scan in [s for s in ('koala.s2', 'nefertiti.s2') if s.split('.')[0] in bench.shapes]:
        points = bench.lab.run(scan, method='none')['particles']
        for count in (bench.particles, points):
            whole = bench.lab.run(scan, method='wlop', count=count)
            runs[scan, count] = [(1, None, whole, whole)]
            for share in SHARES:
                for alpha in ALPHAS:
                    wanted = {'method': 'clop', 'components': round(share * points), 'alpha': alpha}
                    if bench.lab.run(scan, **wanted, count=1, iterations=1)['attracting'] <= 1.02 * share * points:
                        break
                clop = bench.lab.run(scan, **wanted, count=count)
                runs[scan, count].append((share, clop, *(
                    bench.lab.run(scan, method='wlop', subsample=share, widen=widen, count=count) for widen in (0, 1))))
            for share, clop, same, wide in runs[scan, count]:
                rows.append([scan, f'{count:,}', f'{100 * share:g} %', describe(clop) if clop else '', describe(same),
                             describe(wide) if share < 1 else ''])
    return (table(['scan', 'particles', 'of the points', 'CLOP', 'WLOP, same h', 'WLOP, wider h'], rows),
            {'clop-subsample.svg': lambda: draw_subsample(runs)})


def seconds(run):
    return run['cpu_s'].get('mixture', 0) + run['cpu_s']['project']


def describe(run):
    return f"{run['errors']['mean_percent']:.4f} / {run['irregularity']:.2f} / {seconds(run):.1f}"


def draw_subsample(runs):
    figure, axes = pyplot().subplots(1, 3, figsize=(11, 3.6), constrained_layout=True)
    most = max(count for _, count in runs)
    for (scan, count), entries in runs.items():
        if count < 0.9 * most:
            continue
        first = scan == next(iter(runs))[0]
        for k, (name, color) in enumerate((('CLOP', BLUE), ('WLOP, same h', ORANGE), ('WLOP, wider h', GREEN)), 1):
            shown = [(100 * e[0], e[k]) for e in entries if e[k]]
            shares = [share for share, _ in shown]
            error = [run['errors']['mean_percent'] for _, run in shown]
            settings = {'color': color, 'linestyle': '-' if first else '--', 'marker': 'o', 'markersize': 4,
                        'label': name if first else None}
            axes[0].plot(shares, error, **settings)
            axes[1].plot([seconds(run) for _, run in shown], error, **settings)
            axes[2].plot(shares, [run['irregularity'] for _, run in shown], **settings)
    number = 'Gaussians or points, % of all points'
    axes[0].set(xscale='log', xlabel=number, ylabel='mean error, %', ylim=(0, None))
    axes[1].set(xscale='log', xlabel='CPU s', ylabel='mean error, %', ylim=(0, None))
    scans = list(dict.fromkeys(scan for scan, _ in runs))
    axes[1].set_title(', '.join(f'{line} {scan}' for line, scan in zip(('solid:', 'dashed:'), scans)), fontsize=10)
    axes[2].set(xscale='log', yscale='log', xlabel=number, ylabel='irregularity')
    shares = [5, 10, 25, 50, 100]
    axes[0].set_xticks(shares, shares)
    axes[1].set_xticks([10, 20, 50, 100], [10, 20, 50, 100])
    axes[2].set_xticks(shares, shares)
    axes[2].set_yticks([0.25, 0.5, 1, 2, 4], [0.25, 0.5, 1, 2, 4])
    for axis in axes:
        axis.minorticks_off()
    axes[2].legend(frameon=False)
    return figure


MARGIN, CELLS = 0.04, 12  # particles shy away from the border, which therefore does not count


def cells_of(points):
    """How many points there are in every cell of a grid on the unit square without its margin."""
    counts = [0] * (CELLS * CELLS)
    for x, y in points:
        column, row = (math.floor((v - MARGIN) / (1 - 2 * MARGIN) * CELLS) for v in (x, y))
        if column in range(CELLS) and row in range(CELLS):
            counts[row * CELLS + column] += 1
    return counts


def darkness_of(picture):
    """Its mean in these cells."""
    step = (1 - 2 * MARGIN) / CELLS
    places = [MARGIN + (k + 0.5) * step / 8 for k in range(8 * CELLS)]
    sums = [0.0] * (CELLS * CELLS)
    for j, y in enumerate(places):
        for i, x in enumerate(places):
            sums[j // 8 * CELLS + i // 8] += picture(x, y) / 64
    return sums


def likeness(counts, darkness):
    """Of particles to a picture: density in the darkest quarter over that in the lightest; correlation; and their
    standard deviation from an even density."""
    order = sorted(range(len(darkness)), key=lambda k: darkness[k])
    quarter = len(order) // 4
    contrast = sum(counts[k] for k in order[-quarter:]) / max(1, sum(counts[k] for k in order[:quarter]))
    mean_count, mean_darkness = statistics.fmean(counts), statistics.fmean(darkness)
    covariance = statistics.fmean((c - mean_count) * (d - mean_darkness) for c, d in zip(counts, darkness))
    deviation = statistics.pstdev(counts)
    return contrast, covariance / (deviation * statistics.pstdev(darkness)), deviation / mean_count


def density(bench):
    """Particles on points whose density is a picture, with and without the weights that balance it."""
    points, count, short, long = (5000, 250, 5, 10) if bench.quick else (74000, 3700, 50, 400)
    cases = [('points, not projected', 'none', 1, 1), ('LOP', 'wlop', 0, short), ('WLOP', 'wlop', 1, short),
             ('CLOP, not balanced', 'clop', 0, short), ('CLOP, balanced', 'clop', 1, short),
             ('CLOP, not balanced', 'clop', 0, long), ('CLOP, balanced', 'clop', 1, long)]
    rows, shown = [], {}
    with tempfile.TemporaryDirectory() as folder:
        cloud, out = Path(folder) / 'points.xyz', Path(folder) / 'particles.ply'
        for title, picture in image_points.PICTURES.items():
            drawn = image_points.points_of(picture, points, 1)
            image_points.write_xyz(drawn, cloud)
            shown[title, 'points'] = drawn
            darkness = darkness_of(picture)
            contrast, correlation, unevenness = likeness(darkness, darkness)
            rows.append([title, 'the picture', '', f'{contrast:.2f}', f'{correlation:.2f}', f'{unevenness:.2f}', ''])
            for name, method, balance, iterations in cases:
                figures = []
                for uniform in (0, 1):
                    run = bench.lab.run_on(cloud, '', method=method, balance=balance, count=count, uniform=uniform,
                                           iterations=iterations, h_factor=4, out=out)
                    particles = Ply(out).positions[:, :2]
                    figures.append([*likeness(cells_of(particles), darkness), run['irregularity']])
                    shown[title, method, balance, iterations, uniform] = particles
                rows.append([title, name, str(iterations) if method != 'none' else ''] +
                            [f'{a:.2f} / {b:.2f}' for a, b in zip(*figures)])
    head = ['picture', 'particles', 'iterations', 'contrast', 'correlation', 'unevenness', 'irregularity']
    return table(head, rows), {'clop-density.png': lambda: draw_density(shown, short, long)}


def draw_density(shown, short, long):
    figure, axes = pyplot().subplots(2, 5, figsize=(13, 5.6), constrained_layout=True)
    for row, balance in enumerate((0, 1)):
        source = ('portrait', 'gradient')[row]
        panels = [(f'{source}: points', (source, 'points')),
                  (f"portrait: {('LOP', 'WLOP')[balance]}, {short} iterations", ('portrait', 'wlop', balance, short, 0))]
        for title, iterations in (('portrait', short), ('portrait', long), ('gradient', long)):
            name = f"{title}: CLOP, {'' if balance else 'not '}balanced, {iterations}"
            panels.append((name, (title, 'clop', balance, iterations, 0)))
        for axis, (title, key) in zip(axes[row], panels):
            axis.scatter(*zip(*shown[key]), s=0.15 if key[1] == 'points' else 1.6, color='black', linewidths=0)
            axis.set_title(title, fontsize=9)
            axis.set(aspect='equal', xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[])
    return figure


PARTS = {part.__name__: part for part in
         (accuracy, compression, repulsion, coherence, upsampling, ripple, speed, subsample, density)}


def save_picture(figure, path):
    if path.suffix == '.svg':
        save(figure, path)
        return
    from PIL import Image
    whole = io.BytesIO()
    figure.savefig(whole, format='png', dpi=85)
    # Sixteen greys: dots do not compress well.
    Image.open(whole).convert('L').quantize(16).save(path, optimize=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--lab', type=Path, required=True)
    parser.add_argument('--data', type=Path, required=True)
    parser.add_argument('--program', type=Path, help='gpsrecon, for the scans of the ripple')
    parser.add_argument('--parts', help='of ' + ', '.join(PARTS) + '; by default all')
    parser.add_argument('--particles', type=int, default=30000)
    parser.add_argument('--quick', action='store_true')
    parser.add_argument('--page', type=Path, help='its tables are replaced, and the pictures beside it')
    arguments = parser.parse_args()
    names = arguments.parts.split(',') if arguments.parts else [n for n in PARTS if n != 'ripple' or arguments.program]
    if unknown := [name for name in names if name not in PARTS]:
        parser.error(f"unknown parts: {', '.join(unknown)}")
    if 'ripple' in names and not arguments.program:
        parser.error('the part ripple needs --program')
    bench = Bench(Lab(arguments.lab, arguments.data), arguments.program, arguments.particles, arguments.quick)
    for name in names:
        text, pictures = PARTS[name](bench)
        print(name, text, sep='\n', flush=True)
        if not arguments.page:
            continue
        replace_sections(arguments.page, {name: text})
        for picture, draw in pictures.items():
            folder = arguments.page.parent / 'pictures'
            folder.mkdir(exist_ok=True)
            save_picture(draw(), folder / picture)
    return 0


if __name__ == '__main__':
    sys.exit(exit_code_of(main))
