# Configuration of the documentation site; tools/docs builds it.
import logging
import os

project = "kerf"
author = "the kerf authors"
copyright = "the kerf authors, Apache-2.0"
release = os.environ.get("KERF_VERSION", "")
extensions = ["myst_parser", "breathe"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["layers.txt"]
nitpicky = False  # Breathe leaves standard types such as std::size_t without a target
highlight_language = "none"
myst_heading_anchors = 4
breathe_projects = {"kerf": os.environ.get("KERF_DOXYGEN_XML", "")}
breathe_default_project = "kerf"
breathe_default_members = ("members", "undoc-members")
html_theme = "furo"
html_title = f"kerf {release}"
html_static_path = []


def setup(app):
    # Each header opens the namespace kerf again, which Sphinx takes for a second declaration of it.
    def is_other(record):
        return not record.getMessage().endswith("Declaration is '.. cpp:type:: kerf'.")
    logging.getLogger("sphinx.sphinx.domains.cpp").addFilter(is_other)
