"""Contacts as differentiable functions of JAX and PyTorch.

A function takes numbers of a scene, as creepages and loads, and gives outputs of its solution;
its derivatives are gradients of the solution by a transposed solve, not those of the solver's
steps. JAX or PyTorch is imported when a function is made.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.gradients.gradient import EdgeName
from varcontact.gradients.inputs import number_of, path_of
from varcontact.gradients.outputs import Output, output_of
from varcontact.scene.scene import Scene
from varcontact.solving.solve import solve

__all__ = ["jax_function", "torch_function"]


def jax_function(
    scene: Scene,
    outputs: Sequence[str | Output],
    inputs: Sequence[str],
    *,
    edge: EdgeName = "auto",
    **methods: Any,
) -> Callable[[Any], Any]:
    """A function of JAX from numbers of a scene to outputs of its solution.

    Parameters
    ----------
    scene : Scene
        Scene that gives all other inputs.
    outputs, inputs : sequences of str
        Outputs and numbers of the scene, as of `Solution.gradient`.
    edge : {"auto", "held", "moving", "following"}
        Derivative that is meant, as of `Solution.gradient`.
    **methods
        Arguments of `solve`.

    Returns
    -------
    callable
        From an array (..., inputs) to one (..., outputs), of the same type. It
        has first derivatives in reverse (``jax.grad``, ``jax.vjp``) and works
        under ``jax.jit``; every row is a solve.

    Raises
    ------
    ImportError
        Without JAX: ``pip install "varcontact[jax]"``.
    SceneError
        For outputs and inputs that the scene has not.

    Examples
    --------
    >>> import varcontact as vc
    >>> from varcontact.autodiff import jax_function
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Paraboloids(100.0, 100.0),
    ...     normal_force=1e-3, friction=0.3, motion=vc.Steady(vx=1e-4),
    ...     grid=vc.Grid(nx=12, ny=12))
    >>> force = jax_function(scene, ["Fx"], ["vx", "normal_force"])  # doctest: +SKIP
    >>> jax.grad(lambda x: force(x)[0])(jnp.array([1e-4, 1e-3]))  # doctest: +SKIP
    """
    jax = _imported("jax")
    contact = _Contact.of(scene, outputs, inputs, edge, methods)

    def shaped(x: Any, *more: int) -> Any:
        return jax.ShapeDtypeStruct((*x.shape[:-1], len(contact.outputs), *more), x.dtype)

    def values(x: Any) -> Any:
        return jax.pure_callback(contact.values, shaped(x), x)

    def forward(x: Any) -> Any:
        shapes = shaped(x), shaped(x, len(contact.inputs))
        return jax.pure_callback(contact.values_and_slopes, shapes, x)

    def backward(slopes: Any, cotangent: Any) -> Any:
        return ((cotangent[..., None] * slopes).sum(-2),)

    function: Any = jax.custom_vjp(values)
    function.defvjp(forward, backward)
    differentiable: Callable[[Any], Any] = function
    return differentiable


def torch_function(
    scene: Scene,
    outputs: Sequence[str | Output],
    inputs: Sequence[str],
    *,
    edge: EdgeName = "auto",
    **methods: Any,
) -> Callable[[Any], Any]:
    """A function of PyTorch from numbers of a scene to outputs of its solution.

    Parameters
    ----------
    scene, outputs, inputs, edge, **methods
        As of `jax_function`.

    Returns
    -------
    callable
        From a tensor (..., inputs) to one (..., outputs), of the same type, on
        the processor; with first derivatives (``backward()``).

    Raises
    ------
    ImportError
        Without PyTorch: ``pip install "varcontact[torch]"``.
    SceneError
        For outputs and inputs that the scene has not.
    """
    torch = _imported("torch")
    contact = _Contact.of(scene, outputs, inputs, edge, methods)

    def forward(ctx: Any, x: Any) -> Any:
        values, slopes = contact.values_and_slopes(x.detach().numpy())
        ctx.save_for_backward(torch.from_numpy(slopes))
        return torch.from_numpy(values)

    def backward(ctx: Any, cotangent: Any) -> Any:
        (slopes,) = ctx.saved_tensors
        return (cotangent[..., None] * slopes).sum(-2)

    rules = {"forward": staticmethod(forward), "backward": staticmethod(backward)}
    function: Any = type("Contact", (torch.autograd.Function,), rules)
    applied: Callable[[Any], Any] = function.apply
    return applied


def _imported(name: str) -> Any:
    """Imported package; the error for a missing one says how to install it."""
    from importlib import import_module

    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f'{name} is missing: pip install "varcontact[{name}]"') from error


@dataclass(frozen=True)
class _Contact:
    """A scene as a function from an array of numbers to one of outputs."""

    scene: Scene
    outputs: list[str | Output]
    inputs: list[str]
    edge: EdgeName
    methods: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, scene: Scene, outputs: Any, inputs: Any, edge: EdgeName, methods: dict[str, Any]
    ) -> _Contact:
        """The contact with outputs and inputs that are looked up once."""
        for name, given in (("outputs", outputs), ("inputs", inputs)):
            if isinstance(given, str) or not given:
                raise SceneError(name, given, "a list of names")
        paths = [path_of(name) for name in inputs]
        for path in paths:
            number_of(scene, path)
        for each in outputs:
            output_of(each)
        return cls(scene, list(outputs), paths, edge, methods)

    def values(self, x: Any) -> np.ndarray:
        """Outputs (..., outputs) at numbers (..., inputs)."""
        return self.values_and_slopes(x)[0]

    def values_and_slopes(self, x: Any) -> tuple[np.ndarray, np.ndarray]:
        """Outputs (..., outputs) and their derivatives (..., outputs, inputs)."""
        given = np.asarray(x)
        if given.ndim == 0 or given.shape[-1] != len(self.inputs):
            raise checks.wrong_shape("x", given.shape, f"(..., {len(self.inputs)})")
        shape = given.shape[:-1]
        rows = [self._row(row) for row in given.reshape(-1, len(self.inputs)).astype(float)]
        values = np.array([row[0] for row in rows], given.dtype)
        slopes = np.array([row[1] for row in rows], given.dtype)
        count = len(self.outputs)
        return values.reshape(*shape, count), slopes.reshape(*shape, count, len(self.inputs))

    def _row(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Outputs and derivatives of one scene."""
        scene = self.scene
        for path, number in zip(self.inputs, numbers.tolist(), strict=True):
            scene_of, _ = number_of(scene, path)
            scene = scene_of(number)
        solution = solve(scene, **self.methods)
        found = solution.gradient(self.outputs, self.inputs, edge=self.edge, error=False)
        slopes = np.stack([found[path].to_numpy() for path in self.inputs], axis=-1)
        return found["value"].to_numpy(), slopes
