"""Kalker's rolling contact of elastic bodies as convex optimisation, with a certificate of exactness."""

from varcontact import reference
from varcontact.bodies import Bodies
from varcontact.energy import Certificate
from varcontact.errors import (
    Interrupted,
    NoContact,
    NotConverged,
    OutputError,
    Saturated,
    SceneError,
    SolverUnavailable,
    TooLarge,
    VarcontactError,
)
from varcontact.friction import ExponentialFalling, LinearFalling, RationalFalling, StaticKinetic
from varcontact.grid import Grid
from varcontact.history import History
from varcontact.io.netcdf import load
from varcontact.io.scenefile import read_scene
from varcontact.motion import Shift, Steady, TimeStep, Transient
from varcontact.plan import Plan, plan
from varcontact.plot import plot_comparison, plot_stress
from varcontact.scene import Scene
from varcontact.sizes import Matrix, Sizes
from varcontact.solution import Solution
from varcontact.solve import certify, solve
from varcontact.stress import SubsurfaceStress, stress, stress_below
from varcontact.study.bank import standard_bank
from varcontact.study.compare import compare
from varcontact.study.converge import converge
from varcontact.study.convergence import Convergence
from varcontact.study.scan import scan
from varcontact.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.units import Units

__version__ = "0.1.0"

__all__ = [
    "Bodies",
    "Certificate",
    "Convergence",
    "Cylinders",
    "Ellipse",
    "ExponentialFalling",
    "Grid",
    "History",
    "Interrupted",
    "LinearFalling",
    "Matrix",
    "NoContact",
    "NotConverged",
    "OutputError",
    "Paraboloids",
    "Plan",
    "RationalFalling",
    "SampledDistance",
    "Saturated",
    "Scene",
    "SceneError",
    "Shift",
    "Sizes",
    "Solution",
    "SolverUnavailable",
    "StaticKinetic",
    "Steady",
    "SubsurfaceStress",
    "TimeStep",
    "TooLarge",
    "Transient",
    "Units",
    "VarcontactError",
    "certify",
    "compare",
    "converge",
    "load",
    "plan",
    "plot_comparison",
    "plot_stress",
    "read_scene",
    "reference",
    "scan",
    "solve",
    "standard_bank",
    "stress",
    "stress_below",
]
