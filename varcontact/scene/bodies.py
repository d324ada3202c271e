"""Materials of the bodies."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from varcontact import checks
from varcontact.checks import Checked, is_array, poisson_ratio, positive, positive_or_infinite
from varcontact.errors import SceneError
from varcontact.system.process import lazy_property

Relaxations = tuple[tuple[float, float], ...]
"""Relaxations of a standard linear solid: parts of the compliance, and times [time]."""

RIGID = "rigid"
"""Name of a rigid body in a pair, or of a rigid base."""


def _relaxations(field: str, given: Any, least: int = 0) -> Relaxations:
    pairs = is_array(given) and len(given) >= least
    if not pairs or not all(is_array(each) and len(each) == 2 for each in given):
        allowed = "a list of pairs (f, tau)"
        if least > 0:
            allowed += ", one at least"
        raise SceneError(field, given, allowed)
    return tuple(
        (positive(f"{field}[{k}][0]", part), positive(f"{field}[{k}][1]", time))
        for k, (part, time) in enumerate(given)
    )


def _pair(field: str, value: Any, check: Any = poisson_ratio) -> tuple[float, float]:
    """Values of both bodies, of which one at least is finite."""
    if not is_array(value):
        upper = lower = check(field, value)
    elif len(value) == 2:
        upper = check(f"{field}[0]", value[0])
        lower = check(f"{field}[1]", value[1])
    else:
        raise SceneError(field, value, "one value, or a pair (upper, lower)")
    if math.isinf(upper) and math.isinf(lower):
        raise SceneError(field, value, "finite for one body at least (both are rigid)")
    return upper, lower


def _one_if_equal(pair: tuple[float, float]) -> float | tuple[float, float]:
    if pair[0] == pair[1]:
        return pair[0]
    return pair


@dataclass(frozen=True)
class Bodies(Checked):
    """Elastic constants of the two bodies: isotropic half-spaces (paper, section 2).

    Parameters
    ----------
    G : float or pair
        Modulus of rigidity [force/area]; one value for both bodies, or (upper,
        lower). ``inf`` is rigid.
    nu : float or pair
        Poisson's ratio in (-1, 0.5].

    Raises
    ------
    SceneError
        For moduli that are not positive, ratios out of range, or two rigid
        bodies.

    Examples
    --------
    >>> steel_on_aluminium = Bodies(G=(82e9, 26e9), nu=(0.28, 0.33))
    >>> print(f"{steel_on_aluminium.combined_G:.4g} {steel_on_aluminium.K:.4f}")
    3.948e+10 -0.0761
    """

    _words: ClassVar = {
        "E": "Bodies.from_young(E, nu)",
        "mu": "G for the modulus, and friction in the Scene",
    }
    G: float | tuple[float, float]
    nu: float | tuple[float, float]
    # what a pair of other bodies may have: longest relaxation time, bases that do not move, one
    # without friction
    longest_relaxation: ClassVar[float] = 0.0
    relaxes: ClassVar[bool] = False
    grounded: ClassVar[bool] = False
    slides: ClassVar[bool] = False

    def __post_init__(self) -> None:
        G = _pair("bodies.G", self.G, positive_or_infinite)
        nu = _pair("bodies.nu", self.nu)
        object.__setattr__(self, "G", _one_if_equal(G))
        object.__setattr__(self, "nu", _one_if_equal(nu))

    @classmethod
    @checks.named_options()
    def from_young(cls, E: float | tuple[float, float], nu: float | tuple[float, float]) -> Bodies:
        """Bodies from Young's modulus, (160): ``G = E / (2 (1 + nu))``.

        Parameters
        ----------
        E : float or pair of float
            Young's modulus of both bodies, or of each [force/area].
        nu : float or pair of float
            Poisson's ratio [-], in [0, 0.5].

        Returns
        -------
        Bodies

        Raises
        ------
        SceneError
            For a modulus that is not positive, or a ratio out of range.

        Examples
        --------
        >>> Bodies.from_young(E=210e9, nu=0.25)
        Bodies(G=84000000000.0, nu=0.25)
        """
        moduli = _pair("bodies.E", E, positive_or_infinite)
        ratios = _pair("bodies.nu", nu)
        return cls(G=(moduli[0] / (2 + 2 * ratios[0]), moduli[1] / (2 + 2 * ratios[1])), nu=ratios)

    @property
    def pairs(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """((G1, G2), (nu1, nu2))."""
        G = self.G
        if not isinstance(G, tuple):
            G = (G, G)
        nu = self.nu
        if not isinstance(nu, tuple):
            nu = (nu, nu)
        return G, nu

    @lazy_property
    def combined_G(self) -> float:
        """Combined modulus of rigidity, ``1/G = (1/G1 + 1/G2)/2`` (58)."""
        (G1, G2), _ = self.pairs
        return 2 / (1 / G1 + 1 / G2)

    @lazy_property
    def combined_nu(self) -> float:
        """Combined Poisson's ratio, ``nu/G = (nu1/G1 + nu2/G2)/2`` (59)."""
        (G1, G2), (nu1, nu2) = self.pairs
        if nu1 == nu2:
            return nu1
        return self.combined_G / 2 * (nu1 / G1 + nu2 / G2)

    @lazy_property
    def K(self) -> float:
        """Difference parameter (60); zero: quasi-identical, normal and tangential problem
        uncoupled.
        """
        (G1, G2), (nu1, nu2) = self.pairs
        if (G1, nu1) == (G2, nu2):
            return 0.0
        weight = self.combined_G / 4
        upper = weight * (1 - 2 * nu1) / G1
        lower = weight * (1 - 2 * nu2) / G2
        if abs(upper - lower) > 1e-15:
            return upper - lower
        return 0.0

    @property
    def softest(self) -> Bodies:
        """Half-spaces at least as compliant as these bodies: themselves."""
        return self

    @property
    def coupled(self) -> bool:
        """True where pressure and tractions depend on each other (K != 0)."""
        return self.K != 0


