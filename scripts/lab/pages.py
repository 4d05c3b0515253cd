"""Markdown: tables, and pages of which scripts write sections. A section begins after a line <!-- NAME --> and ends at
the next line <!-- end -->; all else is written by hand."""

import re

from lab.runner import Failure


def row(cells):
    return "| " + " | ".join(cells) + " |\n"


def table(head, rows):
    """With the end of its last line."""
    return row(head) + "|" + "---|" * len(head) + "\n" + "".join(map(row, rows))


def pattern_of(name):
    return re.compile(f"^(<!-- {re.escape(name)} -->\n)(.*?)^(<!-- end -->)$", re.S | re.M)


def section(text, name):
    """What is in a section of a page's text; None where there is no such section."""
    found = pattern_of(name).search(text)
    return found[2] if found else None


def replace_sections(path, sections):
    """Puts the texts of `sections`, by name, into the page at `path`, or none of them where one has no place there."""
    page = path.read_text(encoding="utf-8")
    for name, text in sections.items():
        page, count = pattern_of(name).subn(lambda found: found[1] + text + found[3], page)
        if count != 1:
            raise Failure(f"{path}: has {'no place' if count == 0 else 'several places'} for {name}")
    path.write_text(page, encoding="utf-8")
