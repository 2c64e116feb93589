"""Reference pages that are generated from the code: commands, configuration, methods, sensors.

They are written to docs/reference/generated, which Git ignores, before Sphinx reads the pages.
"""

from pathlib import Path
from typing import Any

from command_pages import command_pages
from configuration_pages import configuration_pages
from file_pages import file_pages
from method_pages import method_pages
from sphinx.application import Sphinx

FOLDER = Path("reference") / "generated"


def write_pages(app: Sphinx) -> None:
    """Write the pages whose text has changed, and remove those that no longer exist."""
    folder = Path(app.srcdir) / FOLDER
    pages = command_pages() | configuration_pages() | method_pages() | file_pages()
    for old in folder.rglob("*.md"):
        if old.relative_to(folder).as_posix() not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension."""
    app.connect("builder-inited", write_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
