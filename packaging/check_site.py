"""Checks a site: check_site.py FOLDER. Every link leads to a file, every anchor to an element, nothing is loaded from a network.

Closes with `N passed, N failed`, counted in pages.
"""

import os
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("source", "src")}


class Page(HTMLParser):
    def __init__(self, path: Path) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.links: list[tuple[str, str, str]] = []
        self.feed(path.read_text(encoding="utf-8", errors="replace"))

    def handle_starttag(self, tag, attrs):
        for key, value in attrs:
            if value is None:
                continue
            if key in ("id", "name"):
                self.names.add(value)
            if key in ("href", "src"):
                self.links.append((tag, key, value))


def mistake(folder: Path, pages: dict, path: Path, tag: str, key: str, value: str) -> str:
    parts = urlsplit(value)
    if parts.scheme or parts.netloc:
        return "is loaded from a network" if (tag, key) in LOADED and parts.scheme != "data" else ""
    target = Path(os.path.normpath(path.parent / unquote(parts.path))) if parts.path else path
    if target.is_dir():
        target = target / "index.html"
    if not target.exists():
        return "leads nowhere"
    if not str(target).startswith(str(folder)):
        return "leads out of the site"
    if parts.fragment and target in pages and unquote(parts.fragment) not in pages[target].names:
        return "names no element of its page"
    return ""


def main() -> int:
    folder = Path(sys.argv[1]).resolve()
    pages = {p: Page(p) for p in sorted(folder.rglob("*.html"))}
    links = failed = 0
    for path, page in pages.items():
        wrong = {v: m for t, k, v in page.links if (m := mistake(folder, pages, path, t, k, v))}
        links, failed = links + len(page.links), failed + bool(wrong)
        for value, what in wrong.items():
            print(f"failed: {path.relative_to(folder)}: {value} {what}")
    passed = len(pages) - failed
    print(f"{links} links")
    print(f"{passed} passed, {failed} failed")
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
