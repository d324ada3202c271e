"""Kalker's rolling contact of elastic bodies as convex optimisation, with a certificate of exactness.

Scenes and errors are imported at once, the rest when it is first used, so that `import varcontact` is quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
    WorkersLost,
)
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import ExponentialFalling, LinearFalling, RationalFalling, StaticKinetic
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.scene.units import MM_N, SI, Units

if TYPE_CHECKING:
    from varcontact import kinematics, reference, wheel_rail
    from varcontact.discrete.certificate import Certificate
    from varcontact.io.contact_input import read_contact_input
    from varcontact.io.contact_output import ContactOutput, read_contact_output
    from varcontact.io.contact_results import ContactResult, read_contact_result
    from varcontact.io.scene_file import read_scene
    from varcontact.plotting.curve import plot_curve
    from varcontact.plotting.stress import plot_stress
    from varcontact.plotting.studies import plot_comparison
    from varcontact.reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
    from varcontact.results.error_estimate import ErrorEstimate
    from varcontact.results.history import History
    from varcontact.results.plan import Matrix, Plan, Sizes
    from varcontact.results.refinement import Refinement
    from varcontact.results.solution import Solution
    from varcontact.results.stress import SubsurfaceStress, stress, stress_below
    from varcontact.solving.plan_report import plan
    from varcontact.solving.remeasured import load
    from varcontact.solving.solve import certify, solve
    from varcontact.study.bank import standard_bank, unlike_bank
    from varcontact.study.compare import compare
    from varcontact.study.converge import converge
    from varcontact.study.convergence import Convergence
    from varcontact.study.curve import creep_curve
    from varcontact.study.front import Tradeoff
    from varcontact.study.references import Reference, references
    from varcontact.study.scan import scan
    from varcontact.study.sweep import Standing, read_sweep, sweep
    from varcontact.study.tradeoff import tradeoff
    from varcontact.theories.creep_forces import CreepForces, creep_forces

__version__ = "0.1.0"

__all__ = [
    "MM_N",
    "SI",
    "Bodies",
    "Certificate",
    "ContactOutput",
    "ContactResult",
    "Convergence",
    "CreepForces",
    "CreepageCoefficients",
    "Cylinders",
    "Ellipse",
    "ErrorEstimate",
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
    "Reference",
    "Refinement",
    "SampledDistance",
    "Saturated",
    "Scene",
    "SceneError",
    "Shift",
    "Sizes",
    "Solution",
    "SolverUnavailable",
    "Standing",
    "StaticKinetic",
    "Steady",
    "SubsurfaceStress",
    "TimeStep",
    "TooLarge",
    "Tradeoff",
    "Transient",
    "Units",
    "VarcontactError",
    "WorkersLost",
    "certify",
    "compare",
    "converge",
    "creep_curve",
    "creep_forces",
    "kinematics",
    "load",
    "no_slip_coefficients",
    "plan",
    "plot_comparison",
    "plot_curve",
    "plot_stress",
    "read_contact_input",
    "read_contact_output",
    "read_contact_result",
    "read_scene",
    "read_sweep",
    "reference",
    "references",
    "scan",
    "solve",
    "standard_bank",
    "stress",
    "stress_below",
    "sweep",
    "tradeoff",
    "unlike_bank",
    "wheel_rail",
]

# where the names are that are imported when they are first used
_PLACES = {
    "varcontact.io.contact_input": ("read_contact_input",),
    "varcontact.io.contact_output": ("ContactOutput", "read_contact_output"),
    "varcontact.io.contact_results": ("ContactResult", "read_contact_result"),
    "varcontact.io.scene_file": ("read_scene",),
    "varcontact.plotting.curve": ("plot_curve",),
    "varcontact.plotting.stress": ("plot_stress",),
    "varcontact.plotting.studies": ("plot_comparison",),
    "varcontact.discrete.certificate": ("Certificate",),
    "varcontact.reference.creepage_coefficients": ("CreepageCoefficients", "no_slip_coefficients"),
    "varcontact.results.error_estimate": ("ErrorEstimate",),
    "varcontact.results.history": ("History",),
    "varcontact.results.plan": ("Matrix", "Plan", "Sizes"),
    "varcontact.results.refinement": ("Refinement",),
    "varcontact.results.solution": ("Solution",),
    "varcontact.results.stress": ("SubsurfaceStress", "stress", "stress_below"),
    "varcontact.solving.plan_report": ("plan",),
    "varcontact.solving.remeasured": ("load",),
    "varcontact.solving.solve": ("certify", "solve"),
    "varcontact.study.bank": ("standard_bank", "unlike_bank"),
    "varcontact.study.compare": ("compare",),
    "varcontact.study.converge": ("converge",),
    "varcontact.study.convergence": ("Convergence",),
    "varcontact.study.curve": ("creep_curve",),
    "varcontact.study.front": ("Tradeoff",),
    "varcontact.study.references": ("Reference", "references"),
    "varcontact.study.scan": ("scan",),
    "varcontact.study.sweep": ("Standing", "read_sweep", "sweep"),
    "varcontact.study.tradeoff": ("tradeoff",),
    "varcontact.theories.creep_forces": ("CreepForces", "creep_forces"),
}
_PACKAGES = ("kinematics", "reference", "theories", "wheel_rail")

if not TYPE_CHECKING:  # a type checker would take any name for a name of this module

    def __getattr__(name: str) -> Any:
        """Import a public name when it is first used."""
        if name in _PACKAGES:
            return import_module(f"varcontact.{name}")
        for place, names in _PLACES.items():
            if name in names:
                found = globals()[name] = getattr(import_module(place), name)
                return found
        raise AttributeError(f"module 'varcontact' has no attribute {name!r}")


def __dir__() -> list[str]:
    """The public names alone."""
    return sorted([*__all__, "__version__"])
