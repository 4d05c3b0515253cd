#!/usr/bin/env python3
"""Writes the tables of options of the command line's manual from what the program says of them.

A table stands after <!-- options of COMMAND: GROUP --> or, with all groups but those of every command, after
<!-- options of COMMAND -->; the chain is called so. With --check nothing is written, and the exit code is 1 where the
page is not up to date.
"""

import argparse
import re
import sys
from pathlib import Path

from lab.pages import replace_sections, section
from lab.runner import GPSRECON, ROOT, Gpsrecon

EVERYWHERE = "Options of every command"
MARKER = re.compile(r"^<!-- (options of ([a-z]+|the chain)(?:: (.*))?) -->$", re.M)


def groups_of(program, command):
    """The tables of a command by title, as text."""
    words = [] if command == "the chain" else [command]
    parts = re.split(r"^## (.*)\n", Gpsrecon(program).run(*words, "--help-markdown"), flags=re.M)[1:]
    return dict(zip(parts[::2], parts[1::2]))


def joined(tables):
    """One table of several with the same head."""
    head = tables[0].splitlines(keepends=True)[:2]
    return "".join(head + [line for table in tables for line in table.splitlines(keepends=True)[2:]])


def sections_of(page, program):
    sections = {}
    for marker, command, group in MARKER.findall(page):
        groups = groups_of(program, command)
        tables = [groups[group]] if group else [t for title, t in groups.items() if title != EVERYWHERE]
        sections[marker] = joined(tables)
    return sections


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--program", default=GPSRECON)
    parser.add_argument("--page", type=Path, default=ROOT / "docs/reference/cli.md")
    parser.add_argument("--check", action="store_true", help="only look")
    arguments = parser.parse_args()
    page = arguments.page.read_text(encoding="utf-8")
    sections = sections_of(page, arguments.program)
    if not arguments.check:
        replace_sections(arguments.page, sections)
        return 0
    stale = [name for name, text in sections.items() if section(page, name) != text]
    for name in stale:
        print(f"{arguments.page}: {name}: not up to date (scripts/option_tables.py)", file=sys.stderr)
    return 1 if stale or not sections else 0


if __name__ == "__main__":
    sys.exit(main())
