"""Potentials of the traction: the only description of an interface that solvers and certificates
use.

The tangential problem is ``0 in W + M p + d phi(p)``. Here phi is radial in each
element: a disk (or interval) of the traction bound g, within which an interface
may also flow along the traction. The proximal map of phi is that of the size
``|p|``: first of the flow, then of the bound.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from varcontact.transports import along_rows, further_along

ROUNDING = 4 * float(np.finfo(float).eps)
"""Relative difference of a traction from its bound that counts as rounding."""


def magnitude(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (c, ...), with scaled components where their squares overflow."""
    if len(vectors) == 1:
        return np.abs(vectors[0])
    x, y = vectors
    if math.isfinite(np.vdot(vectors, vectors)):
        size: np.ndarray = np.sqrt(x * x + y * y)
        return size
    return np.asarray(np.hypot(x, y))


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products (...) of vectors (c, ...)."""
    product: np.ndarray = a[0] * b[0]
    for component in range(1, len(a)):
        product += a[component] * b[component]
    return product


def project(trial: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Projection of tractions (c, ...) on the disks, or the intervals, of a traction bound."""
    return _shortened(trial, magnitude(trial), bound)


def _shortened(trial: np.ndarray, size: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Tractions of a size, no longer than `most`."""
    beyond = size > most
    return trial * np.where(beyond, most / np.where(beyond, size, 1.0), 1.0)


@dataclass(frozen=True, eq=False)
class Flow:
    """A shift along the traction, ``(|p| - threshold)/hardening`` from a threshold on.

    It adds ``(|p| - threshold)_+^2/(2 hardening)`` to the potential. Where the threshold follows
    from the tractions themselves, in steady rolling, `columns` is the step in elements and the
    threshold that of fresh particles; else zero.
    """

    threshold: np.ndarray
    hardening: float
    columns: float = 0.0

    def sizes(self, size: np.ndarray, weight: float) -> np.ndarray:
        """Sizes of tractions from those of trial tractions ``p - E/weight``, before the bound
        limits them.
        """
        ratio = 1 / (self.hardening * weight)
        flowing = (size + ratio * self.threshold) / (1 + ratio)
        return np.where(size > self.threshold, flowing, size)

    def shift(self, traction: np.ndarray) -> np.ndarray:
        """The shift (c, ...) by which it flows under tractions."""
        size = magnitude(traction)
        beyond = np.maximum(size - self.threshold, 0.0) / self.hardening
        return np.asarray(traction * (beyond / np.where(size > 0, size, 1.0)))

    def tangent(self, traction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the shift by the traction, along it and across it; zero where nothing
        flows.
        """
        size = magnitude(traction)
        flows = size > self.threshold
        across = np.where(flows, 1 - self.threshold / np.where(flows, size, 1.0), 0.0)
        return flows / self.hardening, across / self.hardening

    def after(self, size: np.ndarray) -> np.ndarray:
        """The threshold with which particles arrive, raised along their rows by tractions of a size
        (ny, nx).
        """
        fresh = float(self.threshold.min())
        return further_along(along_rows(size, self.columns, fresh, np.maximum), self.columns, fresh)

    def under(self, trial: np.ndarray, bound: np.ndarray) -> Flow:
        """The flow with the threshold that trial tractions (c, ny, nx) raise along their rows."""
        if self.columns == 0:
            return self
        columns = max(self.columns, 1.0)
        # steps shorter than a column: several of them harden a particle while it crosses one
        hardening = self.hardening / min(self.columns, 1.0)
        fresh = float(self.threshold.min())
        ratio = 1 / hardening

        def hardened(before: np.ndarray, own: np.ndarray) -> np.ndarray:
            flowing = (own[0] + ratio * before[0]) / (1 + ratio)
            return np.maximum(before[0], np.minimum(flowing, own[1]))

        fields = np.array([magnitude(trial), bound])
        largest = along_rows(fields, columns, fresh, hardened)[0]
        return Flow(further_along(largest, columns, fresh), hardening)

    def on(self, elements: np.ndarray) -> Flow:
        """The flow of some elements."""
        return replace(self, threshold=self.threshold.ravel()[elements])


@dataclass(frozen=True, eq=False)
class FlowDerivative:
    """The derivative of a flow by tractions on a grid, as a product.

    `along` and `across` the traction (ny, nx), which has a direction (c, ny, nx). Where the
    traction `grows` (ny, nx) it is the threshold that particles have so many `columns` later.
    """

    columns: float
    along: np.ndarray
    across: np.ndarray
    direction: np.ndarray
    grows: np.ndarray

    def __call__(self, step: np.ndarray) -> np.ndarray:
        outward = np.sum(self.direction * step, axis=0)
        turned = (self.along - self.across) * outward
        if self.columns > 0:
            columns = max(self.columns, 1.0)
            fields = np.array([outward, self.grows])
            grown = along_rows(fields, columns, 0.0, _last_growing)
            turned = turned - self.along * further_along(grown[0], columns, 0.0)
        return np.asarray(turned * self.direction + self.across * step)


def _last_growing(before: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Change of the last traction on a particle's path that raised the threshold."""
    return np.where(own[1], own[0], before[0])


@dataclass(frozen=True, eq=False)
class Potential:
    """The potential phi in each element: the traction bound g, and the flow within it."""

    bound: np.ndarray
    flow: Flow | None = None

    def __and__(self, other: Potential) -> Potential:
        """Potential of both together, of which one at most flows: two flows would act in series,
        and no composition of their proximal maps gives that of both.
        """
        assert self.flow is None or other.flow is None, "one interface that flows"
        return Potential(np.minimum(self.bound, other.bound), self.flow or other.flow)

    @property
    def implicit(self) -> bool:
        """True where the potential depends on the tractions themselves: they raise the threshold of
        flow in steady rolling.
        """
        return self.flow is not None and self.flow.columns > 0

    def on(self, elements: np.ndarray) -> Potential:
        """The potential of some elements."""
        flow = self.flow
        if flow is not None:
            flow = flow.on(elements)
        return Potential(self.bound.ravel()[elements], flow)

    def sizes(self, size: np.ndarray, weight: float) -> np.ndarray:
        """Sizes of tractions from those of trial tractions ``p - E/weight``, before the bound
        limits them.
        """
        if self.flow is None:
            return size
        return self.flow.sizes(size, weight)

    def projected(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Tractions (c, ...) from trial tractions ``p - E/weight``: the proximal map of phi."""
        size = magnitude(trial)
        if self.flow is None:
            return _shortened(trial, size, self.bound)
        return _shortened(trial, size, np.minimum(self.flow.sizes(size, weight), self.bound))

    def slips(self, trial: np.ndarray, weight: float) -> np.ndarray:
        """Mask of the trial tractions ``p - E/weight`` that are beyond the bound."""
        beyond: np.ndarray = self.sizes(magnitude(trial), weight) > self.bound
        return beyond

    def flowed(self, traction: np.ndarray) -> np.ndarray | float:
        """The shift (c, ...) that flows within the bound."""
        if self.flow is None:
            return 0.0
        return self.flow.shift(traction)

    def shares(self, traction: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """Shares of the elements in the duality gap, ``p'E + phi(p) + phi*(-E)``, (n,), without its
        cancellation.

        Without a flow ``g |E| + p'E = (g - |p|) |E| + (|p| |E| + p'E)``. Where the traction goes
        against the shift, the second part is the square of their vector product divided by ``|p|
        |E| - p'E``: it shows a traction turned by 1e-9, though the cosine of that is one. Where it
        flows, the square of the difference between ``|p|`` and ``threshold + k |E|``, divided by
        2 k.
        """
        size = magnitude(traction)
        length = magnitude(shift)
        # |p| |E| + p'E
        inner = dot(traction, shift)
        product = size * length
        turned = product + inner
        if len(traction) == 2:
            cross = traction[0] * shift[1] - traction[1] * shift[0]
            against = inner < 0
            small = cross * (cross / np.where(against, product - inner, 1.0))
            turned = np.where(against, small, turned)
        # the rest without a flow, by the slack of the bound
        if self.flow is None:
            return np.asarray(_slack(self.bound, size) * length + turned)
        # with a flow, by the slack of the hardened threshold and the error of the flow
        k = self.flow.hardening
        threshold = self.flow.threshold
        hardened = np.minimum(k * length, np.maximum(self.bound - threshold, 0.0))
        excess = size - threshold
        beyond = (hardened - np.maximum(excess, 0.0)) ** 2
        below = 2 * hardened * np.maximum(-excess, 0.0)
        slack = _slack(np.minimum(self.bound, threshold + hardened), size)
        slip = np.where(length > hardened / k, length - hardened / k, 0.0)
        return np.asarray(slack * slip + (beyond + below) / (2 * k) + turned)


def _slack(bound: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Differences between a bound and sizes of tractions; zero for rounding."""
    with np.errstate(invalid="ignore"):  # infinite bounds
        slack = bound - size
        return np.where(np.abs(slack) <= ROUNDING * bound, 0.0, slack)
