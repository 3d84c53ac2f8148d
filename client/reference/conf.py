"""Sphinx: the Python package, the protocol, and links to what other tools make. Run by client/reference/make."""

import os
import sys

sys.path.insert(0, os.environ["COLLIDED_REFERENCE"])
import prose  # noqa: E402
from sphinx.util import logging  # noqa: E402

project = "collided"
copyright = "the collided authors"  # noqa: A001
release = version = os.environ["COLLIDED_VERSION"]
extensions = ["sphinx.ext.autodoc"]
html_theme = "alabaster"
html_theme_options = {"description": "Contacts of moving meshes", "page_width": "75rem"}
html_show_sourcelink = False
html_copy_source = False
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_default_options = {"members": True, "undoc-members": True, "show-inheritance": True}
logger = logging.getLogger(__name__)
NEEDS_DOCSTRING = {"module", "class", "exception", "function", "method", "property"}


def to_rst(app, what, name, obj, options, lines):
    """Docstrings are plain text. A public name without one is a warning, and warnings are errors."""
    if not any(lines) and what in NEEDS_DOCSTRING:
        logger.warning("%s %s has no docstring", what, name)
    lines[:] = prose.lines_of("\n".join(lines))


def setup(app):
    app.connect("autodoc-process-docstring", to_rst)
