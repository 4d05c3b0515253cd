#!/usr/bin/python3
"""Measures projections with the program projection_lab and writes the tables and pictures of docs/clop.md.

    scripts/clop.py --lab build/release/bin/projection_lab --data DIR [--program build/release/bin/gpsrecon]
                    [--quick] [--page docs/clop.md]

DIR holds scans/NAME.sN.ply and truth/NAME.ply. Build the program with scripts/build.sh
-DGPSRECON_BUILD_BENCHMARKS=ON projection_lab. With --quick only one shape is measured, and nothing is written.
"""

import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile

SHAPES = ['nefertiti', 'koala', 'hammer', 'spot']
PARTICLES = 30000


class Lab:
    def __init__(self, program, data):
        self.program, self.data = program, data

    def run(self, scan, **settings):
        return self.run_on(self.data / 'scans' / f'{scan}.ply', self.data / 'truth' / f'{scan[:-3]}.ply', **settings)

    def run_on(self, points, truth, **settings):
        words = [self.program, points, 'truth', truth]
        for name, value in settings.items():
            words += [name, value]
        result = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=True)
        return json.loads(result.stdout)


def table(head, rows):
    lines = ['| ' + ' | '.join(head) + ' |', '|' + '---|' * len(head)]
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n'


def errors(run):
    e = run['errors']
    return f"{e['mean_percent']:.4f} / {e['median_percent']:.4f} / {e['signed_mean_percent']:+.4f}"


def accuracy(lab, shapes):
    """Distances from the truth, mean / median / signed mean in % of the diagonal."""
    rows, runs = [], {}
    for grade in ('s1', 's2', 's3'):
        for shape in shapes:
            scan = f'{shape}.{grade}'
            none, clop, wlop = (lab.run(scan, method=m, count=PARTICLES) for m in ('none', 'clop', 'wlop'))
            runs[scan] = none, clop, wlop
            rows.append([scan, errors(none), errors(clop), errors(wlop),
                         f"{clop['errors']['mean_percent'] / wlop['errors']['mean_percent']:.2f}"])
    return table(['scan', 'points', 'CLOP', 'WLOP', 'CLOP / WLOP'], rows), runs


def compression(lab, shape):
    rows = []
    for alpha in (1, 2, 3):
        for levels in (1, 2, 3, 5):
            run = lab.run(f'{shape}.s2', method='clop', count=PARTICLES, alpha=alpha, levels=levels)
            rows.append([str(alpha), str(levels), f"{run['components'] / run['points']:.3f}",
                         f"{run['errors']['mean_percent']:.4f}", f"{run['irregularity']:.3f}",
                         f"{run['cpu_s']['mixture']:.1f} + {run['cpu_s']['project']:.1f}"])
    return table(['α', 'levels', 'Gaussians / points', 'mean error, %', 'irregularity', 'CPU s'], rows)


def repulsion(lab, shape):
    rows, series = [], {}
    for name, interval in (('in every iteration', 1), ('in every second', 2), ('in every fourth', 4)):
        run = lab.run(f'{shape}.s2', method='clop', count=PARTICLES, interval=interval, split=1, series=1)
        series[name] = run['series']
        rows.append([name, f"{run['irregularity']:.3f}", f"{run['errors']['mean_percent']:.4f}",
                     f"{run['cpu_s']['attraction']:.2f}",
                     f"{max(0.0, run['cpu_s']['project'] - run['cpu_s']['attraction']):.2f}"])
    return table(['repulsion recomputed', 'irregularity', 'mean error, %', 'CPU s of the attraction',
                  'and of the repulsion'], rows), series