@dataclass(frozen=True)
class Layer(
    Checked, path="layer", h=positive, G=positive, nu=poisson_ratio, relaxations=_relaxations
):
    """A layer of a `Layered` body: homogeneous, isotropic, and bonded to what is below.

    Parameters
    ----------
    h, G, nu : float
        Thickness [length], modulus of rigidity [force/area], and Poisson's
        ratio in (-1, 0.5].
    relaxations : sequence of (f, tau), optional
        Relaxations of its own `Viscoelastic` solid, in line contact.

    Raises
    ------
    SceneError
        For thickness, modulus, parts or times that are not positive and finite,
        or a ratio out of range.
    """

    h: float
    G: float
    nu: float
    relaxations: Relaxations = ()


@dataclass(frozen=True)
class Layered(Checked, path="bodies", relaxations=_relaxations):
    """A body of layers on a base: coated, graded, or a strip.

    Parameters
    ----------
    layers : sequence of Layer
        From the surface downwards; one at least.
    base : (G, nu), (G, nu, relaxations), "rigid" or "smooth"
        A half-space that the last layer is bonded to, a rigid one, or a rigid
        one without friction: also the middle of a strip that is loaded alike
        from both sides.
    relaxations : sequence of (f, tau), optional
        Relaxations of a `Viscoelastic` solid, which all layers, and a base that gives
        way, are of; left out where layers have their own.

    Raises
    ------
    SceneError
        If there is no layer, the base is none of these, or parts or times are
        not positive.

    Examples
    --------
    >>> Layered([Layer(h=0.1, G=4.0, nu=0.3)], base=(1.0, 0.3)).base
    (1.0, 0.3)
    """

    layers: tuple[Layer, ...]
    base: tuple[float, float] | tuple[float, float, Relaxations] | str
    relaxations: Relaxations = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self._has_layers:
            raise SceneError("bodies.layers", self.layers, "a list of Layer, one at least")
        object.__setattr__(self, "layers", tuple(self.layers))
        object.__setattr__(self, "base", _checked_base(self.base))
        several = any(layer.relaxations for layer in self.layers) or len(self.base) == 3
        if self.relaxations and several:
            raise SceneError(
                "bodies.relaxations",
                self.relaxations,
                "left out where layers or the base have their own",
            )

    @property
    def _has_layers(self) -> bool:
        if not isinstance(self.layers, list | tuple) or not self.layers:
            return False
        return all(isinstance(layer, Layer) for layer in self.layers)


