"""The directive `public-names`: a table of what `import flybench` gives, from its own list."""

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import flybench


class PublicNames(SphinxDirective):
    """One row for each package, with links to the descriptions of its names."""

    def run(self) -> list[nodes.Node]:
        """Return the table."""
        rows = ["| package | names |", "| --- | --- |"]
        for module, names in flybench._MODULES.items():
            if module == "flybench.version":
                continue
            links = ", ".join(f"{{py:obj}}`~{module}.{name}`" for name in names)
            rows.append(f"| `{module}` | {links} |")
        return self.parse_text_to_nodes("\n".join(rows))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("public-names", PublicNames)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
