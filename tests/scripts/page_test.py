#!/usr/bin/env python3
"""Opens report pages in headless Chromium: page_test.py PROGRAM. Exits with 77 (skipped) where there is no Chromium."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77


def dom_of(browser, page, *options):
    """The page as it is after its scripts have run, and what they complained about."""
    with tempfile.TemporaryDirectory() as profile:
        run = subprocess.run(
            [browser, '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
             '--disable-background-networking', '--disable-component-update', '--disable-sync',
             '--enable-logging=stderr', '--virtual-time-budget=10000', f'--user-data-dir={profile}', *options,
             '--dump-dom', page.as_uri()],
            capture_output=True, text=True, timeout=240)
    return run.stdout, [line for line in run.stderr.splitlines() if 'CONSOLE' in line]


def main():
    browser = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
    if browser is None:
        print('skipped: no Chromium')
        return SKIPPED
    program = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        scan, surface, page = folder / 'a <i>scan.ply', folder / 'surface.ply', folder / 'page.html'
        subprocess.run([program, 'scan', 'shape:torus', scan, '--points', '4000', '--quiet'], check=True)
        subprocess.run([program, scan, surface, '--html', page, '--quiet'], check=True)

        dom, complaints = dom_of(browser, page, '--use-angle=swiftshader', '--enable-unsafe-swiftshader')
        assert 'data-view="interactive"' in dom, complaints
        assert '<canvas' in dom and 'data:image/bmp' not in dom
        assert not [c for c in complaints if 'Error' in c], complaints
        assert 'a &lt;i&gt;scan.ply' in dom
        for part in ('points to surface', 'Euler number', 'consistency, not accuracy', 'sample spacing'):
            assert part in dom, part
        assert len(re.findall('<rect', dom)) > 64 and '<polyline' in dom

        dom, _ = dom_of(browser, page, '--disable-3d-apis')
        assert 'data-view="picture"' in dom
        assert 'data:image/bmp' in dom and '<canvas' not in dom
        assert 'this browser shows no 3-D graphics' in dom
    print('passed')
    return 0


if __name__ == '__main__':
    sys.exit(main())
