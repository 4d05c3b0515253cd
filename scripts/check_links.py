#!/usr/bin/env python3
"""Checks that links lead somewhere: files, pictures and headings.

    scripts/check_links.py             # the Markdown files of the project
    scripts/check_links.py FOLDER      # the HTML files of a site, such as build/docs/site

Each broken link is printed with its file and line. Links to other hosts are not followed.
Exit codes: 0 all links lead somewhere, 1 some do not.
"""

import html.parser
import re
import sys
import urllib.parse
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def blank(match):
    """Spaces, and the line ends, in place of what must not be read."""
    return re.sub(r"[^\n]", " ", match[0])


def without_code(text):
    text = re.sub(r"^(```|~~~).*?^\1", blank, text, flags=re.M | re.S)
    text = re.sub(r"^    .*$", blank, text, flags=re.M)
    return re.sub(r"`[^`\n]*`", blank, text)


def anchor_of(heading):
    """The name that GitHub gives a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def read_markdown(path):
    """(links with their lines, anchors) of a Markdown file."""
    text = path.read_text(encoding="utf-8")
    prose = without_code(text)
    links = [(match[1], prose.count("\n", 0, match.start()) + 1)
             for match in re.finditer(r"\]\(([^()\s]+)(?: \"[^\"]*\")?\)", prose)]
    anchors = set(re.findall(r"<a id=\"([^\"]+)\"", text))
    for heading in re.findall(r"^#+ +(.*?) *$", re.sub(r"^```.*?^```", blank, text, flags=re.M | re.S), re.M):
        name, count = anchor_of(heading), 1
        while name in anchors:
            name = f"{anchor_of(heading)}-{count}"
            count += 1
        anchors.add(name)
    return links, anchors


class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.links, self.anchors = [], set()

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if value and (name == "id" or (name == "name" and tag == "a")):
                self.anchors.add(value)
            elif value and ((name == "href" and tag != "base") or (name == "src" and tag in ("img", "script"))):
                self.links.append((value, self.getpos()[0]))


def read_html(path):
    page = Page()
    page.feed(path.read_text(encoding="utf-8", errors="replace"))
    return page.links, page.anchors


def broken_links(paths, read):
    """Complaints about the links of some files."""
    found = {path.resolve(): read(path) for path in paths}
    for path, (links, _) in found.items():
        for link, line in links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc or link.startswith("#__"):
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir() and (target / "index.html").exists():
                target = target / "index.html"
            anchor = urllib.parse.unquote(parts.fragment)
            if not target.exists():
                yield f"{path}:{line}: {link}: there is no such file"
            elif anchor and target in found and anchor not in found[target][1]:
                yield f"{path}:{line}: {link}: there is no such heading"


def pages():
    """The Markdown files of the project."""
    return sorted(ROOT.glob("*.md")) + [p for folder in ("docs", "datasets") for p in sorted((ROOT / folder).rglob("*.md"))]


def main():
    if len(sys.argv) > 2 or (len(sys.argv) == 2 and not Path(sys.argv[1]).is_dir()):
        print(__doc__, file=sys.stderr)
        return 2
    if len(sys.argv) == 2:
        paths, read = sorted(Path(sys.argv[1]).rglob("*.html")), read_html
    else:
        paths, read = pages(), read_markdown
    complaints = list(broken_links(paths, read))
    for line in complaints:
        print(line, file=sys.stderr)
    print(f"{len(paths)} files, {len(complaints)} broken links")
    return 1 if complaints or not paths else 0


if __name__ == "__main__":
    sys.exit(main())
