"""Run what the site shows: every example with its pictures, and every page that shows what its own
code draws.

Examples get a page each, and an index, in the folder gallery; pages find their pictures in
made/pages/<name of the page>, where the tests leave them, as they leave those of examples that they
run as the gallery does. What has not changed since it was run is not run again; without these two
folders everything is.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.image
import numpy as np

import pages

if TYPE_CHECKING:
    from sphinx.application import Sphinx

DOCS = Path(__file__).parents[1]
EXAMPLES = DOCS.parent / "examples"
BAND = 0.008
"""Width of the blank bands that separate panels from each other and from their labels, per side of
the picture."""
PRINTED = 10
"""Lines of output that a page shows at most."""
GROUPS = {
    "Figures of the paper": r"fig.*\.py",
    "More examples": r"(?!fig).*\.py",
    "Scene files": r".*\.toml",
}
# in the folder pictures: these examples take minutes
PICTURES_OF_FULL_RUNS = {"rail_profile": "rail_profile.png", "sampling": "sampling.png"}
SMALLER: dict[str, dict[str, Any]] = {
    "compare_bank": {
        "picture": "compare_bank.png",
        "cells": 6,
        "methods": ("convex", "active-set", "clarabel", "scs", "tang"),
    },
    "asperity_field": {"cells": 5},
    "coated_sphere": {"cells": 16},
    "corrugation": {"cells": 14, "waves": 13},
    "coupling_loops": {
        "cells": 12,
        "frictions": (0.01, 0.1, 2.0),
        "unlikeness": (0.0, 0.2, 0.5),
    },
    "crowned_roller": {"rows": 24},
    "falling_friction": {"cells": 40, "points": 9},
    "fig22_to_24_creep_forces": {"cells": 10, "points": 7, "elements": 50},
    "fig27_to_29_unlike_cylinders": {"cells": 100},
    "fig30_to_33_rolling_cylinders": {"cells": 40},
    "fig34_spheres": {"cells": 13},
    "fig36_37_rolling_spheres": {"cells": 1},
    "gauge_corner_rolling": {
        "picture": "gauge_corner_rolling.png",
        "half_widths": (3.0,),
        "step": 0.8,
        "waves": 9,
    },
    "fitted_creep_curve": {"cells": 6, "points": 6},
    "spence_indentation": {"cells": 20, "presses": 12},
    "temperature": {"cells": 16, "points": 8},
    "theories_bank": {"cells": 12},
    "viscoelastic_roller": {"cells": 60, "speeds": 7},
    "wheel_flat": {"speeds": (10.0, 40.0), "steps": 90},
    "wheel_set": {"exact_at": (0.0, 4.0, 8.0), "distance": 30e3},
}
"""Arguments of the examples that take longer than a few seconds: those of the tests, which leave
them for the site."""
CARD_PANELS = {
    "aluminium_on_steel": 1,
    "fig21_spin": 1,
    "spheres_shift": 2,
    "wheel_on_rail": 1,
    "temperature": 2,
    "pin_in_hole": 1,
}
"""Panels that cards show where it is not the first one, which for several would be a pressure."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}


