"""Cases of CONTACT's input files, modules 1 and 3, as written: control digits and entries,
including those kept from the previous case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from varcontact.errors import SceneError
from varcontact.io.contact_grammar import (
    BASIC,
    BASIC_LINES,
    WHEEL,
    WHEEL_LINES,
    Controls,
)
from varcontact.io.contact_words import Group, Lines

GRAMMARS: dict[int, Any] = {1: (WHEEL, WHEEL_LINES), 3: (BASIC, BASIC_LINES)}
"""Control words and parameter lines of the modules that are read."""
STAYS = (0, 2)
"""Values of the digit R after which the next case belongs to the same module without naming it."""
MODULES = {1: "wheel on rail", 3: "basic contact", 0: "stop"}
MODULE_NUMBERS = tuple(map(str, MODULES))
"""Module numbers as text; control words have more digits."""


@dataclass(frozen=True, eq=False)
class CaseInput:
    """One case of an input file.

    `entries` are those of the case and those that it keeps; `given` are the keys of its own.
    """

    number: int  # in the file, from 1
    module: int
    element: tuple[int, ...]  # the result element, and its contact patch
    group: Group  # the line of its module
    controls: Controls
    entries: Mapping[str, Any]
    given: frozenset[str]
    before: CaseInput | None  # of the same result element

    @property
    def calculated(self) -> bool:
        """True unless the case is skipped."""
        return self.controls["RETURN"] <= 1

    @property
    def stress_points(self) -> tuple[Group, ...]:
        """Blocks of points of S = 1 to 3, given or kept."""
        stress = self.controls["STRESS"]
        if stress == 0:
            return ()
        groups: tuple[Group, ...] = tuple(self.entries.get("stresses", ()))
        if stress < 3 and len(groups) < 2:  # the first has digits of output
            why = "keeps the points of the case before, and there are none: use S = 3"
            self.controls.complain("STRESS", why)
        return groups

    @property
    def damped(self) -> bool:
        """True for M2 = 2, or for M2 = 1 after a case that is damped.

        CONTACT prints forces without those of damping, which affect only wheels under given forces.
        """
        if self.controls.damping == 1:
            return self.before is not None and self.before.damped
        return self.controls.damping == 2

    def needs(self, key: str, digit: str, what: str, remedy: str) -> Any:
        """An entry, given or kept; a digit is refused where no case gives it."""
        if key not in self.entries:
            self.controls.complain(
                digit, f"keeps {what} of the case before, and there is none: use {remedy}"
            )
        return self.entries[key]


@dataclass(frozen=True, eq=False)
class Unreadable:
    """Case that does not follow the grammar, and the reason."""

    number: int
    line: int
    error: SceneError


def read_cases(path: Path) -> tuple[list[CaseInput], list[Unreadable]]:
    """Cases of a file, and those that cannot be read; reading resumes at the next MODULE, with
    nothing kept.
    """
    lines = Lines(path)
    cases: list[CaseInput] = []
    unreadable: list[Unreadable] = []
    last: dict[tuple[int, ...], CaseInput] = {}
    stays = False
    while lines.left:
        number = len(cases) + len(unreadable) + 1
        line = lines.left[0][0]
        try:
            if not stays or lines.left[0][1][0] in MODULE_NUMBERS:
                group = lines.read("MODULE:i, [REID:i, CPID:i]")
                element = _element(group)
            group = replace(group, line=line)
            if element is None:
                break
            case = _read_case(lines, group, number, element, last.get(element))
        except SceneError as error:
            unreadable.append(Unreadable(number, line, error))
            last.clear()
            stays = False
            lines.skip_to("MODULE")
            continue
        last[element] = case
        stays = case.controls["RETURN"] in STAYS
        cases.append(case)
    return cases, unreadable


def _element(group: Group) -> tuple[int, ...] | None:
    """Module, result element and contact patch; None at the stop."""
    module = group.integers()[0]
    if module == 0:
        return None
    if module not in GRAMMARS:
        supported = ", ".join(f"{each} ({words})" for each, words in MODULES.items())
        group.refuse("MODULE", module, f"is not supported; supported: {supported}")
    return (module, *map(int, group.optional))


def _read_case(
    lines: Lines, group: Group, number: int, element: tuple[int, ...], before: CaseInput | None
) -> CaseInput:
    module, *of_element = element
    words, parameters = GRAMMARS[module]
    controls = Controls(words, lines)
    entries: dict[str, Any] = {}
    if before is not None:
        entries |= before.entries
    given = set[str]()
    try:
        _read_entries(lines, controls, parameters, entries, given)
    except SceneError:
        controls.check_supported()  # an unsupported digit is then the cause
        raise
    return CaseInput(
        number, module, tuple(of_element), group, controls, entries, frozenset(given), before
    )


def _read_entries(
    lines: Lines, controls: Controls, parameters: Any, entries: dict[str, Any], given: set[str]
) -> None:
    """Put the entries of a case among those that it keeps."""
    for line in parameters:
        if not line.given(controls) or (line.key == "distance" and _is_hertzian(entries)):
            continue
        entries[line.key] = line.read(lines, controls, entries)
        given.add(line.key)


def _is_hertzian(entries: Mapping[str, Any]) -> bool:
    """True where IPOTCN < 0 gives the undeformed distance, too."""
    return "elements" in entries and entries["elements"][0].integers()[0] < 0