def _checked_base(base: Any) -> Any:
    """The base of a layered body: G, nu and its own relaxations, "rigid" or "smooth"."""
    if isinstance(base, str) and base in ("rigid", "smooth"):
        return base
    if not isinstance(base, list | tuple) or len(base) not in (2, 3):
        raise SceneError("bodies.base", base, '(G, nu), (G, nu, relaxations), "rigid" or "smooth"')
    G = positive("bodies.base[0]", base[0])
    nu = poisson_ratio("bodies.base[1]", base[1])
    if len(base) == 2:
        return G, nu
    return G, nu, _relaxations("bodies.relaxations", base[2], 1)


@dataclass(frozen=True)
class Viscoelastic(
    Checked, path="bodies", G=positive, nu=poisson_ratio, relaxations=partial(_relaxations, least=1)
):
    """A homogeneous half-space of a standard linear solid: rolls by
    ``Steady(speed=...)`` or ``Transient(dt=...)``.

    Parameters
    ----------
    G : float
        Modulus of rigidity at once (glassy) [force/area].
    nu : float
        Poisson's ratio in (-1, 0.5], the same at all times.
    relaxations : sequence of (f, tau)
        The compliance at a time t is ``(1 + sum f (1 - exp(-t/tau)))/G``: parts
        f that come with relaxation times tau [time]. In CONTACT's terms
        ``FG = f`` and ``TC = tau``.

    Raises
    ------
    SceneError
        For a modulus, parts or times that are not positive and finite, no
        relaxation, or a ratio out of range.

    Examples
    --------
    >>> Viscoelastic(G=1143.0, nu=0.4, relaxations=[(1.0, 0.009)])
    Viscoelastic(G=1143.0, nu=0.4, relaxations=((1.0, 0.009),))
    """

    G: float
    nu: float
    relaxations: Relaxations


@dataclass(frozen=True)
class Winkler(Checked, path="bodies", h=positive, E=positive, G=positive):
    """A Winkler bedding (paper, 1.2): springs side by side on a rigid base, each of which feels its
    own traction alone.

    Pressure p compresses by ``h p/E``, a traction shears by ``h p/G``. In steady rolling that is
    the simplified theory, with the flexibility h/G and a parabolic pressure below paraboloids.

    Parameters
    ----------
    h : float
        Length of the springs [length].
    E, G : float
        Moduli along the normal and along the surface [force/area].

    Raises
    ------
    SceneError
        For entries that are not positive and finite.

    Examples
    --------
    >>> Winkler.of_layer(h=0.1, G=2.0, nu=0.25)
    Winkler(h=0.1, E=6.0, G=2.0)
    """

    h: float
    E: float
    G: float

    @classmethod
    @checks.named_options()
    def of_layer(cls, h: float, G: float, nu: float) -> Winkler:
        """The bedding that a layer on a rigid base is in contacts far wider than it is thick: with
        the modulus of uniaxial strain, ``E = 2 G (1 - nu)/(1 - 2 nu)``.

        Parameters
        ----------
        h, G, nu : float
            As of a `Layer`; Poisson's ratio in (-1, 0.5): without change of volume a layer is none.

        Returns
        -------
        Winkler

        Raises
        ------
        SceneError
            For entries out of range.
        """
        nu = poisson_ratio("nu", nu)
        if nu == 0.5:
            raise SceneError(
                "nu", nu, "below 0.5: a layer that keeps its volume gives way elsewhere"
            )
        G = positive("G", G)
        return cls(h=h, E=2 * G * (1 - nu) / (1 - 2 * nu), G=G)


