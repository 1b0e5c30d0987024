"""Settings of the documentation: ``python -m sphinx -W --keep-going docs docs/_build/html``."""

import os
import shutil
import sys
import warnings
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_ext")]
# examples run in processes of their own too
os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE.parent), os.environ.get("PYTHONPATH", "")])

from loopelastica import __version__ as release  # noqa: E402

project = "loopelastica"
author = "The loopelastica developers"
copyright = f"2026, {author}"
version = release

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "commands",
    "mathml",
]
root_doc = "index"
exclude_patterns = ["_build", "**sg_execution_times.rst"]
source_suffix = {".rst": "restructuredtext", ".md": "markdown"}

# Markdown: $…$ and $$…$$ are mathematics, ::: is a directive
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

# “–jobs” is no option
smartquotes = False

html_theme = "pydata_sphinx_theme"
html_title = f"loopelastica {release}"
html_static_path = ["_static"]
html_css_files = ["own.css"]
html_extra_path = ["schemas"]
html_show_sourcelink = False
# formulae become MathML: they show without a network and without a script
html_math_renderer = "mathml"
html_theme_options = {
    "navbar_align": "left",
    "show_toc_level": 2,
    "header_links_before_dropdown": 7,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_sidebars = {name: [] for name in ("index", "quality", "faq", "comparison")}

templates_path = ["_templates"]
autosummary_generate = True
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_xref_param_type = False

# examples draw their pictures where they run: in a copy, so that none is left among the sources
EXAMPLES = HERE / "_build" / "examples"
shutil.rmtree(EXAMPLES, ignore_errors=True)
shutil.copytree(HERE.parent / "examples", EXAMPLES)

sphinx_gallery_conf = {
    "examples_dirs": str(EXAMPLES),
    "gallery_dirs": "gallery",
    # every script is run; one that fails, fails the build. Those that render need PyMOL
    "filename_pattern": r"\.py$",
    "ignore_pattern": r"__init__|render_",
    "abort_on_example_error": False,
    "only_warn_on_example_error": False,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 5,
    "matplotlib_animations": False,
}

# sphinx-gallery and its readers, of functions that other packages are about to drop
warnings.filterwarnings("ignore", category=DeprecationWarning)
