"""The documentation's site: ``python docs/build.py`` builds it, without a network."""

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS))

import directives  # noqa: E402  they stand beside this file
import make_pages  # noqa: E402

project = "Octant"
author = "The Octant developers"
project_copyright = "The Octant developers, Apache-2.0"
release = make_pages.version()
version = release

extensions = ["myst_nb", "sphinx.ext.autodoc"]
exclude_patterns = ["_build", "extra", "README.md", "**/.ipynb_checkpoints"]

myst_enable_extensions = ["attrs_block", "colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
nb_ipywidgets_js = {}

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
default_role = "py:obj"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False

html_theme = "furo"
html_title = "Octant"
html_static_path = ["static"]
html_css_files = ["octant.css"]
html_js_files = ["copy.js"]
html_extra_path = ["extra"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0b5c8a",
        "color-brand-content": "#0b5c8a",
        "font-stack": "system-ui, -apple-system, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif",
    },
    "dark_css_variables": {
        "color-brand-primary": "#7cc4ec",
        "color-brand-content": "#7cc4ec",
    },
}
pygments_style = "friendly"
pygments_dark_style = "monokai"


def setup(app):  # noqa: ANN001, ANN201  Sphinx's own signature
    """Add the site's directive, and read docstrings of the house's form."""
    app.add_directive("drawing", directives.Drawing)
    app.connect("autodoc-process-docstring", make_pages.read_docstring)


make_pages.write_all()