def ripple(lab, program):
    """A train of waves with rising noise, all points projected."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for noise in (0.0005, 0.001, 0.002, 0.004):
            scan = pathlib.Path(folder) / 'ripple.ply'
            subprocess.run([program, 'scan', 'shape:ripple', scan, '--points', '40000', '--noise-rel', str(noise), '--quiet'],
                           check=True)
            runs = [lab.run_on(scan, 'shape:ripple', method=m) for m in ('none', 'clop', 'wlop')]
            rows.append([f'{100 * noise:g} %', f"{100 * runs[1]['h_rel']:.1f} %"] + [errors(run) for run in runs])
    return table(['noise', 'h', 'points', 'CLOP', 'WLOP'], rows)


def upsampling(lab, shape):
    rows = []
    for ratio in (0.2, 1, 5):
        run = lab.run(f'{shape}.s3', method='clop', ratio=ratio)
        rows.append([f'{100 * ratio:.0f} %', f"{run['particles']:,}", f"{run['irregularity']:.3f}",
                     f"{run['errors']['mean_percent']:.4f}"])
    return table(['particles', 'number', 'irregularity', 'mean error, %'], rows)


def speed(lab, scan, count):
    clop = lab.run(scan, method='clop', count=count, iterations=15, split=1)
    wlop = lab.run(scan, method='wlop', count=count, iterations=15, interval=1, cutoff=1, split=1)

    def row(name, run):
        c = run['cpu_s']
        mixture = c.get('mixture', 0)
        return [name, f"{mixture:.1f}", f"{c['attraction']:.1f}", f"{max(0.0, c['project'] - c['attraction']):.1f}",
                f"{mixture + c['project']:.1f}",
                f"{run['peak_memory_bytes'] / (run['points'] + run['particles']):.0f} B",
                f"{run['errors']['mean_percent']:.4f}"]

    total = wlop['cpu_s']['project'] / (clop['cpu_s']['mixture'] + clop['cpu_s']['project'])
    attraction = wlop['cpu_s']['attraction'] / clop['cpu_s']['attraction']
    rows = [row('CLOP, repulsion in every second iteration, up to h/2', clop), row('WLOP, repulsion in every iteration, up to h', wlop),
            ['WLOP / CLOP', '', f'{attraction:.1f}', '', f'{total:.1f}', '', '']]
    return table(['', 'mixture', 'attraction', 'repulsion', 'total', 'memory per point + particle', 'mean error, %'], rows)


def plots(folder, runs, series):
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    matplotlib.rcParams['svg.hashsalt'] = 'clop'
    figure, axes = pyplot.subplots(1, 2, figsize=(9, 3.2), constrained_layout=True)
    scan = next(s for s in runs if s.endswith('s3'))
    for name, run, color in zip(('points', 'CLOP', 'WLOP'), runs[scan], ('#999999', '#31688e', '#d95f02')):
        density, limit = run['errors']['density_per_percent'], run['errors']['density_limit_percent']
        n = len(density)
        axes[0].plot([limit * (2 * (i + 0.5) / n - 1) for i in range(n)], density, color=color, label=name)
    axes[0].set(xlabel='signed distance, % of the diagonal', ylabel='density', title=scan)
    axes[0].legend(frameon=False)
    for name, color in zip(series, ('#31688e', '#d95f02', '#1b9e77')):
        axes[1].plot([e['iteration'] for e in series[name]], [e['irregularity'] for e in series[name]], color=color, label=name)
    axes[1].set(xlabel='iteration', ylabel='irregularity', title='repulsion recomputed')
    axes[1].legend(frameon=False)
    figure.savefig(folder / 'clop.svg', metadata={'Date': None})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--lab', type=pathlib.Path, required=True)
    parser.add_argument('--data', type=pathlib.Path, required=True)
    parser.add_argument('--program', type=pathlib.Path, help='gpsrecon, for the scans of the ripple')
    parser.add_argument('--quick', action='store_true')
    parser.add_argument('--page', type=pathlib.Path)
    arguments = parser.parse_args()
    lab = Lab(arguments.lab, arguments.data)
    shapes = SHAPES[1:2] if arguments.quick else SHAPES
    tables = {}
    tables['accuracy'], runs = accuracy(lab, shapes)
    tables['compression'] = compression(lab, 'koala')
    tables['repulsion'], series = repulsion(lab, 'koala')
    tables['upsampling'] = upsampling(lab, 'koala')
    if arguments.program:
        tables['ripple'] = ripple(lab, arguments.program)
    tables['speed'] = speed(lab, 'koala.s2' if arguments.quick else 'nefertiti.s1', PARTICLES if arguments.quick else 100000)
    for name, text in tables.items():
        print(name, text, sep='\n')
    if arguments.quick or not arguments.page:
        return 0
    page = arguments.page.read_text()
    for name, text in tables.items():
        page, count = re.subn(f'(<!-- {name} -->\n).*?(<!-- end -->)', lambda m: m[1] + text + m[2], page, flags=re.S)
        if count != 1:
            sys.exit(f'{arguments.page}: has no place for the table {name}')
    arguments.page.write_text(page)
    plots(arguments.page.parent / 'pictures', runs, series)
    return 0


if __name__ == '__main__':
    sys.exit(main())
