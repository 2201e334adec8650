"""Hooks of the site's build: parts of reference from the code, links that leave `docs/` led to copies inside the site, pictures
that open in full size, and a search that works without a server."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File

from benchmarks.guide.reference import filled

PROJECT = Path(__file__).resolve().parents[2]
ELSEWHERE = "project"
"""Folder of the site for files of the project that stand outside `docs/`."""
LINK = re.compile(r"(?<=\])\(([^)\s#]+)(#[^)]*)?\)")
CODE = re.compile(r"(?ms)^```.*?^```$|^(?: {4}.*\n)+|`[^`\n]+`")
PICTURE = re.compile(r"<img\b[^>]*\bsrc=\"([^\"]+)\"[^>]*>")
INDEX = "search/search_index"


def on_files(files: Any, config: Any) -> Any:
    """Add what pages of `docs/` link to outside it."""
    for path in sorted(linked_outside(Path(config.docs_dir))):
        name = posixpath.join(ELSEWHERE, path.relative_to(PROJECT).as_posix())
        files.append(File.generated(config, name, abs_src_path=str(path)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Fill in generated parts; lead links that leave `docs/` to the copies, folders to their README.

    The start page has a table of all pages and so no navigation beside it.
    """
    at = page.file.src_uri
    if at == "README.md":
        page.meta["hide"] = ["navigation"]
    outside = at.removeprefix(ELSEWHERE + "/") if at.startswith(ELSEWHERE + "/") else None
    here = posixpath.dirname(outside if outside is not None else posixpath.join("docs", at))

    def led(match: re.Match[str]) -> str:
        target = target_of(here, match[1])
        if target is None:
            return match[0]
        inside = target.startswith("docs/")
        place = target.removeprefix("docs/") if inside else posixpath.join(ELSEWHERE, target)
        return f"({posixpath.relpath(place, posixpath.dirname(at) or '.')}{match[2] or ''})"

    return filled(outside_code(markdown, lambda text: LINK.sub(led, text)))


def on_page_content(html: str, page: Any, config: Any, files: Any) -> str:
    """Lead every picture to itself in full size: on a phone its labels are too small."""
    return PICTURE.sub(lambda found: f'<a class="picture" href="{found[1]}">{found[0]}</a>', html)


def on_post_build(config: Any) -> None:
    """Write the search's index as a script, too: a page opened from the disk may not read a JSON file."""
    index = Path(config.site_dir) / f"{INDEX}.json"
    index.with_suffix(".js").write_text(f"var __index = {index.read_text(encoding='utf-8')}", encoding="utf-8")


def outside_code(text: str, change: Any) -> str:
    """The text with `change` applied to what is not code."""
    parts, last = [], 0
    for block in CODE.finditer(text):
        parts += [change(text[last : block.start()]), block[0]]
        last = block.end()
    return "".join([*parts, change(text[last:])])


def target_of(folder: str, link: str) -> str | None:
    """Path in the project that a link of a page in `folder` leads to, a folder's README for a folder; None for another link."""
    if re.match(r"[a-z]+:", link) or link.startswith("/"):
        return None
    target = posixpath.normpath(posixpath.join(folder, link))
    if (PROJECT / target).is_dir():
        target = posixpath.join(target, "README.md")
    return target if (PROJECT / target).is_file() else None


def linked_outside(docs: Path) -> set[Path]:
    """Files of the project outside `docs/` that its pages link to, and those that such pages link to in turn."""
    found: set[Path] = set()
    waiting = sorted(docs.rglob("*.md"))
    while waiting:
        page = waiting.pop()
        folder = page.parent.relative_to(PROJECT).as_posix()
        for link, _ in LINK.findall(CODE.sub("", page.read_text(encoding="utf-8"))):
            target = target_of(folder, link)
            path = PROJECT / target if target else None
            if path is None or path.is_relative_to(docs) or path in found:
                continue
            found.add(path)
            if path.suffix == ".md":
                waiting.append(path)
    return found