@dataclass(frozen=True)
class Work:
    """A command to be run in a folder of its own, and the text on which what it makes depends."""

    words: tuple[str, ...]
    folder: Path
    text: str

    def done(self) -> str:
        """Run, unless it has been; its standard output."""
        stamp, output = self.folder / "stamp", self.folder / "output.txt"
        digest = pages.stamp(self.text)
        if not (stamp.exists() and stamp.read_text() == digest):
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder.mkdir(parents=True)
            environment = {**os.environ, **ONE_THREAD}
            result = subprocess.run(
                self.words, cwd=self.folder, env=environment, capture_output=True, text=True
            )
            if result.returncode:
                raise RuntimeError(f"{' '.join(self.words)} failed:\n{result.stderr}")
            output.write_text(result.stdout)
            stamp.write_text(digest)
        return output.read_text()

    def leave(self, output: str, pictures: list[Path]) -> None:
        """Keep what the same call printed and drew elsewhere, so that it is not run again."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        for picture in pictures:
            shutil.copy(picture, self.folder)
        (self.folder / "output.txt").write_text(output)
        (self.folder / "stamp").write_text(pages.stamp(self.text))


@dataclass(frozen=True)
class Example:
    """A script or a scene that tells its story at its head: a title, what is to be seen, and how to
    run it.
    """

    path: Path

    @property
    def name(self) -> str:
        return self.path.stem

    @property
    def head(self) -> str:
        text = self.path.read_text()
        if self.path.suffix == ".py":
            return ast.get_docstring(ast.parse(text)) or ""
        comments = re.match(r"(?:#.*\n)*", text)
        return re.sub(r"^# ?", "", comments[0] if comments else "", flags=re.MULTILINE)

    @property
    def title(self) -> str:
        """The beginning of the first sentence, after the number of a figure."""
        found = re.match(r"(?:Kalker's )?((?:Figs?\. [^:]*: )?.*?)[,:.](?:\s|$)", self.head)
        assert found, f"{self.path} has to begin with a sentence"
        return found[1][0].upper() + found[1][1:]

    @property
    def story(self) -> str:
        return re.sub(r"\s+Run: .*?(?:\n\n|\Z)", "\n\n", self.head, flags=re.DOTALL).strip()

    @property
    def arguments(self) -> str:
        """Those of `main` where it is run smaller, as they are written in a call."""
        return ", ".join(f"{name}={value!r}" for name, value in SMALLER.get(self.name, {}).items())

    def work(self, made: Path) -> Work:
        """Running it, with pictures in its folder."""
        if self.path.suffix == ".toml":
            words: tuple[str, ...] = (
                "-m",
                "varcontact",
                "solve",
                str(self.path),
                "--plot",
                f"{self.name}.png",
            )
        elif self.name in SMALLER:
            calling = (
                f"import sys; sys.path.insert(0, {str(EXAMPLES)!r}); import {self.name} as example"
            )
            words = ("-c", f"{calling}; example.main({self.arguments})")
        else:
            words = (
                str(self.path),
                *([f"{self.name}.png"] if "[picture.png]" in self.head else []),
            )
        return Work(
            (sys.executable, *words),
            made / "examples" / self.name,
            "".join(words) + self.path.read_text(),
        )

    def page(self, output: str, pictures: list[str]) -> str:
        """Its page, in the folder gallery."""
        code = "toml" if self.path.suffix == ".toml" else "python"
        shown = "\n\n".join(f"![{self.title}]({picture})" for picture in pictures)
        lines = (
            "\n".join(line for line in output.splitlines() if not line.startswith("picture: "))
            .strip()
            .splitlines()
        )
        printed = "\n".join(lines if len(lines) <= PRINTED else [*lines[:PRINTED], "..."])
        smaller = f"Run here as `main({self.arguments})`.\n\n" if self.name in SMALLER else ""
        return (
            f"# {self.title}\n\n{self.story}\n\n{smaller}{shown}\n\n"
            + (f"## Printed\n\n```text\n{printed}\n```\n\n" if printed else "")
            + f"## Code\n\n{{download}}`{self.path.name} <../../examples/{self.path.name}>`\n\n"
            f"```{{literalinclude}} ../../examples/{self.path.name}\n:language: {code}\n```\n"
        )


def examples(pattern: str) -> list[Example]:
    """Those whose file names match."""
    return [
        Example(path) for path in sorted(EXAMPLES.iterdir()) if re.fullmatch(pattern, path.name)
    ]


def card(example: Example, picture: str | None) -> str:
    """Its card in the index."""
    image = f":img-top: {picture}\n" if picture else ""
    head = f":::{{grid-item-card}} {example.title}\n:link: {example.name}\n"
    return f"{head}:link-type: doc\n{image}:::\n"


def panel(picture: np.ndarray, number: int = 0) -> np.ndarray:
    """A large panel of a picture, cut out at blank bands; the first, or another one of its row."""
    band = BAND * min(picture.shape[:2])
    for axis, wanted in ((1, number), (0, 0), (1, 0), (0, 0)):
        inked = np.flatnonzero((picture[..., :3] < 0.97).any(axis=(2, 1 - axis)))
        ends = np.flatnonzero(np.diff(inked) > band)
        begins, ends = inked[[0, *(ends + 1)]], inked[[*ends, -1]] + 1
        sizes = ends - begins
        large = np.flatnonzero(sizes > 0.5 * sizes.max())
        first = int(large[min(wanted, large.size - 1)])
        picture = picture.take(range(begins[first], ends[first]), axis)
    return picture


def show(example: Example, made: Path, gallery: Path) -> str:
    """Run an example and write its page; its card."""
    if example.name in PICTURES_OF_FULL_RUNS:
        output, pictures = "", [f"../pictures/{PICTURES_OF_FULL_RUNS[example.name]}"]
    else:
        output = example.work(made).done()
        pictures = [
            f"../made/examples/{example.name}/{each.name}"
            for each in sorted((made / "examples" / example.name).glob("*.png"))
        ]
    write(gallery / f"{example.name}.md", example.page(output, pictures))
    if not pictures:
        return card(example, None)
    thumbnail = made / "thumbnails" / f"{example.name}.png"
    thumbnail.parent.mkdir(parents=True, exist_ok=True)
    picture = matplotlib.image.imread(gallery / pictures[0])
    matplotlib.image.imsave(thumbnail, panel(picture, CARD_PANELS.get(example.name, 0)))
    return card(example, f"../made/thumbnails/{example.name}.png")


def write(path: Path, text: str) -> None:
    """Write a page that has changed, so that no other is read again."""
    if not (path.exists() and path.read_text() == text):
        path.write_text(text)


def drawing_pages() -> Iterator[Path]:
    """Pages whose own code draws what they show."""
    for page in sorted(DOCS.rglob("*.md")):
        if "gallery" not in page.parts and f"made/pages/{page.stem}/" in page.read_text():
            yield page


def page_work(page: Path, made: Path) -> Work:
    return Work(
        (sys.executable, pages.__file__, str(page), "."),
        made / "pages" / page.stem,
        page.read_text(),
    )


def make(app: Sphinx) -> None:
    made, gallery = Path(app.srcdir, "made"), Path(app.srcdir, "gallery")
    gallery.mkdir(exist_ok=True)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        drawn = [pool.submit(page_work(page, made).done) for page in drawing_pages()]
        cards = {
            group: [pool.submit(show, example, made, gallery) for example in examples(pattern)]
            for group, pattern in GROUPS.items()
        }
        for each in drawn:
            each.result()
        index = "# Gallery\n\nEach picture is made by running the example that its page shows.\n"
        for group, found in cards.items():
            index += f"\n## {group}\n\n::::{{grid}} 1 2 3 3\n:gutter: 3\n\n"
            index += "\n".join(each.result() for each in found) + "\n::::\n"
    names = "\n".join(example.name for pattern in GROUPS.values() for example in examples(pattern))
    write(gallery / "index.md", f"{index}\n```{{toctree}}\n:hidden:\n\n{names}\n```\n")


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
