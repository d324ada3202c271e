"""Formulas as MathML, which browsers draw by themselves: no script and no network."""

import re
import shutil
import xml.etree.ElementTree as ET
from importlib.resources import as_file, files
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

# of the package ziamath; brackets grow only in a font made for mathematics
FONT = "STIXTwoMath-Regular.ttf"
TIGHT = {"lspace": "0", "rspace": "0"}
THIN = "0.167em"


def mathml(latex: str, display: str) -> str:
    """A formula, spaced as TeX does; what cannot be converted would be seen on the page, and is an
    error.
    """
    upright = re.sub(r"\\mathrm\s*\{(\w+)\}|\{\\rm (\w+)\}", r"\\text{\1\2}", latex)
    tree = ET.fromstring(convert(upright, display=display))
    left = [each.text for each in tree.iter() if each.text and "\\" in each.text]
    if left:
        raise ValueError(
            f"the formula {latex!r} cannot be converted to MathML: it leaves {left[0]!r}"
        )
    for row in tree.iter():
        tidy(row, display)
    return ET.tostring(tree, encoding="unicode", short_empty_elements=False)


def tidy(row: ET.Element, display: str) -> None:
    """The spaces and letters that the converter leaves to old versions of MathML."""
    row.tag = row.tag.rpartition("}")[2]
    before: ET.Element | None = None
    for each in row:
        name, text = each.tag.rpartition("}")[2], each.text or ""
        if text == "~" and name == "mi":
            each.tag, each.text = "mo", "∼"
        elif name == "mo" and text in ("/", "|"):
            each.attrib.update(TIGHT)
        elif name == "mo" and text in ("−", "+", "±") and opens(before):
            each.set("form", "prefix")
        # ln, arctan: an operator with a space before its argument
        elif name == "mi" and len(text) > 1:
            each.tag = "mo"
            each.attrib.update(lspace="0" if opens(before) else THIN, rspace=THIN)
        elif name == "mo" and text.isalpha() and len(text) > 1:
            each.attrib.update(lspace="0" if opens(before) else THIN, rspace=THIN)
        elif name == "mo" and text == "(" and before is not None and before.get("rspace") == THIN:
            before.set("rspace", "0")
        elif name == "msub" and display == "block" and each[0].text in ("min", "max"):
            each.tag = "munder"
        if each.attrib.pop("mathvariant", "") == "bold":
            each.text = "".join(bold(letter) for letter in text)
        if name != "mspace":
            before = each


def opens(before: ET.Element | None) -> bool:
    """Whether what comes next begins an expression."""
    return before is None or (
        before.tag.endswith("mo") and (before.text or "") not in (")", "]", "|", "}", "′")
    )


def bold(letter: str) -> str:
    """The bold letter, which is a character of its own."""
    first = "a" if letter.islower() else "A"
    return chr(ord(letter) - ord(first) + (0x1D41A if first == "a" else 0x1D400))


def visit_inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(f'<span class="math">{mathml(node.astext(), "inline")}</span>')
    raise nodes.SkipNode


def visit_block(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(f'<div class="math">{mathml(node.astext(), "block")}</div>\n')
    raise nodes.SkipNode


def copy_font(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        with as_file(files("ziamath") / "fonts" / FONT) as source:
            shutil.copyfile(source, Path(app.outdir, "_static", FONT))


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer(
        "mathml", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None)
    )
    app.connect("build-finished", copy_font)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
