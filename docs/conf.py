"""Configuration of the documentation site: `python -m sphinx -W -b html -c docs . site` in a
checkout.

The checkout is the source folder: README, CONTRIBUTING, the guide in this folder and the tables of
tests are pages where they stand. Laws and cases are listed before anything is read, see pages.py.
"""

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
os.environ.pop("MPLBACKEND", None)  # a backend without a screen takes the pictures out of notebooks

from docstrings import as_restructured_text  # noqa: E402
from gallery_pictures import pictures, put_thumbnails  # noqa: E402
from pages import read_page, write_pages, write_root  # noqa: E402

from clearance.version import VERSION  # noqa: E402

project, author, release = "clearance", "The clearance developers", VERSION
copyright = "the clearance developers, MIT licence"
root_doc = "docs/index"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
]
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "paper_figures/README.md",
    "tests/*/README.md",
    "docs/**",
]
# the gallery has notebooks and scripts of its own, which are run once
exclude_patterns = [f"docs/made/gallery/**/*.{e}" for e in ("ipynb", "py", "zip", "md5", "json")]
exclude_patterns += ["docs/gallery/**", "docs/*.py"]
myst_enable_extensions = ["dollarmath", "attrs_inline", "colon_fence", "html_image"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_timeout = 900
nb_execution_raise_on_error = True
nb_merge_streams = True
suppress_warnings = [
    "myst.header",  # sections of the guide begin below the title of their page
    "config.cache",  # the scraper of pictures is a function
    "misc.highlighting_failure",  # fences of kinds that have no colours, as csv
    "sphinx_gallery.space_in_filename",  # of the folder of the checkout
]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
sphinx_gallery_conf = {
    "examples_dirs": ["docs/gallery"],
    "gallery_dirs": ["docs/made/gallery"],
    "filename_pattern": "/plot_",
    "nested_sections": False,
    "within_subsection_order": "FileNameSortKey",
    "subsection_order": [f"docs/gallery/{name}" for name in ("machines", "joints", "methods")],
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_memory": False,
    "image_scrapers": (pictures,),
    "capture_repr": (),
}
html_theme = "pydata_sphinx_theme"
html_title = f"clearance {VERSION}"
html_logo = html_favicon = "_static/logo.svg"
html_static_path = ["_static"]
html_extra_path = ["made/root"]
html_sourcelink_suffix = ""
html_css_files = ["site.css"]
html_sidebars = {"docs/index": []}
html_theme_options = {
    "show_prev_next": True,
    "logo": {"text": html_title},
    "secondary_sidebar_items": {
        "**": ["page-toc", "edit-this-page", "sourcelink"],
        "docs/index": [],
    },
}
if forge := os.environ.get("CLEARANCE_FORGE"):  # address of the repository, for links that edit
    html_theme_options["use_edit_page_button"] = True
    html_context = {"edit_page_url_template": f"{forge}/edit/main/{{{{ file_name }}}}"}


def setup(app):
    """Make the pages that are made, and read docstrings as the package has them."""
    app.connect("autodoc-process-docstring", as_restructured_text)
    app.connect("source-read", read_page)
    app.connect("builder-inited", put_thumbnails, priority=900)
    write_pages(HERE / "made")
    write_root(HERE / "made" / "root")
