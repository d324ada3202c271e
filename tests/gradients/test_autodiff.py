"""Contacts as functions of JAX and PyTorch, where these are installed."""

import sys

import numpy as np
import pytest

import varcontact as vc
from varcontact.autodiff import jax_function, torch_function
from varcontact.errors import SceneError

SCENE = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Paraboloids(100.0, 100.0),
    normal_force=1e-3,
    friction=0.3,
    motion=vc.Steady(vx=1e-4),
    grid=vc.Grid(nx=12, ny=12),
)
OUTPUTS = ["Fx", "Fy"]
INPUTS = ["vx", "vy", "normal_force"]
PLACE = np.array([1e-4, 2e-4, 1e-3])


def slopes():
    """The gradient itself."""
    motion = vc.Steady(vx=1e-4, vy=2e-4)
    sol = vc.solve(vc.Scene(**{**vars(SCENE), "motion": motion}), certify="none")
    found = sol.gradient(OUTPUTS, INPUTS)
    return found.value.to_numpy(), np.array([found[name] for name in INPUTS]).T


def test_jax():
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    force = jax_function(SCENE, OUTPUTS, INPUTS, certify="none")
    values, expected = slopes()
    np.testing.assert_allclose(force(PLACE), values)
    np.testing.assert_allclose(jax.jacrev(force)(PLACE), expected)
    together = jax.jit(force)(np.array([PLACE, 2 * PLACE]))
    np.testing.assert_allclose(together[0], values)
    assert together.shape == (2, 2)


def test_torch():
    torch = pytest.importorskip("torch")
    force = torch_function(SCENE, OUTPUTS, INPUTS, certify="none")
    values, expected = slopes()
    place = torch.tensor(PLACE, requires_grad=True)
    np.testing.assert_allclose(force(place).detach(), values)
    found = torch.autograd.functional.jacobian(force, place)
    np.testing.assert_allclose(found, expected)
    both = force(torch.tensor(np.array([PLACE, 2 * PLACE])))
    assert both.shape == (2, 2)


@pytest.mark.parametrize(("name", "function"), [("jax", jax_function), ("torch", torch_function)])
def test_what_is_missing_is_named(monkeypatch, name, function):
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(ImportError, match=rf"varcontact\[{name}\]"):
        function(SCENE, OUTPUTS, INPUTS)


@pytest.mark.parametrize(
    ("outputs", "inputs", "words"),
    [
        ("Fx", INPUTS, "outputs"),
        (OUTPUTS, [], "inputs"),
        (["Fz"], INPUTS, "Fz"),
        (OUTPUTS, ["f"], "f"),
    ],
)
def test_outputs_and_inputs_are_looked_up_at_once(monkeypatch, outputs, inputs, words):
    monkeypatch.setitem(sys.modules, "torch", pytest)
    with pytest.raises(SceneError, match=words):
        torch_function(SCENE, outputs, inputs)
