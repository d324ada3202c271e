"""Parameters of friction, third body and theories from measured creep curves, by least squares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.html import Reported
from varcontact.io.labelled import Labelled
from varcontact.results.error_estimate import with_bar
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.study.derivatives import inputs_of
from varcontact.study.parameters import changed
from varcontact.study.scan import check_exact, creep_curve
from varcontact.system.progress import Progress
from varcontact.theories.creep_forces import OPTIONS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

REFUSED = 10.0
"""Residual, relative to the largest force, for parameters that a scene refuses: no step ends
there."""
DIFFERENCE = 1e-3
"""Relative step of the derivatives by the parameters: forces are smooth to 1e-8, with kinks where
areas change."""
BESIDE = 0.01
"""Distance from a bound, divided by the range, within which a parameter counts as on it: the search
stays inside."""
EFFECT_MIN = 1e-8
"""Least effect of a combination of parameters on the forces, relative to the greatest."""


@dataclass(frozen=True, eq=False)
class CreepCurveFit(Reported, Labelled):
    """Fitted parameters, with their standard errors.

    Attributes
    ----------
    values, errors : dict of str to float
        By parameter. The errors assume independent errors of the measurements,
        of one size unless `sigma` says it; inf where they exceed the range of a
        parameter: these forces do not determine it. NaN on a bound.
    on_bounds : tuple of str
        Parameters that stand on a bound of their range, where the forces would
        have them beyond; the errors of the others are with these fixed.
    correlation : ndarray, shape (k, k)
        Between the parameters; NaN for those on bounds.
    rms : float
        Root mean square of the residuals [force].
    scene : Scene
        With the fitted entries.
    options : dict
        Fitted options of the theory.
    curve : xarray.Dataset
        The fitted curve at the measured creepages, as `creep_curve` gives it.
    measured : dict of str to ndarray
        Measured forces, "Fx" or "Fy" or both [force]; NaN where there is none.
    sigma : float
        Standard error of a measured force: given, or that of the residuals
        [force].
    """

    values: dict[str, float]
    errors: dict[str, float]
    on_bounds: tuple[str, ...]
    correlation: np.ndarray
    rms: float
    scene: Scene
    options: dict[str, float]
    curve: xr.Dataset
    measured: dict[str, np.ndarray]
    sigma: float

    def to_xarray(self) -> xr.Dataset:
        """Values, errors and correlation over the parameters; measured and fitted forces over the
        measured creepages.
        """
        from varcontact.study.fit_data import fit_dataset

        return fit_dataset(self)

    def to_dataframe(self) -> pd.DataFrame:
        """A row for each parameter: its value, its standard error, and whether it is on a bound."""
        import pandas as pd

        rows = [
            {
                "parameter": name,
                "value": value,
                "error": self.errors[name],
                "on_bound": name in self.on_bounds,
            }
            for name, value in self.values.items()
        ]
        return pd.DataFrame(rows)

    @checks.named_options()
    def plot(self, *, figsize: tuple[float, float] | None = None) -> Figure:
        """Measured forces with bars of their standard error, and the fitted curve; `figsize` is in
        inches.
        """
        from varcontact.study.fit_data import plot_fit

        return plot_fit(self, figsize)

    def report(self) -> str:
        """The parameters with their errors, a line each, and the residual."""
        lines = [self._line(name, value, self.errors[name]) for name, value in self.values.items()]
        if self.on_bounds and len(self.on_bounds) < len(self.values):
            lines.append(f"errors are those with {', '.join(self.on_bounds)} fixed")
        return "\n".join([*lines, f"residual {self.rms:.3g} (root mean square of the forces)"])

    def _line(self, name: str, value: float, error: float) -> str:
        if name in self.on_bounds:
            return f"{name} = {value:.4g} (on a bound of its range)"
        line = f"{name} = {with_bar(value, error)}"
        if error == np.inf:
            line += " (not determined by these forces)"
        return line


@checks.named_options()
def fit_creep_curve(
    scene: Scene,
    parameters: Mapping[str, tuple[float, float, float]],
    *,
    vx: Any = None,
    vy: Any = None,
    spin: Any = None,
    Fx: Any = None,
    Fy: Any = None,
    method: str = "auto",
    sigma: float | None = None,
    progress: Progress = None,
) -> CreepCurveFit:
    """Fit entries of a scene, or options of a theory, to a measured creep curve.

    Parameters
    ----------
    scene : Scene
        In steady rolling, with first guesses for whatever is fitted.
    parameters : dict of str to (first guess, least, largest)
        Entries of the scene as `sweep` names them ("friction",
        "friction.kinetic", "third_body.h"), or options of the theory ("k_A",
        "k_S" of Polach's formula, "layer" of FASTSIM).
    vx, vy, spin : array_like
        Measured creepages, as for `creep_curve`.
    Fx, Fy : array_like, shape (n,)
        Measured tangential forces on body 1 at these [force], at least one of
        them; NaN is left out.
    method : str
        As in `creep_curve`: "auto" for the exact theory, or a fast one.
    sigma : float, optional
        Standard error of a measured force [force]; by default that of the
        residuals.
    progress : callable or true, optional
        Called with one line of text for each curve that is computed.

    Returns
    -------
    CreepCurveFit

    Raises
    ------
    SceneError
        Without parameters or forces, for more parameters than forces, shapes
        that do not agree, unknown entries, and guesses outside their range.

    Notes
    -----
    Trust-region least squares (`scipy.optimize.least_squares`), with derivatives from the gradients
    of the solutions where they have them (exact theory, entries with a gradient), else from
    differences of curves. Errors are from the curvature at the minimum, ``sigma^2 (J'J)^-1``, over
    the parameters that do not stand on a bound.

    Examples
    --------
    Polach's factors for a curve of the exact theory with a soft layer between the bodies:

    >>> from dataclasses import replace
    >>> import numpy as np
    >>> import varcontact as vc
    >>> bare = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=80e3, friction=0.3, motion=vc.Steady(), grid=vc.Grid(nx=8, ny=8))
    >>> vx = np.linspace(5e-4, 8e-3, 8)
    >>> layered = replace(bare, third_body=vc.ThirdBody(h=1e-4, G=1e9))
    >>> exact = vc.creep_curve(layered, ["auto"], vx=vx)
    >>> guesses = {"k_A": (0.9, 0.1, 1.0), "k_S": (0.4, 0.1, 1.0)}
    >>> fit = vc.fit_creep_curve(bare, guesses, vx=vx, Fx=exact.Fx[0], method="polach")
    >>> print({name: round(value, 2) for name, value in fit.values.items()})
    {'k_A': 0.4, 'k_S': 0.4}
    >>> print(f"{fit.rms / exact.limit:.3f}")
    0.022
    """
    names, ranges = _ranges(parameters)
    first, low, high = ranges.T
    curve_of = _Curve.posed(scene, names, method, {"vx": vx, "vy": vy, "spin": spin})
    forces = {
        name: np.asarray(each, float).ravel()
        for name, each in {"Fx": Fx, "Fy": Fy}.items()
        if each is not None
    }
    measured, used = _measured(forces, curve_of.points, len(names))
    if sigma is not None:
        sigma = checks.positive("sigma", sigma)
    report = checks.progress(progress)
    scale = float(np.abs(measured[used]).max()) or 1.0
    evaluations = 0

    def residuals(values: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        report(f"curve {evaluations}")
        try:
            _, _, curve = curve_of(values)
        except SceneError:  # entries that exclude each other, each in its range
            if evaluations == 1:
                raise
            return np.full(int(used.sum()), REFUSED)
        computed = np.concatenate([curve[name].to_numpy()[0] for name in forces])
        return (computed - measured)[used] / scale

    def slopes(values: np.ndarray) -> np.ndarray:
        _, _, curve = curve_of(values)
        columns = []
        for entry in names:
            by_entry = [curve[f"{name}_by_{entry}"].to_numpy()[0] for name in forces]
            columns.append(np.concatenate(by_entry))
        return np.array(columns).T[used] / scale

    from scipy.optimize import least_squares

    # the minimum
    jacobian: Any = "2-point"
    if curve_of.by:
        jacobian = slopes
    size = np.maximum(np.abs(first), 1e-3 * (high - low))
    fit = least_squares(
        residuals,
        first,
        jac=jacobian,
        bounds=(low, high),
        x_scale=size,
        diff_step=DIFFERENCE,
    )
    # errors and correlation of the parameters that are not on a bound
    on_bound = _on_bounds(fit, size, low, high)
    free = np.flatnonzero(~on_bound)
    if sigma is None:
        sigma = scale * np.sqrt(2 * fit.cost / (used.sum() - free.size))
    errors = np.full(len(names), np.nan)
    correlation = np.full((len(names), len(names)), np.nan)
    if free.size:
        errors[free], correlation[np.ix_(free, free)] = _spread(
            fit.jac[:, free], size[free], sigma / scale
        )
    errors = np.where(errors >= high - low, np.inf, errors)
    fitted, options, curve = curve_of(fit.x)
    return CreepCurveFit(
        values=dict(zip(names, fit.x.tolist(), strict=True)),
        errors=dict(zip(names, errors.tolist(), strict=True)),
        on_bounds=tuple(np.array(names)[on_bound].tolist()),
        correlation=correlation,
        rms=scale * float(np.sqrt(np.mean(fit.fun**2))),
        scene=fitted,
        options=options,
        curve=curve,
        measured=forces,
        sigma=float(sigma),
    )


def _ranges(parameters: Any) -> tuple[list[str], np.ndarray]:
    """Names of the parameters, and their first, least and largest values (k, 3)."""
    if not isinstance(parameters, Mapping) or not parameters:
        allowed = "a dict of (first guess, least, largest) by name, at least one"
        raise SceneError("parameters", parameters, allowed)
    ranges = []
    for name, each in parameters.items():
        values = checks.numbers(f"parameters[{name!r}]", each).ravel()
        if values.size != 3 or not values[1] <= values[0] <= values[2] or values[1] == values[2]:
            allowed = "(first guess, least, largest), in this range"
            raise SceneError(f"parameters[{name!r}]", each, allowed)
        ranges.append(values)
    return list(parameters), np.array(ranges)


def _measured(
    forces: Mapping[str, np.ndarray], points: int, parameters: int
) -> tuple[np.ndarray, np.ndarray]:
    """Forces at the points, one after the other, and True for those that are measured; more than
    there are parameters.
    """
    if not forces or any(each.size != points for each in forces.values()):
        sizes = {name: each.size for name, each in forces.items()}
        raise SceneError("Fx, Fy", sizes, f"{points} forces, as creepages")
    measured = np.concatenate(list(forces.values()))
    used = np.isfinite(measured)
    if used.sum() <= parameters:
        allowed = f"more than {parameters} forces, one for each parameter"
        raise SceneError("Fx, Fy", int(used.sum()), allowed)
    return measured, used


Evaluated = tuple[Scene, dict[str, float], "xr.Dataset"]


@dataclass(frozen=True)
class _Curve:
    """The creep curve of a scene by the values of its parameters: entries of it, or options of the
    theory. It has derivatives `by` its parameters where solutions have gradients.
    """

    scene: Scene
    names: list[str]
    method: str
    creepages: dict[str, Any]
    by: list[str]
    last: dict[bytes, Evaluated] = field(default_factory=dict)

    @classmethod
    def posed(
        cls, scene: Scene, names: list[str], method: str, creepages: Mapping[str, Any]
    ) -> _Curve:
        checked = {
            name: checks.numbers(name, each).ravel()
            for name, each in creepages.items()
            if each is not None
        }
        by: list[str] = []
        if _differentiable(scene, names, method):
            by = names
        return cls(scene, names, method, checked, by)

    @property
    def points(self) -> int:
        return max((each.size for each in self.creepages.values()), default=0)

    def __call__(self, values: np.ndarray) -> Evaluated:
        """The scene, the options and the curve of some values; the last one is kept."""
        key = values.tobytes()
        if key not in self.last:
            evaluated = self._evaluated(values)
            self.last.clear()
            self.last[key] = evaluated
        return self.last[key]

    def _evaluated(self, values: np.ndarray) -> Evaluated:
        theory_options = OPTIONS.get(self.method, ())
        options: dict[str, float] = {}
        entries: dict[str, float] = {}
        for name, value in zip(self.names, values, strict=True):
            if name in theory_options:
                options[name] = float(value)
            else:
                entries[name] = float(value)
        scene = changed(self.scene, entries, given_as="parameters")
        methods: Any = {self.method: options} if options else [self.method]
        return scene, options, creep_curve(scene, methods, by=self.by, **self.creepages)


def _differentiable(scene: Scene, names: list[str], method: str) -> bool:
    """True where solutions have gradients by all parameters."""
    if not isinstance(scene.grid, Grid):
        return False
    try:
        check_exact(scene, [method])
        return bool(inputs_of(names, [scene]))
    except SceneError:
        return False


def _on_bounds(fit: Any, size: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """True for parameters on a bound: as the search has it, or beside one, beyond which the next
    step would lead.
    """
    step = np.linalg.lstsq(fit.jac * size, -fit.fun, rcond=EFFECT_MIN)[0] * size
    beside = np.minimum(fit.x - low, high - fit.x) <= BESIDE * (high - low)
    beyond = (fit.x + step < low) | (fit.x + step > high)
    return np.asarray((fit.active_mask != 0) | (beside & beyond))


def _spread(jacobian: np.ndarray, size: np.ndarray, spread: float) -> tuple[np.ndarray, np.ndarray]:
    """Standard errors and correlation of parameters, from derivatives of residuals that have a
    standard error.
    """
    _, effects, combinations = np.linalg.svd(jacobian * size, full_matrices=False)
    least = EFFECT_MIN * effects[0]
    spreads = combinations.T * size[:, None] / np.maximum(effects, least) * spread
    errors = np.linalg.norm(spreads, axis=1)
    return errors, spreads @ spreads.T / np.outer(errors, errors)
