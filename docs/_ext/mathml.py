"""Formulae as MathML, which every browser draws by itself: no network, no script, no LaTeX."""

from __future__ import annotations

import re

from docutils import nodes
from docutils.utils.math import latex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


def mathml(formula: str, block: bool) -> str:
    """The formula as an element ``math``; ExtensionError where it is no LaTeX that is understood."""
    try:
        # a label is no part of a formula here
        element = latex2mathml.tex2mathml(re.sub(r"\\label\{.*?\}", "", formula), as_block=block)
    except Exception as error:
        raise ExtensionError(f"the formula {formula!r} cannot be drawn: {error}") from error
    return element


def visit_math(self, node: nodes.math) -> None:
    self.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def visit_block(self, node: nodes.math_block) -> None:
    self.body.append(f'<div class="math">{mathml(node.astext(), block=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
