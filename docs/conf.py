"""The documentation site; scripts/site builds it."""

import re
import sys
import warnings
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert

import geartrain

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import fortran_pages  # noqa: E402

project = "geartrain"
copyright = "2026, the geartrain authors"
version = release = (HERE.parent / "fpm.toml").read_text(encoding="utf-8").split('version = "')[1].split('"')[0]
language = "en"
html_theme = "furo"
html_title = f"geartrain {version}"
html_copy_source = False
html_static_path = ["site.css"]
html_css_files = ["site.css"]
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode", "numpydoc", "sphinx_gallery.gen_gallery"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nitpicky = True
# Other variables of a group, named in the table of variables.
nitpick_ignore = [("py:obj", "backlash"), ("py:obj", "unit")]

# Names of a docstring in single quotes are links.
default_role = "py:obj"
autodoc_default_options = {
    "members": True,
    # What a class has from Python's own classes is not told again.
    "inherited-members": "Mapping, list, tuple, Exception, Warning",
    "member-order": "bysource",
}
autodoc_typehints = "none"
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": str(HERE.parent / "example" / "gallery"),
    "gallery_dirs": "gallery",
    "filename_pattern": "/",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,
    "show_signature": False,
    "abort_on_example_error": True,
    "copyfile_regex": r".*\.nml",
}
# What a drawing is warned of does not concern its picture.
warnings.simplefilter("ignore", geartrain.DrawingWarning)


def show(self, node, display):
    """Formulas become MathML, which browsers draw by themselves: nothing is fetched when a page is opened."""
    self.body.append(convert(node.astext(), display="block" if display else "inline"))
    raise nodes.SkipNode


#: Places of a clone that index.md links to, and the pages of the site that show them.
PAGES = {"../example/gallery/": "gallery/index", "../CHANGELOG.md": "changes", "../src/geartrain.f90": "fortran/index"}


def contents(text):
    """The first page with the pages that each part links to as a part of the menu."""
    for place, page in PAGES.items():
        text = text.replace(f"]({place})", f"]({page}.md)")
    for part in text.split("\n## ")[1:]:
        pages = re.findall(r"\]\(([\w/-]+)\.md\)", part)
        menu = [f":caption: {part.splitlines()[0]}", ":hidden:", ":maxdepth: 1", "", *pages]
        text += "\n".join(["", "```{toctree}", *menu, "```", ""])
    return text.replace("(gallery/index.md)", "(gallery/index.rst)")


def add_menu(app, docname, source):
    """The first page gets the menu of the site."""
    if docname == "index":
        source[0] = contents(source[0])


def setup(app):
    app.add_html_math_renderer("mathml", (lambda self, node: show(self, node, False), None),
                               (lambda self, node: show(self, node, True), None))
    app.connect("source-read", add_menu)
    app.connect("builder-inited", lambda app: fortran_pages.write(HERE.parent / "src", HERE / "fortran"))


html_math_renderer = "mathml"
