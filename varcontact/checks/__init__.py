"""Checks of inputs: each returns the clean value or raises a SceneError that names the field."""

from varcontact.checks.arguments import named
from varcontact.checks.arrays import array, broadcasting, dimensions, is_array, numbers, poisson, positives, wrong_shape
from varcontact.checks.single import LARGE, computable, moderate, number, positive, real, whole, wholes
from varcontact.checks.words import (
    choice,
    elastic,
    exactly_one,
    file_name,
    flag,
    nearest,
    progress,
    short,
    short_entries,
)

__all__ = [
    "LARGE",
    "array",
    "broadcasting",
    "choice",
    "computable",
    "dimensions",
    "elastic",
    "exactly_one",
    "file_name",
    "flag",
    "is_array",
    "moderate",
    "named",
    "nearest",
    "number",
    "numbers",
    "poisson",
    "positive",
    "positives",
    "progress",
    "real",
    "short",
    "short_entries",
    "whole",
    "wholes",
    "wrong_shape",
]
