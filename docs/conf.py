"""Sphinx configuration. The examples of the gallery run when the pages are built."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import case_reference
import foreign_hosts
import module_list
import other_projects
from sphinx.errors import ExtensionError

from restitution.explorer.launch import write_static

case_reference.write()
module_list.write()

project = "restitution"
author = "The restitution developers"
project_copyright = "The restitution developers"
version = release = installed_version("restitution")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "_templates"]
templates_path = ["_templates"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": "Exception,tuple,int,str,list"}
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_aliases = other_projects.aliases()
numpydoc_xref_ignore = other_projects.WORDS

intersphinx_mapping = other_projects.mapping()

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": "/plot_",
    "within_subsection_order": "FileNameSortKey",
    "reset_modules": ("matplotlib", "gallery_look.look"),
    "abort_on_example_error": True,
    "capture_repr": (),
    "download_all_examples": False,
    "show_signature": False,
    "thumbnail_size": (600, 420),
    "write_computation_times": False,
    "min_reported_time": 1e9,
}

html_theme = "pydata_sphinx_theme"
html_title = "restitution"
html_static_path = ["_static"]
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    # One row of links on a screen of 1280 pixels.
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_css_files = ["pages.css"]
# Pages without others beside or below them.
html_sidebars = {name: [] for name in ("index", "quickstart", "search", "genindex", "py-modindex")}


def finish(app, error):
    """Put the explorer that needs no server beside the pages; refuse pages that need another host."""
    if error is None:
        write_static(Path(app.outdir) / "static_explorer")
        if lines := foreign_hosts.loading_lines(Path(app.outdir)):
            raise ExtensionError("pages load from other hosts:\n" + "\n".join(lines))


def setup(app):
    """Finish the pages after the build."""
    app.connect("build-finished", finish)