class Stratified(ABC):
    """A body that changes with the depth alone, and gives its compliance by wave number itself."""

    @property
    @abstractmethod
    def materials(self) -> list[tuple[float, float, Relaxations]]:
        """G, nu and relaxations, from the surface downwards."""

    @abstractmethod
    def stack(self, G: float, length: float) -> Any:
        """The stack that gives its compliance by wave number, in units of G and a length."""


Body = Bodies | Layered | Viscoelastic | Stratified | Winkler


@dataclass(frozen=True)
class BodyPair:
    """Two bodies of which one at least is no homogeneous half-space, as
    ``Scene(bodies=(upper, lower))`` has them.

    Parameters
    ----------
    upper, lower : Layered, Viscoelastic, Bodies or "rigid"
        A half-space is ``Bodies(G, nu)`` with one modulus and one ratio.

    Raises
    ------
    SceneError
        If one of them is no body, or both are rigid.
    """

    upper: Body | str
    lower: Body | str

    def __post_init__(self) -> None:
        for name in ("upper", "lower"):
            body = getattr(self, name)
            is_body = isinstance(body, Body) or body == RIGID
            if isinstance(body, Bodies):
                is_body = not isinstance(body.G, tuple) and not isinstance(body.nu, tuple)
            if not is_body:
                allowed = (
                    "Layered, Viscoelastic, Graded, Winkler, "
                    'Bodies with one G and one nu, or "rigid"'
                )
                raise SceneError(f"bodies.{name}", body, allowed)
        if self.upper == self.lower == RIGID:
            raise SceneError("bodies", (RIGID, RIGID), "one body at least that is elastic")
        if self.bedded and not all(
            body == RIGID or isinstance(body, Winkler) for body in self.both
        ):
            given = tuple(type(body).__name__ for body in self.both)
            raise SceneError("bodies", given, 'a Winkler bedding on another one or on "rigid"')

    @property
    def both(self) -> tuple[Body | str, Body | str]:
        """Upper and lower body."""
        return self.upper, self.lower

    @property
    def bedded(self) -> bool:
        """True where one of the bodies is a Winkler bedding: the displacement at a point depends on
        the traction there only.
        """
        return any(isinstance(body, Winkler) for body in self.both)

    @property
    def surfaces(self) -> Bodies:
        """Half-spaces of the materials at the surfaces."""
        G1, nu1, _ = materials(self.upper)[0]
        G2, nu2, _ = materials(self.lower)[0]
        return Bodies(G=(G1, G2), nu=(nu1, nu2))

    @property
    def softest(self) -> Bodies:
        """Half-spaces at least as compliant as these bodies."""
        upper, lower = (
            min(G for G, _ in _relaxed(materials(body))) for body in (self.upper, self.lower)
        )
        return Bodies(G=(upper, lower), nu=0.0)

    @property
    def longest_relaxation(self) -> float:
        """Longest relaxation time [time]; 0: both bodies are elastic."""
        solids = [solid for body in (self.upper, self.lower) for _, _, solid in materials(body)]
        return max((time for solid in solids for _, time in solid), default=0.0)

    @property
    def of_several_solids(self) -> bool:
        """True where parts of a body, one of them viscoelastic, have different relaxations."""
        return any(
            len({solid for _, _, solid in materials(body)}) > 1 for body in (self.upper, self.lower)
        )

    @property
    def relaxes(self) -> bool:
        """True where one of the bodies is viscoelastic."""
        return self.longest_relaxation > 0

    @property
    def relaxed(self) -> Bodies | BodyPair:
        """Elastic bodies to which these relax under constant tractions."""
        pair: list[Body | str] = []
        for body in (self.upper, self.lower):
            soft = _relaxed(materials(body))
            if isinstance(body, Viscoelastic):
                pair.append(Bodies(*soft[0]))
            elif isinstance(body, Layered):
                layers = tuple(Layer(layer.h, *soft[k]) for k, layer in enumerate(body.layers))
                base = body.base
                if not isinstance(base, str):
                    base = soft[-1]
                pair.append(Layered(layers, base))
            else:
                pair.append(body)
        made: Bodies | BodyPair = as_bodies(pair)
        return made

    @property
    def combined_G(self) -> float:
        """Combined modulus of rigidity (58) of the materials at the surfaces."""
        return self.surfaces.combined_G

    @property
    def combined_nu(self) -> float:
        """Combined Poisson's ratio (59) of the materials at the surfaces."""
        return self.surfaces.combined_nu

    @property
    def coupled(self) -> bool:
        """True where pressure and tractions depend on each other: unless the bodies are the
        same, or beddings.
        """
        return self.upper != self.lower and not self.bedded

    @property
    def grounded(self) -> bool:
        """True where both bodies rest on fixed bases, from which normal displacements count."""
        for body in (self.upper, self.lower):
            if isinstance(body, Layered):
                rests = isinstance(body.base, str)
            else:
                rests = isinstance(body, str | Winkler)
            if not rests:
                return False
        return True

    @property
    def slides(self) -> bool:
        """True where one of the bodies rests on a frictionless base: tangential displacements are
        determined up to a constant.
        """
        return any(
            isinstance(body, Layered) and body.base == "smooth" for body in (self.upper, self.lower)
        )


