"""Links from pages to files of the repository, shown as highlighted source pages of the site.

A page links to a file or folder by its relative path, such as `../../emulator/config.py`. The same
link works when the page is read in the repository. A missing file is a warning.
"""

import html
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform
from sphinx.util.osutil import relative_uri

ROOT = Path(__file__).parents[2]
SCHEME = "repository:"
LANGUAGES = {".py": "python", ".toml": "toml", ".xml": "xml", ".md": "markdown", ".sh": "bash"}
HIDDEN = {"__pycache__", "_build", "auto_gallery"}


class LinksToRepository(SphinxTransform):
    """Replace MyST's links to files outside docs/ by references of the scheme `repository:`."""

    default_priority = 5

    def apply(self, **_: Any) -> None:
        """Replace them in one document."""
        for kind in (addnodes.pending_xref, addnodes.download_reference):
            for node in list(self.document.findall(kind)):
                path = self._file_of(node)
                if path is not None:
                    link = nodes.reference("", "", refuri=SCHEME + path.as_posix(), internal=True)
                    link += node.children
                    node.replace_self(link)

    def _file_of(self, node: nodes.Element) -> Path | None:
        """Return the path in the repository, or None if the link leads elsewhere."""
        if node.get("reftype") != "myst":
            return None
        target, _, _ = node["reftarget"].partition("#")
        target += ".md" if target and node.get("refdomain") == "doc" else ""
        page, docs = Path(self.env.doc2path(self.env.docname)), Path(self.env.srcdir)
        path = (page.parent / target).resolve()
        if not target or not path.is_relative_to(ROOT):
            return None
        if not path.exists() and (ROOT / target).exists():  # an included file of the repository
            path = ROOT / target
            if path.is_relative_to(docs) and path.suffix == ".md":
                node["refdomain"], node["reftarget"] = "doc", self.env.path2doc(path)
                node.setdefault("reftargetid", None)
                return None
        elif path.is_relative_to(docs):
            return None
        return path.relative_to(ROOT) if path.exists() else None


def _uri(app: Sphinx, here: str, there: str) -> str:
    return relative_uri(app.builder.get_target_uri(here), app.builder.get_target_uri(there))


def page_of(path: str) -> str:
    """Return the name of the page that shows a file of the repository."""
    return f"source/{path}"


def resolve(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Point the references of one page to the source pages, and note which are needed."""
    shown = app.env.__dict__.setdefault("repository_files", {})
    shown[docname] = set()
    for link in doctree.findall(nodes.reference):
        if link.get("refuri", "").startswith(SCHEME):
            path, _, anchor = link["refuri"].removeprefix(SCHEME).partition("#")
            shown[docname].add(path)
            here, there = (
                app.builder.get_target_uri(docname),
                app.builder.get_target_uri(page_of(path)),
            )
            link["refuri"] = relative_uri(here, there) + (f"#{anchor}" if anchor else "")


def source_pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Make a page for each file that is linked, and for each file of a linked folder."""
    waiting = sorted(set().union(*app.env.__dict__.get("repository_files", {}).values()))
    made = set()
    while waiting:
        path = waiting.pop()
        if path in made:
            continue
        made.add(path)
        if (ROOT / path).is_dir():
            files = _files(path)
            waiting += files
            body = _folder_body(app, path, files)
        else:
            body = _file_body(app, path)
        title = html.escape(path)
        yield page_of(path), {"title": title, "body": f"<h1>{title}</h1>\n{body}"}, "page.html"


def _files(folder: str) -> list[str]:
    """Return the text files and folders in a folder, as paths in the repository."""
    inside = sorted((ROOT / folder).iterdir())
    return [
        p.relative_to(ROOT).as_posix()
        for p in inside
        if p.name not in HIDDEN and (p.is_dir() or p.suffix in LANGUAGES)
    ]


def _folder_body(app: Sphinx, folder: str, files: list[str]) -> str:
    here = app.builder.get_target_uri(page_of(folder))
    links = [
        (relative_uri(here, app.builder.get_target_uri(page_of(f))), Path(f).name) for f in files
    ]
    rows = (f'<li><a href="{uri}">{html.escape(name)}</a></li>' for uri, name in links)
    return f"<ul>{''.join(rows)}</ul>"


def _file_body(app: Sphinx, path: str) -> str:
    text = (ROOT / path).read_text(encoding="utf-8")
    language = LANGUAGES.get(Path(path).suffix, "text")
    block: str = app.builder.highlighter.highlight_block(  # type: ignore[attr-defined]
        text, language, linenos="inline", lineanchors="L", location=path
    )
    return block


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.add_transform(LinksToRepository)
    app.connect("doctree-resolved", resolve)
    app.connect("html-collect-pages", source_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
