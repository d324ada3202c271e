"""The public names and where they are: `__init__.py` imports each when it is first used."""

from . import kinematics, reference, wheel_rail
from . import theories as theories
from .benchmark.comparison import SolverComparison, benchmark_solvers
from .benchmark.problem_files import save_problems
from .benchmark.problem_set import BenchmarkProblem, benchmark_problems
from .data.benchmark_scenes import standard_bank, unlike_bank
from .discrete.certificate import Certificate
from .elasticity.graded import Graded
from .elasticity.own import Elasticity
from .errors import (
    Interrupted,
    NoContact,
    NotConverged,
    OutputError,
    PlausibilityWarning,
    Saturated,
    SceneError,
    SolverUnavailable,
    TooLarge,
    VarcontactError,
    WorkersLost,
)
from .gradients.outputs import PeakPressure, Weighted
from .interfaces.carried_friction import CarriedFriction
from .interfaces.shear_strength import ShearStrength
from .io.contact_input import read_contact_input
from .io.contact_output import ContactOutput, read_contact_output
from .io.contact_results import ContactResult, read_contact_result
from .io.contact_stresses import read_contact_stresses
from .io.influence_numbers import read_influence_numbers
from .io.scene_toml import read_scene
from .plasticity.limits import shakedown
from .plasticity.plots import plot_shakedown_map
from .plasticity.shakedown_result import Shakedown
from .plotting.frequency import plot_growth
from .plotting.stress import plot_stress
from .plotting.studies import plot_comparison, plot_curve
from .plotting.traces import plot_traces
from .reference.creepage_coefficients import CreepageCoefficients, no_slip_coefficients
from .results.error_estimate import ErrorEstimate
from .results.frequency import FrequencyResponse, HarmonicSolution, corrugation_growth
from .results.history import History
from .results.plan import Matrix, Plan, Sizes
from .results.solution import Solution
from .results.stress import SubsurfaceStress, stress, stress_below
from .scene.bodies import Bodies, BodyPair, Layer, Layered, Viscoelastic, Winkler
from .scene.carried import Carried
from .scene.friction import ExponentialFalling, LinearFalling, RationalFalling, StaticKinetic
from .scene.friction_laws import FrictionLaw, PressureFalling, TemperatureFalling
from .scene.grid import Grid
from .scene.interface import Thermal, ThirdBody
from .scene.motion import Harmonic, Shift, Steady, TimeStep
from .scene.pin import PinInHole
from .scene.scene import Scene
from .scene.surface_displacement import SurfaceDisplacement
from .scene.surface_load import SurfaceLoad
from .scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from .scene.transient import Transient
from .scene.units import MM_N, SI, Units
from .solving.friction_problem import FrictionProblem, friction_problem
from .solving.methods import Methods
from .solving.own_solvers import register_solver
from .solving.plan_report import plan
from .solving.program import Program, program
from .solving.solve import certify, solve
from .solving.verify import load
from .study.compare import Comparison, compare
from .study.converge import converge
from .study.convergence import Convergence
from .study.fit import CreepCurveFit, fit_creep_curve
from .study.many import solve_many
from .study.references import ContinuumValues, Reference, continuum_values, references
from .study.scan import creep_curve, scan
from .study.sweep import Standing, read_sweep, sweep
from .study.tradeoff import Tradeoff, tradeoff
from .theories.creep_forces import CreepForces, creep_forces

__version__: str

__all__ = [
    "MM_N",
    "SI",
    "BenchmarkProblem",
    "Bodies",
    "BodyPair",
    "Carried",
    "CarriedFriction",
    "Certificate",
    "Comparison",
    "ContactOutput",
    "ContactResult",
    "ContinuumValues",
    "Convergence",
    "CreepCurveFit",
    "CreepForces",
    "CreepageCoefficients",
    "Cylinders",
    "Elasticity",
    "Ellipse",
    "ErrorEstimate",
    "ExponentialFalling",
    "FrequencyResponse",
    "FrictionLaw",
    "FrictionProblem",
    "Graded",
    "Grid",
    "Harmonic",
    "HarmonicSolution",
    "History",
    "Interrupted",
    "Layer",
    "Layered",
    "LinearFalling",
    "Matrix",
    "Methods",
    "NoContact",
    "NotConverged",
    "OutputError",
    "Paraboloids",
    "PeakPressure",
    "PinInHole",
    "Plan",
    "PlausibilityWarning",
    "PressureFalling",
    "Program",
    "RationalFalling",
    "Reference",
    "SampledDistance",
    "Saturated",
    "Scene",
    "SceneError",
    "Shakedown",
    "ShearStrength",
    "Shift",
    "Sizes",
    "Solution",
    "SolverComparison",
    "SolverUnavailable",
    "Standing",
    "StaticKinetic",
    "Steady",
    "SubsurfaceStress",
    "SurfaceDisplacement",
    "SurfaceLoad",
    "TemperatureFalling",
    "Thermal",
    "ThirdBody",
    "TimeStep",
    "TooLarge",
    "Tradeoff",
    "Transient",
    "Units",
    "VarcontactError",
    "Viscoelastic",
    "Weighted",
    "Winkler",
    "WorkersLost",
    "benchmark_problems",
    "benchmark_solvers",
    "certify",
    "compare",
    "continuum_values",
    "converge",
    "corrugation_growth",
    "creep_curve",
    "creep_forces",
    "fit_creep_curve",
    "friction_problem",
    "kinematics",
    "load",
    "no_slip_coefficients",
    "plan",
    "plot_comparison",
    "plot_curve",
    "plot_growth",
    "plot_shakedown_map",
    "plot_stress",
    "plot_traces",
    "program",
    "read_contact_input",
    "read_contact_output",
    "read_contact_result",
    "read_contact_stresses",
    "read_influence_numbers",
    "read_scene",
    "read_sweep",
    "reference",
    "references",
    "register_solver",
    "save_problems",
    "scan",
    "shakedown",
    "solve",
    "solve_many",
    "standard_bank",
    "stress",
    "stress_below",
    "sweep",
    "tradeoff",
    "unlike_bank",
    "wheel_rail",
]
