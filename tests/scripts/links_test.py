"""The check of links: links_test.py PROGRAM"""

import re
import tempfile
import unittest
from pathlib import Path

import support  # noqa: F401 (finds the scripts)

import check_links


class Links(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def broken(self, read, **files):
        for name, text in files.items():
            (self.folder / name).write_text(text, encoding="utf-8")
        paths = [self.folder / name for name in files]
        return [line.split(": ", 1)[1] for line in check_links.broken_links(paths, read)]

    def test_links_of_markdown(self):
        found = self.broken(check_links.read_markdown, a="""# Head
[one](b) [two](b#the-second----head) [three](#head) [far](https://example.org/none) ![picture](none.png)
[four](b#no) [five](none#head) `[code](none)`

    [code](none)

```
[code](none)
# no head
```
[six](#no-head)
""", b="## The second `--` head\n")
        self.assertEqual(found, ["none.png: there is no such file", "b#no: there is no such heading",
                                 "none#head: there is no such file", "#no-head: there is no such heading"])

    def test_headings_of_one_name_are_numbered(self):
        self.assertEqual(self.broken(check_links.read_markdown, a="# x\n# x\n[1](#x) [2](#x-1) [3](#x-2)\n"),
                         ["#x-2: there is no such heading"])

    def test_links_of_html(self):
        found = self.broken(check_links.read_html, a="""<base href="none"><h1 id="head">x</h1>
<a href="b">1</a><a href="b#second">2</a><a href="b#no">3</a><img src="none.png"><script src="none.js"></script>
""", b='<a name="second"></a>')
        self.assertEqual(found, ["b#no: there is no such heading", "none.png: there is no such file",
                                 "none.js: there is no such file"])

    def test_those_of_the_project_lead_somewhere(self):
        self.assertGreater(len(check_links.pages()), 30)
        self.assertEqual(list(check_links.broken_links(check_links.pages(), check_links.read_markdown)), [])

    def test_headers_that_pages_name_are_there(self):
        named = {(page.name, header) for page in check_links.pages()
                 for header in re.findall(r"`(?:lib/)?([a-z]+/[a-z_]+\.h)`", page.read_text())}
        self.assertGreater(len(named), 20)
        self.assertEqual([(page, header) for page, header in sorted(named)
                          if not (check_links.ROOT / "lib" / header).exists()], [])

    def test_the_site_lists_every_page(self):
        site = (check_links.ROOT / "docs/mkdocs.yml").read_text()
        pages = [str(page.relative_to(check_links.ROOT)) for page in check_links.pages()]
        self.assertEqual([page for page in pages if f": {page}\n" not in site], [])


if __name__ == "__main__":
    unittest.main(argv=["links_test"])