def as_bodies(value: Any) -> Any:
    """Bodies of a scene, as given: one body stands for two of its kind, and a pair of half-spaces
    is `Bodies`.
    """
    if isinstance(value, Layered | Viscoelastic | Stratified | Winkler):
        return BodyPair(value, value)
    if (
        not isinstance(value, tuple | list)
        or len(value) != 2
        or not any(isinstance(b, Body) for b in value)
    ):
        return value
    pair = BodyPair(*value)
    if any(isinstance(body, Layered | Viscoelastic | Stratified | Winkler) for body in value):
        return pair
    return pair.surfaces


def loaded_alone(bodies: Bodies | BodyPair, loaded: str) -> Bodies | BodyPair:
    """Bodies of which only the loaded one ("upper", "lower", "both") is deformable."""
    if loaded == "both":
        return bodies
    if isinstance(bodies, Bodies):
        G, nu = bodies.pairs
        moduli = {"upper": (G[0], math.inf), "lower": (math.inf, G[1])}
        return Bodies(moduli[loaded], nu)
    pairs = {"upper": (bodies.upper, RIGID), "lower": (RIGID, bodies.lower)}
    alone: Bodies | BodyPair = as_bodies(pairs[loaded])
    return alone


def materials(body: Body | str) -> list[tuple[float, float, Relaxations]]:
    """G, nu and relaxations of the layers of a body, from the surface, and of a deformable base."""
    if isinstance(body, str):
        return [(math.inf, 0.0, ())]
    if isinstance(body, Bodies):
        return [(body.combined_G, body.combined_nu, ())]
    if isinstance(body, Viscoelastic):
        return [(body.G, body.nu, body.relaxations)]
    if isinstance(body, Winkler):
        return [(body.G, 0.0, ())]
    if isinstance(body, Stratified):
        return body.materials
    solids = [(layer.G, layer.nu, layer.relaxations or body.relaxations) for layer in body.layers]
    if not isinstance(body.base, str):
        relaxations = body.relaxations
        if len(body.base) == 3:
            relaxations = body.base[2]
        solids.append((body.base[0], body.base[1], relaxations))
    return solids


def _relaxed(solids: list[tuple[float, float, Relaxations]]) -> list[tuple[float, float]]:
    """G and nu after a long time."""
    return [(G / (1 + sum(part for part, _ in solid)), nu) for G, nu, solid in solids]
