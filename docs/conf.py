"""Settings of the documentation site. `make docs` builds it to docs/_build/html."""

import sys
from importlib.util import find_spec
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS.parent), str(DOCS / "_ext")]

from flybench import __version__  # noqa: E402

project = "flybench"
author = "the developers of flybench"
copyright = "2026, the developers of flybench"  # noqa: A001
version = release = __version__

extensions = [
    "myst_nb",  # Markdown pages, and notebooks that run when the site is built
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "checked_links",
    "generated_pages",
    "plain_docstrings",
    "public_names",
    "repository_links",
    "unbroken_units",
]
exclude_patterns = ["_build", "gallery", "**/.ipynb_checkpoints"]
exclude_patterns += ["auto_gallery/**/*.ipynb", "sg_execution_times.rst"]  # the gallery makes them
nitpicky = True
OURS = r"(?:flybench|sim|emulator|detector|formats|scenarios)\b"
nitpick_ignore_regex = [("py:.*", rf"(?!{OURS}).*"), ("py:obj", ".*")]
default_role = "py:obj"  # `names` in docstrings become links where they can
linkcheck_ignore = [r"http://(localhost|127\.0\.0\.1)"]

# Markdown
myst_enable_extensions = ["amsmath", "attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_enable_extensions += ["tasklist"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_cache_path = str(DOCS / "_build" / "notebooks")
nb_execution_timeout = 300
nb_execution_raise_on_error = True

# Docstrings
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Events", "F32", "F64", "npt.ArrayLike")}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88

# Gallery: each script in docs/gallery becomes a page with its figures.
sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "subsection_order": [f"gallery/{topic}" for topic in ("scene", "sensor", "detector", "own")],
    "within_subsection_order": "gallery_order.GalleryOrder",
    "filename_pattern": r"[\\/]",
    "ignore_pattern": r"[\\/]_",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "parallel": True,  # as many processes as -j of Sphinx
    "show_memory": False,
    "min_reported_time": 1e9,  # the time on the machine that built the site tells a reader nothing
    "write_computation_times": False,
    "show_signature": False,
    "remove_config_comments": True,
}

# Look. Everything that a page needs lies in the site, so it can be read offline.
html_theme = "furo"
html_title = f"flybench {release}"
MATHJAX = Path(next(iter(find_spec("sphinx-mathjax-offline").submodule_search_locations)))
html_static_path = ["_static", str(MATHJAX / "static" / "mathjax" / "tex-svg.js")]
html_css_files = ["site.css"]
mathjax_path = "tex-svg.js"
html_copy_source = False
