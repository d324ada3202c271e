"""Solution as a self-contained web page: values, picture, certificate, scene and command."""

from __future__ import annotations

import base64
import io
from dataclasses import replace
from html import escape
from typing import TYPE_CHECKING

from varcontact.errors import SceneError
from varcontact.io.scene_toml import scene_text

if TYPE_CHECKING:
    from varcontact.results.solution import Solution

HEAD = b"<!DOCTYPE html>\n<!-- varcontact report 1 -->\n"
STYLE = """body { font-family: sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }
pre { background: #f3f3f3; padding: 1em; white-space: pre-wrap; } img { max-width: 100%; }"""


def html_page(sol: Solution) -> bytes:
    """The page, see `Solution.to_html`."""
    from varcontact.plotting.solution import plot
    from varcontact.results.report import headline

    picture = io.BytesIO()
    plot(sol).savefig(picture, format="png", dpi=150, bbox_inches="tight")
    image = base64.b64encode(picture.getvalue()).decode()
    title = escape(headline(sol))
    # the command that solves it again
    scene = sol.scene
    accuracy = None
    if sol.error_estimate is not None:
        accuracy = sol.error_estimate.accuracy
    options = f"--normal {sol.plan.normal}"
    if sol.plan.has_friction:
        options += f" --tangential {sol.plan.tangential}"
    if accuracy is not None:
        options = f"--accuracy {accuracy:g}"
    try:
        if accuracy is not None:
            scene = replace(scene, grid="auto")
        text = scene_text(scene)
        repeat = f"<p>To repeat it, save this scene as scene.toml:</p><pre>{escape(text)}</pre>"
        repeat += f"<pre>varcontact solve scene.toml {escape(options)} --plot picture.png</pre>"
    except SceneError as error:
        repeat = f"<p>The scene cannot be shown as a file: {escape(str(error))}</p>"
    body = [
        f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>',
        f"<style>{STYLE}</style></head><body><h1>{title}</h1>",
        f'<img alt="pressure, tractions, stick and slip" src="data:image/png;base64,{image}">',
        f"<pre>{escape(sol.report())}</pre>",
        f"<h2>Scene</h2>{repeat}",
        "</body></html>\n",
    ]
    return HEAD + "\n".join(body).encode()
