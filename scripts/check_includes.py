#!/usr/bin/env python3
"""Checks what the sources include: directions, cycles, own header first, and what is public.

    scripts/check_includes.py          # exit code 1 and a list if something is wrong
    scripts/check_includes.py --fix    # moves own headers to the top

Dependencies point one way, cli -> pipeline -> stages -> core (CONTRIBUTING.md); every folder of lib but core and pipeline is a
stage. No header includes itself, by whatever way. A source starts with the header of its name, so that each header is compiled
once with nothing before it. A header that cmake/install.cmake does not list is internal: it declares nothing in namespace
gpsrecon itself, and none that is listed includes it.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
INCLUDE = re.compile(r'^\s*#\s*include\s*(<gpsrecon/[^>]+>|"[^"]+"|<[^>]+>)', re.MULTILINE)

# What a stage may include of others, beside core.
EXCEPTIONS = {
    "fit": {"gps"},  # fitting evaluates and refines the surface
    "report": {"fit", "hem", "measure", "triangulate"},  # a report holds what the stages say of themselves
}
# Internal headers that define a class nested in a public one.
MEMBERS_OF_PUBLIC = {"evaluate_data.h"}


def may_include(folder):
    """Folders that a folder may include, itself among them."""
    stages = {path.name for path in (ROOT / "lib").iterdir() if path.is_dir()} - {"core", "pipeline"}
    below = {"core": set(), "pipeline": {"core"} | stages, "cli": {"core", "pipeline"} | stages}
    return {folder} | below.get(folder, {"core"} | EXCEPTIONS.get(folder, set()))


def folder_of(path):
    """The folder that a file counts as: cli, or its own one in lib."""
    parts = path.relative_to(ROOT).parts
    return parts[1] if parts[0] == "lib" else parts[0]


def included_files(path):
    """Files of the project that one includes, in order; None for each header of the system."""
    for word in INCLUDE.findall(path.read_text()):
        if word.startswith("<gpsrecon/"):
            yield ROOT / "lib" / word.removeprefix("<gpsrecon/")[:-1]
        elif word.startswith('"'):
            yield (path.parent / word.strip('"')).resolve()
        else:
            yield None


def put_own_header_first(path, own):
    lines = path.read_text().splitlines(keepends=True)
    at, line = next((at, line) for at, line in enumerate(lines)
                    if (word := INCLUDE.match(line)) and word[1].strip('<>"').split("/")[-1] == own.name)
    del lines[at]
    while lines[0] == "\n":
        del lines[0]
    first = next(at for at, other in enumerate(lines) if INCLUDE.match(other))
    lines[first:first] = [line, "\n"]
    path.write_text("".join(lines))


def public_headers():
    listed = re.search(r"set\(GPSRECON_PUBLIC_HEADERS(.*?)\)", (ROOT / "cmake/install.cmake").read_text(), re.DOTALL)
    return {ROOT / "lib" / name for name in listed[1].split()}


def faults_of_interface(graph, public):
    """Headers that mix what callers may use with what they may not."""
    for path in sorted(public - graph.keys()):
        yield f"{path.relative_to(ROOT)}, which cmake/install.cmake lists, is not there"
    for path in graph:
        if path.suffix != ".h" or folder_of(path) == "cli":
            continue
        name = path.relative_to(ROOT)
        if path in public:
            for other in graph[path]:
                if other not in public:
                    yield f"{name} is public and includes {other.relative_to(ROOT)}, which is not"
        elif re.search(r"^namespace gpsrecon {", path.read_text(), re.MULTILINE) and name.name not in MEMBERS_OF_PUBLIC:
            yield f"{name} is internal but not in namespace gpsrecon::internal"


def find_cycle(graph):
    """Files that include each other in a ring, or nothing."""
    done, trail = set(), []

    def visit(path):
        if path in trail:
            return trail[trail.index(path):] + [path]
        if path in done:
            return []
        trail.append(path)
        for other in graph.get(path, ()):
            if cycle := visit(other):
                return cycle
        done.add(trail.pop())
        return []

    return next((cycle for path in graph if (cycle := visit(path))), [])


def main():
    fix = sys.argv[1:] == ["--fix"]
    if sys.argv[1:] and not fix:
        raise SystemExit(__doc__)
    sources = sorted(path for folder in ("lib", "cli") for path in (ROOT / folder).rglob("*")
                     if path.suffix in (".h", ".cpp"))
    faults, graph = [], {}
    for path in sources:
        included = list(included_files(path))
        graph[path] = [other for other in included if other]
        here, name = folder_of(path), path.relative_to(ROOT)
        for other in graph[path]:
            if not other.is_file():
                faults.append(f"{name} includes {other.relative_to(ROOT)}, which is not there")
            elif folder_of(other) not in may_include(here):
                faults.append(f"{name} includes {other.relative_to(ROOT)}: {here} must not know {folder_of(other)}")
        own = path.with_suffix(".h")
        if path.suffix == ".cpp" and own.is_file() and included[:1] != [own]:
            if fix and own in included:
                put_own_header_first(path, own)
            else:
                faults.append(f"{name} does not include its own header first")
    faults += faults_of_interface(graph, public_headers())
    if cycle := find_cycle(graph):
        faults.append("a cycle: " + " -> ".join(str(path.relative_to(ROOT)) for path in cycle))
    for fault in faults:
        print(fault, file=sys.stderr)
    print(f"{len(sources)} files, {sum(map(len, graph.values()))} inclusions of each other, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
