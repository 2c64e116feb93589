"""A check of the built site: every link and picture of a page leads to a file of the site."""

import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from sphinx.application import Sphinx
from sphinx.errors import SphinxError

LINK = re.compile(r'<(?:a|img|link|script)\b[^>]*?\b(?:href|src)="([^"]+)"')
IDENTIFIER = re.compile(r'\bid="([^"]+)"')
ELSEWHERE = re.compile(r"[a-z]+:|//")


def check(app: Sphinx, error: Exception | None) -> None:
    """Fail if a link leads to a file or a place in a page that does not exist."""
    if error is not None or app.builder.format != "html":
        return
    folder = Path(app.outdir)
    texts = {page: page.read_text(encoding="utf-8") for page in folder.rglob("*.html")}
    places = {page: {*IDENTIFIER.findall(text), "", "top"} for page, text in texts.items()}
    missing = []
    for page, text in texts.items():
        for link in sorted(set(LINK.findall(text))):
            if ELSEWHERE.match(link):
                continue
            path, _, place = unquote(link.partition("?")[0]).partition("#")
            target = (page.parent / path).resolve() if path else page
            if not target.exists() or place not in places.get(target, {place}):
                missing.append(f"{page.relative_to(folder)} links to {link}")
    if missing:
        raise SphinxError("Of the built site, these links lead nowhere:\n" + "\n".join(missing))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.connect("build-finished", check, priority=900)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
