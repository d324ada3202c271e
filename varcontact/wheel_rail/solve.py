"""All patches of a wheel on a rail, and the height of its axle that carries the load."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from varcontact import checks
from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, PlausibilityWarning, SceneError, VarcontactError
from varcontact.scene.plausibility import warn_plausibility
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.solving.options import DEFAULT_ACCURACY, CertifyName, Target
from varcontact.solving.side_by_side import with_tractions_batched
from varcontact.system.process import one_blas_thread
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.patch_warnings import noisy_patches, warn_of_noise, warn_of_patches
from varcontact.wheel_rail.plausibility import warnings_of
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.solve_to_target import to_target
from varcontact.wheel_rail.wheel_geometry import WheelGeometry
from varcontact.wheel_rail.wheel_on_elements import (
    Start,
    WheelOnElements,
)

SIDE_BY_SIDE = 32
"""Largest number of parts of a sweep whose tractions are solved side by side."""
TARGETS = ("accuracy", "time_budget")
Answer = tuple[int, WheelRailSolution | VarcontactError]
"""Number of a wheel, and its solution or the error that refuses it."""


def solve_wheel_on_rail(
    case: WheelGeometry, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelRailSolution:
    """See `WheelOnRail.solve`; `methods` has the arguments of `varcontact.solve`."""
    warn_plausibility(warnings_of(case))
    rough: list[str] = []

    def on_first(first: WheelRailSolution) -> None:
        if not rough:
            rough.extend(noisy_patches(first))
            warn_of_noise(rough)

    ((_, found),) = solve_wheels_on_rails([case], tol, certify, on_first, **methods)
    if isinstance(found, VarcontactError):
        raise found
    if not rough:
        warn_of_noise(noisy_patches(found))
    warn_of_patches(found)
    return found


def solve_wheels_on_rails(
    cases: Sequence[WheelGeometry],
    tol: float = 1e-6,
    certify: CertifyName | None = None,
    on_first: Callable[[WheelRailSolution], None] = lambda first: None,
    **methods: Any,
) -> Iterator[Answer]:
    """The numbers of cases, and their solutions or what refuses them, as they are found, without
    `warn_of_patches`.

    `on_first` is given the first, rough solution of each where grids are chosen: before time is
    spent on finer ones. Parts of them are solved side by side, with all tractions at a time; within
    a part each begins from the one before.
    """
    methods["certify"] = certify
    together = len(cases) > 1 and methods.keys().isdisjoint(("tangential", "method", "formulation"))
    going = [_Series(part, tol, methods, on_first) for part in _parts(cases)]
    while going:
        with without_plausibility_warnings():
            # pressures at the next height of each
            contacts: list[ContactOnGrid] = []
            counts: list[int] = []
            for each in going:
                own = each.propose()
                contacts += own
                counts.append(len(own))
            # tractions of all
            remaining = iter(with_tractions_batched(contacts) if together else contacts)
            # forces, from which the next heights follow
            for each, count in zip(going, counts, strict=True):
                each.learn(list(islice(remaining, count)))
        for each in going:
            yield from each.new_answers()
        going = [each for each in going if not each.done]


def _parts(cases: Sequence[WheelGeometry]) -> list[dict[int, WheelGeometry]]:
    """Cases by their numbers in parts that are solved side by side, those of one side together."""
    if not cases:
        return []
    order = sorted(range(len(cases)), key=lambda k: cases[k].side)
    parts = np.array_split(order, min(SIDE_BY_SIDE, len(cases)))
    return [{k: cases[k] for k in part.tolist()} for part in parts]


@contextmanager
def without_plausibility_warnings() -> Iterator[None]:
    """Context without plausibility warnings of the patches' scenes, which `warn_of_patches` gives
    once each.
    """
    with one_blas_thread(), catch_warnings():
        simplefilter("ignore", PlausibilityWarning)
        yield


class _Series:
    """Wheels that are solved one after the other, each from the one before.

    `propose` gives contacts of one of them, and `learn` takes them back with tractions, until
    `done`. A wheel whose grids are chosen is solved at once.
    """

    def __init__(
        self,
        cases: dict[int, WheelGeometry],
        tol: float,
        methods: dict[str, Any],
        on_first: Callable[[WheelRailSolution], None],
    ) -> None:
        self._left = deque(cases.items())
        self._tol = tol
        self._methods = methods
        self._on_first = on_first
        self._answers: dict[int, WheelRailSolution | VarcontactError] = {}
        # start of the next wheel
        self._start: Start | None = None
        # the wheel in progress
        self._number = -1
        self._wheel: WheelOnElements | None = None
        self._in_plane: WheelOnElements | None = None

    @property
    def done(self) -> bool:
        return self._wheel is None and not self._left

    def new_answers(self) -> list[Answer]:
        """Numbers and solutions, or errors, since the last call."""
        found = list(self._answers.items())
        self._answers.clear()
        return found

    def propose(self) -> list[ContactOnGrid]:
        """Contacts with pressures whose tractions are to be solved next; none where a wheel
        ends.
        """
        try:
            if self._wheel is None:
                self._begin()
            while self._wheel is not None:
                contacts = self._wheel.propose()
                if contacts:
                    return contacts
                self._after(self._wheel)
        except VarcontactError as error:
            self._refuse(error)
        return []

    def learn(self, contacts: list[ContactOnGrid]) -> None:
        """Pass the solved contacts on to the wheel that proposed them."""
        if self._wheel is None:
            return
        try:
            self._wheel.learn(contacts)
        except VarcontactError as error:
            self._refuse(error)

    def _begin(self) -> None:
        """Begin the next wheel."""
        self._number, case = self._left.popleft()
        tol = checks.positive("tol", self._tol)
        target = _target(case, self._methods)
        methods = {name: value for name, value in self._methods.items() if name not in TARGETS}
        start = self._start
        if isinstance(methods.get("start"), WheelRailSolution):
            start = Start(methods.pop("start"))
        if target is None:
            self._wheel = WheelOnElements(case, tol, methods, start)
            return
        self._answer(to_target(case, tol, methods, target, self._on_first), [])

    def _after(self, wheel: WheelOnElements) -> None:
        """Record the answer of a wheel, or solve it again on a curved surface if its contact is too
        wide for a plane.
        """
        solution = wheel.solution()
        case = solution.case
        flat = case.plane_or_curved and not wheel.by_theory
        if flat and any(solution.too_wide):
            self._in_plane = wheel
            self._wheel = wheel.curved()
        else:
            self._answer(solution, wheel.operators)

    def _refuse(self, error: VarcontactError) -> None:
        """Record an error as the answer, or the solution in a plane if there is none on a curved
        surface.
        """
        flat = self._in_plane
        if flat is not None and isinstance(error, NotConverged | SceneError):
            # a profile that turns too fast or is too rough: the plane's warning remains
            self._answer(flat.solution(), flat.operators)
            return
        self._answers[self._number] = error
        self._end()

    def _answer(self, solution: WheelRailSolution, operators: Sequence[Operators]) -> None:
        """Record a solution, which is also the start of the next wheel."""
        self._start = Start(solution, operators)
        self._answers[self._number] = solution
        self._end()

    def _end(self) -> None:
        self._wheel = None
        self._in_plane = None


def _target(case: WheelGeometry, methods: dict[str, Any]) -> Target | None:
    """Accuracy or time for which grids are chosen: as given, or the default where nothing else
    determines the grids; None where something does.
    """
    check_methods(case, methods)
    theory = methods.get("tangential") in THEORIES
    given = {name: methods[name] for name in TARGETS if methods.get(name) is not None}
    if given:
        return Target(**given)
    exact = not theory and methods.get("formulation") != "marching"
    has_friction = not isinstance(case.friction, float) or 0 < case.friction < np.inf
    free = case.dx is None and case.dy is None and methods.get("start") is None
    if exact and has_friction and free:
        return Target(DEFAULT_ACCURACY, by_default=True)
    return None


def check_methods(case: WheelGeometry, methods: dict[str, Any]) -> None:
    """Refuse methods that wheels do not have, or that do not suit the elements of this one."""
    theory = methods.get("tangential") in THEORIES
    checks.gone("refine", methods.get("refine"), checks.REFINE_BECAME)
    if methods.get("store") is not None:
        raise SceneError("store", methods["store"], "left out: it is for histories of steps")
    if case.curved and theory:
        reason = (
            "tangential: theories are for ellipses in a plane; "
            "leave it out, or give conformal = False"
        )
        raise SceneError("tangential", methods["tangential"], message=reason)
    target = {name: methods[name] for name in TARGETS if methods.get(name) is not None}
    if target:
        checks.exactly_one(**target)
    for name, value in target.items():
        checks.positive(name, value)
        for side in ("dx", "dy"):
            if getattr(case, side) is not None:
                reason = (
                    f"{side}: the grids are chosen for the {name}; leave dx and dy out, or {name}"
                )
                raise SceneError(side, getattr(case, side), message=reason)
        if theory:
            reason = (
                f"tangential: a theory has an error that no grid removes; leave it out, or {name}"
            )
            raise SceneError("tangential", methods["tangential"], message=reason)
