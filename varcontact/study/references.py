"""Continuum values of many scenes, with error bars, against which the errors of answers are
measured.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from varcontact import checks
from varcontact.data.benchmark_scenes import reference_scenes
from varcontact.errors import SceneError
from varcontact.results.quantities_of_interest import error, units
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.solve import solve
from varcontact.system.files import text_of

VERSION = 1
"""Version of the file of references."""
COMMAND = "python -m tests.benchmarks.references"
FILE = "references.json"
OWN_ACCURACY = 1e-3
"""Accuracy of the reference values of users' own scenes."""
STEPS = (0, 5, 11)
"""The steps of histories whose values are kept."""


@dataclass(frozen=True, eq=False)
class ContinuumValues:
    """A scene, and the continuum values of its answers.

    Attributes
    ----------
    scene : Scene
        Without a grid of its own.
    values : dict of str to float
        Forces and moment; creepages where forces are prescribed; approach and
        largest pressure of normal contact; areas. Of a history by step, as
        ``Fx[5]``. In the scene's units.
    bars : dict of str to float
        Half the widths of their 95 % intervals.
    units : dict of str to float
        The size of an error of one, of the values that count
        (`varcontact.results.quantities_of_interest`); not of areas.
    kind : str
        Class of the scene.
    how : str
        Where the values are from.
    steps : tuple of int
        Steps of a history that count.
    """

    scene: Scene
    values: dict[str, float]
    bars: dict[str, float]
    units: dict[str, float]
    kind: str
    how: str
    steps: tuple[int, ...] = ()

    @property
    def bar(self) -> float:
        """The largest error bar of the values that count, in their units."""
        return max(self.bars[name] / unit for name, unit in self.units.items())

    @checks.named_options()
    def error(self, found: Mapping[str, float]) -> float:
        """The error of an answer: the largest of the errors of its values `found`, in their units;
        NaN if one is missing.
        """
        return error(found, {name: self.values[name] for name in self.units}, self.units)


@checks.named_options()
def continuum_values(
    path: str | Path | Scene | None = None, *, accuracy: float = OWN_ACCURACY
) -> dict[str, ContinuumValues]:
    """Scenes by name with their continuum values, from the package's own file.

    Parameters
    ----------
    path : str, Path or Scene, optional
        Another file, made by ``python -m tests.benchmarks.references`` in the
        repository; or a scene of one's own, without a grid, which is solved to
        an accuracy, and is called "scene".
    accuracy : float
        Accuracy to which a scene of the user is solved: its estimated errors are the bars.

    Returns
    -------
    dict of str to ContinuumValues

    Raises
    ------
    SceneError
        If the file is none of references, or of another version of them; for a
        scene that `solve` takes no accuracy for.

    Examples
    --------
    >>> import varcontact as vc
    >>> bank = vc.continuum_values()
    >>> carter = bank["line, creepage 0.3"]
    >>> print(len(bank) >= 60, f"{carter.values['Fx'] / 0.3:.4f}", carter.bar < 1e-5)
    True -0.5100 True
    """
    if isinstance(path, Scene):
        return {"scene": _of_own_scene(path, accuracy)}
    if path is None:
        return dict(read(files("varcontact.data").joinpath(FILE).read_text(encoding="utf-8"), FILE))
    name = checks.file_name("path", path)
    return dict(read(text_of("path", name, kind="a file of references"), str(name)))


def _of_own_scene(scene: Scene, accuracy: float) -> ContinuumValues:
    """Values of a scene by a solve to an accuracy, with its error bars."""
    solution: Any = solve(scene, accuracy=accuracy)
    estimate = solution.error_estimate
    steps = steps_of(scene)
    return ContinuumValues(
        scene=scene,
        values=estimate.values,
        bars=estimate.bars,
        units=units(solution, steps or None),
        kind="scene of one's own",
        how=f"accuracy={accuracy:g}",
        steps=steps,
    )


Reference = ContinuumValues
references = continuum_values
"""The names of earlier versions."""


@cache
def read(text: str, name: str) -> dict[str, ContinuumValues]:
    """References from the text of the file `name`."""
    try:
        content = json.loads(text)
        version = content["version"]
        entries = content["references"]
    except (ValueError, KeyError, TypeError):
        raise _refused(name, "is no file of references") from None
    if version != VERSION:
        raise _refused(name, f"is of version {version}, and version {VERSION} is read")
    scenes = reference_scenes()
    other = set(entries) ^ set(scenes)
    if other:
        raise _refused(
            name, f"was made for other scenes than this version has, {min(other)!r} for one"
        )
    bank = {}
    for each, entry in entries.items():
        kind, scene = scenes[each]
        bank[each] = ContinuumValues(
            scene=scene,
            values=entry["values"],
            bars=entry["bars"],
            units=entry["units"],
            kind=kind,
            how=entry["how"],
            steps=steps_of(scene),
        )
    return bank


def steps_of(scene: Scene) -> tuple[int, ...]:
    """The steps of a history that count."""
    return STEPS if isinstance(scene.motion, Transient) else ()


def _refused(name: str, what: str) -> SceneError:
    message = f"{name} {what}; make it again: {COMMAND}"
    return SceneError("references", name, "a file of references of this version", message=message)
