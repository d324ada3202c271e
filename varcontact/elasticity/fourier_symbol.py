"""Compliances by wave number: harmonics of the direction, and poles over the wave number.

Fields that vary as ``exp(i k.x)`` have ``u = f(k) q``, f a Hermitian matrix. With the size k and
the direction theta of the wave vector,

    k f = k^degree F(theta) + sum_j F_j(theta) b_j / sqrt(k^2 + b_j^2),

F the compliance of short waves. Each harmonic of F and F_j has a kernel in closed form: see
`varcontact.elasticity.symbol_medium`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.scene.given_bodies import Numbers
from varcontact.system.process import lazy_property

DECADES = (-4.0, 4.0)
"""Powers of ten, in units of 1/scale, of the wave numbers at which a symbol is sampled."""
SAMPLES_BY_DECADE = 40
POLES = (-4.0, 3.0)
"""Powers of ten of the poles."""
POLES_BY_DECADE = 16
"""Poles per decade. With 8, 12 and 16, layered bodies on a rigid base are fitted to 1e-5, 5e-8 and
2e-9 of their largest compliance, others better."""
FIT_ERROR = 1e-5
"""Largest error of a fit, relative to the largest compliance; beyond it a symbol is refused."""
AT_REST = 1e-6
"""k f at the longest waves, relative to that of short waves, below which it counts as zero."""
DIRECTIONS_MIN = 16
DIRECTIONS_MAX = 512
SMALL_HARMONIC = 1e-13
"""Size of a harmonic, relative to the largest compliance, below which it is left out."""
MIRRORED = 1e-12
"""Difference from the mirror image, relative to the largest compliance, that counts as rounding."""
TOLERANCE = 1e-9
"""Largest departure from the properties of every elastic body, relative to the largest compliance
at that wave number."""
GROWTH = 1.05
"""Growth of k f over the last decade of wave numbers, towards 0 or infinity, above which a symbol
is refused."""

Function = Callable[[np.ndarray, np.ndarray], Any]


@dataclass(frozen=True)
class FourierSymbol:
    """A fitted symbol; complex numbers are pairs in the last axis.

    Attributes
    ----------
    limit : (M + 1, 3, 3, 2)
        Harmonics 0 to M of F [1/stress].
    degree : float
        In [0, 1): the power of k.
    poles : (n,)
        The b_j, positive [1/length].
    parts : (n, M + 1, 3, 3, 2)
        Harmonics of the F_j.
    local : (3,)
        Diagonal compliance of springs, which act at their own place [length/stress].
    """

    limit: Numbers
    degree: float = 0.0
    poles: Numbers = field(default_factory=lambda: Numbers.of(np.zeros(0)))
    parts: Numbers = field(default_factory=lambda: Numbers.of(np.zeros((0, 1, 3, 3, 2))))
    local: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        arrays = (self.limit, self.poles, self.parts)
        if not all(isinstance(each, Numbers) for each in arrays):
            raise SceneError("bodies.symbol", "a table", "as varcontact wrote it")
        shape = self.limit.array.shape
        expected = (self.poles.array.size, *shape)
        fits = self.poles.array.ndim == 1 and self.parts.array.shape == expected
        if self.poles.array.size == 0:
            fits = True
        if len(shape) != 4 or shape[1:] != (3, 3, 2) or not fits:
            raise SceneError("bodies.symbol", "a table", "of arrays whose shapes go together")
        object.__setattr__(self, "local", tuple(self.local))

    @classmethod
    def of(
        cls, function: Function, scale: float, local: tuple[float, float, float]
    ) -> FourierSymbol:
        """Symbol of a function (kx, ky) -> (n, 3, 3), after checks of its values."""
        k = np.geomspace(10.0 ** DECADES[0], 10.0 ** DECADES[1], _samples(DECADES)) / scale
        theta = _directions(function, k[:: SAMPLES_BY_DECADE * 2])
        sampled = _times_k(function, k, theta, local)
        _check(sampled, k, theta)
        _check_order_of_calls(function, k, theta, local, sampled)
        degree = _degree(sampled, k)
        harmonics = _with_mirrors(np.fft.fft(sampled, axis=1)[:, : theta.size // 2] / theta.size)
        if degree is not None:
            mean = np.mean(harmonics / (k**degree)[:, None, None, None], axis=0)
            return cls(_pairs(_without_small(mean[None])[0]), degree, local=local)
        _check_growth(sampled, k, theta)
        harmonics = _without_small(harmonics)
        poles = np.geomspace(10.0 ** POLES[0], 10.0 ** POLES[1], _poles(POLES)) / scale
        fitted = _fit(harmonics, k, poles)
        return cls(
            limit=_pairs(fitted[0]),
            poles=Numbers.of(poles),
            parts=_pairs(fitted[1:]),
            local=local,
        )

    @classmethod
    def of_half_spaces(cls, by_direction: Callable[[np.ndarray], np.ndarray]) -> FourierSymbol:
        """The symbol of half-spaces, from k f (n, 3, 3) in directions (n,)."""
        count = DIRECTIONS_MIN
        while True:
            theta = 2 * np.pi * np.arange(count) / count
            transforms = np.fft.fft(by_direction(theta), axis=0) / count
            if _resolved(transforms) or count == DIRECTIONS_MAX:
                harmonics = _without_small(_with_mirrors(transforms[None, : count // 2]))
                return cls(_pairs(harmonics[0]))
            count *= 2

    @lazy_property
    def harmonics(self) -> np.ndarray:
        """Harmonics (M + 1, 3, 3) of F, complex."""
        return self.limit.array[..., 0] + 1j * self.limit.array[..., 1]

    @lazy_property
    def harmonics_of_parts(self) -> np.ndarray:
        """Harmonics (n, M + 1, 3, 3) of the F_j, complex."""
        return self.parts.array[..., 0] + 1j * self.parts.array[..., 1]

    @property
    def homogeneous(self) -> bool:
        """True where the symbol is a power of k."""
        return self.poles.array.size == 0

    def times_k(self, k: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """k f (n, 3, 3) at wave numbers and directions (n,), without springs."""
        total = (k**self.degree)[:, None, None] * _at(self.harmonics, theta)
        b = self.poles.array
        if b.size:
            weights = b / np.sqrt(k[:, None] ** 2 + b**2)
            by_k = np.tensordot(weights, self.harmonics_of_parts, axes=1)
            total = total + at_each(by_k, theta)
        return np.asarray(total)

    @lazy_property
    def at_rest(self) -> bool:
        """True where k f vanishes towards long waves: the bodies rest on bases, or become stiff at
        depth.
        """
        if self.degree > 0:
            return True
        left = self.harmonics + self.harmonics_of_parts.sum(axis=0)
        return bool(np.abs(left).max() <= AT_REST * np.abs(self.harmonics).max())

    def scaled(self, modulus: float, length: float) -> FourierSymbol:
        """Symbol in units of a modulus and a length."""
        return FourierSymbol(
            limit=Numbers.of(self.limit.array * (modulus * length**-self.degree)),
            degree=self.degree,
            poles=Numbers.of(self.poles.array * length),
            parts=Numbers.of(self.parts.array * modulus),
            local=tuple(each * modulus / length for each in self.local),  # type: ignore[arg-type]
        )

    @lazy_property
    def equivalent(self) -> tuple[float, float]:
        """G and nu of isotropic half-spaces with the same mean compliance of short waves."""
        mean = self.harmonics[0].real
        normal = float(mean[2, 2])
        tangential = float(mean[0, 0] + mean[1, 1])
        # 2 (1 - nu)/G and (4 - 2 nu)/G
        nu = 0.0
        if tangential > normal:
            nu = min(max(1 - normal / (tangential - normal), 0.0), 0.5)
        return 2 * (1 - nu) / normal, nu

    @lazy_property
    def coupling(self) -> float:
        """Largest harmonic of k f between pressure and tractions, times G: of isotropic half-spaces
        their K.
        """
        modulus, _ = self.equivalent
        sizes = (self.harmonics[:, :2, 2], self.harmonics_of_parts[:, :, :2, 2])
        largest = max(float(np.abs(each).max(initial=0.0)) for each in sizes) * modulus
        if largest < SMALL_HARMONIC:
            return 0.0
        return largest

    def mirrored(self, axis: str) -> bool:
        """True where numbers are even or odd along x, or y."""
        every = (self.harmonics, self.harmonics_of_parts)
        return all(np.array_equal(_image(each, axis), each) for each in every)

    @lazy_property
    def largest_normal(self) -> float:
        """Largest k f between pressure and normal displacement."""
        k = np.geomspace(1e-5, 1e5, 400)
        if not self.homogeneous:
            k = np.geomspace(self.poles.array[0] / 10, self.poles.array[-1] * 10, 400)
        theta = np.linspace(0.0, np.pi, 48, endpoint=False)
        every_k, every_theta = (each.ravel() for each in np.meshgrid(k, theta))
        values = self.times_k(every_k, every_theta)
        return float(values[:, 2, 2].real.max())


def _image(harmonics: np.ndarray, axis: str) -> np.ndarray:
    """Harmonics (..., M + 1, 3, 3) of the mirror image along x or y: that of m is that of -m."""
    image = np.conj(harmonics)
    if axis == "y":
        m = np.arange(harmonics.shape[-3])
        image = image * ((-1.0) ** m)[:, None, None]
    sign = np.where(np.arange(3) == "xyz".index(axis), -1.0, 1.0)
    return np.asarray(image * sign[:, None] * sign)


def _with_mirrors(harmonics: np.ndarray) -> np.ndarray:
    """Harmonics without the rounding by which they differ from their mirror images."""
    for axis in "xy":
        image = _image(harmonics, axis)
        if np.abs(image - harmonics).max() < MIRRORED * np.abs(harmonics).max():
            harmonics = (harmonics + image) / 2
    return harmonics


def _samples(decades: tuple[float, float]) -> int:
    return int((decades[1] - decades[0]) * SAMPLES_BY_DECADE) + 1


def _poles(decades: tuple[float, float]) -> int:
    return int((decades[1] - decades[0]) * POLES_BY_DECADE) + 1


def _pairs(values: np.ndarray) -> Numbers:
    return Numbers.of(np.stack([values.real, values.imag], axis=-1))


def _at(harmonics: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """F (n, 3, 3) in directions (n,), from its harmonics 0 to M."""
    return at_each(np.broadcast_to(harmonics, (theta.size, *harmonics.shape)), theta)


def at_each(harmonics: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """F (n, 3, 3) in directions (n,), each from its own harmonics (n, M + 1, 3, 3).

    The harmonic -m is the conjugate of m, with the sign (-1)^m: kernels are real.
    """
    m = np.arange(harmonics.shape[1])
    wave = np.exp(1j * np.multiply.outer(theta, m))
    positive = np.einsum("nm,nmij->nij", wave, harmonics)
    back = np.exp(-1j * np.multiply.outer(theta, m)) * (-1.0) ** m
    negative = np.einsum("nm,nmij->nij", back[:, 1:], np.conj(harmonics[:, 1:]))
    return np.asarray(positive + negative)


# ----------------------------------------------------------------------------- sampling and checks


def _called(function: Function, kx: np.ndarray, ky: np.ndarray) -> np.ndarray:
    """Compliances (n, 3, 3) of a function at wave numbers (n,)."""
    try:
        values = np.asarray(function(kx.copy(), ky.copy()))
    except Exception as error:  # a user's own code
        message = f"bodies.symbol raised {type(error).__name__}: {error}"
        raise SceneError("bodies.symbol", "a function", message=message) from error
    expected = (*kx.shape, 3, 3)
    if values.shape != expected or values.dtype.kind not in "iufc":
        message = (
            f"bodies.symbol gave an array of shape {values.shape} for {kx.size} wave numbers; "
            f"it must be of numbers, of shape {expected}"
        )
        raise SceneError("bodies.symbol", "a function", message=message)
    return values.astype(complex)


def _times_k(
    function: Function, k: np.ndarray, theta: np.ndarray, local: tuple[float, float, float]
) -> np.ndarray:
    """k f without springs, (wave numbers, directions, 3, 3)."""
    kx = np.multiply.outer(k, np.cos(theta)).ravel()
    ky = np.multiply.outer(k, np.sin(theta)).ravel()
    values = _called(function, kx, ky).reshape(k.size, theta.size, 3, 3)
    bad = ~np.isfinite(values).all(axis=(2, 3))
    if bad.any():
        where, at = np.unravel_index(int(np.argmax(bad)), bad.shape)
        raise _refused("not finite", k[where], theta[at])
    return np.asarray((values - np.diag(local)) * k[:, None, None, None])


def _directions(function: Function, k: np.ndarray) -> np.ndarray:
    """Directions [rad], as many as resolve the harmonics of a few wave numbers."""
    count = DIRECTIONS_MIN
    while True:
        theta = 2 * np.pi * np.arange(count) / count
        values = _times_k(function, k, theta, (0.0, 0.0, 0.0))
        transforms = np.fft.fft(values, axis=1)
        if all(_resolved(each) for each in transforms) or count == DIRECTIONS_MAX:
            return np.asarray(theta)
        count *= 2


def _resolved(transforms: np.ndarray) -> bool:
    """True where the harmonics (n, 3, 3) in the middle of a transform are rounding."""
    sizes = np.abs(transforms).max(axis=(1, 2))
    middle = sizes.size // 2
    return bool(sizes[middle - 2 : middle + 3].max() <= SMALL_HARMONIC * sizes.max())


def _refused(what: str, k: float, theta: float, more: str = "") -> SceneError:
    """The error for a symbol, with the place of the worst entry."""
    message = (
        f"bodies.symbol is {what} at a wave number of {k:.4g}, {np.degrees(theta):.4g} degrees "
        f"from x{more}"
    )
    return SceneError("bodies.symbol", "a function", message=message)


def _check(sampled: np.ndarray, k: np.ndarray, theta: np.ndarray) -> None:
    """Check that a symbol is Hermitian, conjugate to itself at -k, and positive definite."""
    adjoint = np.conj(sampled.swapaxes(-1, -2))
    size = np.abs(sampled).max(axis=(1, 2, 3))[:, None]
    _check_small("not Hermitian", np.abs(sampled - adjoint).max(axis=(2, 3)) / size, k, theta)
    behind = np.roll(sampled, theta.size // 2, axis=1)
    real = np.abs(sampled - np.conj(behind)).max(axis=(2, 3)) / size
    _check_small("not the conjugate of that at the opposite wave vector", real, k, theta)
    least = np.linalg.eigvalsh((sampled + adjoint) / 2)[..., 0] / size
    if not least.min() > 0:
        where, at = np.unravel_index(int(np.argmin(least)), least.shape)
        more = f": its least eigenvalue is {least[where, at]:.3g} of its largest entry"
        raise _refused("not positive definite", k[where], theta[at], more)


def _check_small(what: str, off: np.ndarray, k: np.ndarray, theta: np.ndarray) -> None:
    """Refuse relative departures (wave numbers, directions) at the largest of them."""
    if off.max() > TOLERANCE:
        where, at = np.unravel_index(int(np.argmax(off)), off.shape)
        more = f": off by {off[where, at]:.3g} of its largest entry"
        raise _refused(what, k[where], theta[at], more)


def _check_order_of_calls(
    function: Function,
    k: np.ndarray,
    theta: np.ndarray,
    local: tuple[float, float, float],
    sampled: np.ndarray,
) -> None:
    """Check that compliances depend neither on the order nor on the number of wave numbers in a
    call.
    """
    some = slice(None, None, SAMPLES_BY_DECADE)
    again = _times_k(function, k[some][::-1], theta[::-1], local)[::-1, ::-1]
    few = slice(None, None, 4 * SAMPLES_BY_DECADE)
    for where in range(k[few].size):
        one = _times_k(function, k[few][where : where + 1], theta[1:2], local)
        again[4 * where, 1] = one[0, 0]
    size = np.abs(sampled[some]).max(axis=(1, 2, 3))[:, None]
    off = np.abs(again - sampled[some]).max(axis=(2, 3)) / size
    _check_small("dependent on the order of calls", off, k[some], theta)


def _degree(sampled: np.ndarray, k: np.ndarray) -> float | None:
    """Power of k to which k times the symbol is proportional; None if there is none."""
    traces = np.einsum("knii->k", sampled).real
    slope = np.log(traces[-1] / traces[0]) / np.log(k[-1] / k[0])
    degree = float(round(slope, 12))
    if not 0 <= degree < 1:
        return None
    power = sampled / (k**degree)[:, None, None, None]
    if np.abs(power - power[0]).max() > TOLERANCE * np.abs(power[0]).max():
        return None
    return degree


def _check_growth(sampled: np.ndarray, k: np.ndarray, theta: np.ndarray) -> None:
    """Check that a symbol grows no faster than 1/k towards wave number 0 and falls as 1/k or faster
    towards infinity.
    """
    sizes = np.abs(sampled).max(axis=(2, 3))
    for end, inner, words in (
        (0, SAMPLES_BY_DECADE, "growing faster than 1/k towards 0"),
        (
            -1,
            -1 - SAMPLES_BY_DECADE,
            "not falling like 1/k towards infinity (springs are given by local=...)",
        ),
    ):
        growth = sizes[end] / sizes[inner]
        if growth.max() > GROWTH:
            at = int(np.argmax(growth))
            more = f": times k by {growth[at]:.3g} in the last decade. Give the scale of the bodies"
            raise _refused(words, k[end], theta[at], more)


def _without_small(harmonics: np.ndarray) -> np.ndarray:
    """Harmonics (k, M + 1, 3, 3) up to the last significant one, insignificant ones set to zero."""
    sizes = np.abs(harmonics).max(axis=0)
    counts = sizes > SMALL_HARMONIC * sizes.max()
    last = int(np.flatnonzero(counts.any(axis=(1, 2)))[-1])
    return np.asarray(np.where(counts, harmonics, 0.0)[:, : last + 1])


def _fit(harmonics: np.ndarray, k: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Least squares for the limit and the parts (1 + n, M + 1, 3, 3)."""
    # the longest waves, to which line contacts are sensitive: linear extrapolation of the samples
    share = k[0] / (k[1] - k[0])
    longest = harmonics[0] - share * (harmonics[1] - harmonics[0])
    k = np.concatenate([[0.0], k])
    columns = np.concatenate(
        [np.ones((k.size, 1)), poles / np.sqrt(k[:, None] ** 2 + poles**2)], axis=1
    )
    right = np.concatenate([longest[None], harmonics]).reshape(k.size, -1)
    pairs = np.concatenate([right.real, right.imag], axis=1)
    found, *_ = np.linalg.lstsq(columns, pairs, rcond=1e-15)
    off = np.abs(columns @ found - pairs).max(axis=1) / np.abs(right).max()
    if off.max() > FIT_ERROR:
        worst = int(np.argmax(off))
        message = (
            f"bodies.symbol is not smooth enough for a fit: off by {off[worst]:.2g} of its largest "
            f"compliance at a wave number of {k[worst]:.4g}. Give the scale of the bodies"
        )
        raise SceneError("bodies.symbol", "a function", message=message)
    real, imaginary = np.split(found, 2, axis=1)
    return np.asarray((real + 1j * imaginary).reshape(-1, *harmonics.shape[1:]))
