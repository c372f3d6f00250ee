"""Makes the pages of the project those of a site: site_pages.py DOCS_FOLDER.

On the site the README is the start, and there are no sources: a link to a file or folder of the project that is not a page, a
picture or a table of the documentation becomes its text. Headings keep the anchors that they have beside the sources. Lists without an empty line before them get one: mkdocs wants it.
"""

import os
import re
import sys
from pathlib import Path

LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)", re.S)
MOVED = {"README.md": "index.md"}


def target_on_site(docs: Path, page: Path, target: str) -> str | None:
    """The link as it is on the site; None: it leads out of it."""
    if re.match(r"[a-zA-Z][a-zA-Z0-9+.-]*:", target) or target.startswith("#"):
        return target
    path, _, anchor = target.partition("#")
    at_top = page == docs / "index.md"
    from_top = os.path.normpath(path if at_top else os.path.join("docs", os.path.relpath(page.parent, docs), path))
    inside = from_top[5:] if from_top.startswith("docs/") else MOVED.get(from_top, from_top)
    if not (docs / inside).is_file():
        return None
    link = os.path.relpath(docs / inside, page.parent)
    return link + ("#" + anchor if anchor else "")


def anchor_of(heading: str) -> str:
    """As tests/architecture/links.cpp forms it: lower case, blanks to hyphens, punctuation dropped."""
    return "".join("-" if c == " " else c.lower() for c in heading if c in " -_" or c.isalnum() or ord(c) >= 0x80)


def with_anchors(text: str, seen: dict) -> str:
    def name(found: re.Match) -> str:
        anchor = anchor_of(re.sub(r"[`*]|\]\([^)]*\)|\[", "", found.group(2)).strip())
        seen[anchor] = seen.get(anchor, -1) + 1
        return f"{found.group(0)} {{#{anchor}{'-%d' % seen[anchor] if seen[anchor] else ''}}}"

    return re.sub(r"^(#{1,6}) (.+)$", name, text, flags=re.M)


def convert(docs: Path, page: Path) -> None:
    def replace(found: re.Match) -> str:
        mark, text, target = found.groups()
        link = target_on_site(docs, page, target)
        return text if link is None else f"{mark}[{text}]({link})"

    pieces = re.split(r"(^```.*?^```$)", page.read_text(encoding="utf-8"), flags=re.M | re.S)  # code stays as it is
    pieces = [p if i % 2 else LINK.sub(replace, p) for i, p in enumerate(pieces)]
    pieces = [p if i % 2 else re.sub(r"(^(?![-*|\s]|\d+\.).+\n)(?=[-*] )", r"\1\n", p, flags=re.M) for i, p in enumerate(pieces)]
    seen: dict = {}
    pieces = [p if i % 2 else with_anchors(p, seen) for i, p in enumerate(pieces)]
    page.write_text("".join(pieces), encoding="utf-8")


def main() -> None:
    docs = Path(sys.argv[1])
    for page in sorted(docs.rglob("*.md")):
        convert(docs, page)


if __name__ == "__main__":
    main()
