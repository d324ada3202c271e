"""Values that nobody means, for entries of files and for arguments."""

import datetime
import decimal
import fractions
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Deep:
    """Lists within lists, in a file."""

    depth: int

    def __str__(self) -> str:
        return "[" * self.depth + "]" * self.depth

    def made(self) -> list:
        """As a value of Python."""
        value = []
        for _ in range(self.depth):
            value = [value]
        return value


NUMBERS = [
    *(
        0,
        1,
        -1,
        2,
        7,
        0.5,
        -0.5,
        1.5,
        1e-3,
        1e3,
        1e9,
        1e20,
        1e99,
        1e101,
        1e200,
        1e308,
        -1e308,
        1e-99,
        1e-200,
        5e-324,
    ),
    *(10**9, 10**12, 2**63, 10**30, float("inf"), float("-inf"), float("nan"), -0.0),
]
"""Numbers of all sizes, that a file can have."""

WORDS = [
    *(
        "",
        "none",
        "None",
        "auto",
        "nan",
        "1",
        "1e3",
        "6²",
        "٣",
        "héhé",
        "🚂",
        "../..",
        "~",
        "clarabel",
        "cvxpy:",
    ),
    *(
        "qpsolvers:x",
        "steady",
        "shift",
        "%s{}",
        "\u202e",
        "ß" * 300,
        "a\nb",
        "$\\frac{",
        "\x7f",
        "x" * 100_000,
    ),
]
"""Words, that a file can have."""

LISTS = [
    *(
        [],
        [[]],
        [1.0],
        [1.0, 2.0],
        [1, "a"],
        [[1, 2], [3]],
        [[1.0, 2.0], [3.0, 4.0]],
        [[[1.0]]],
        [True, False],
        [None],
    ),
    *(
        [float("nan")],
        [1e308] * 3,
        [0.0] * 1000,
        [{}],
        [{"kind": "shift"}],
        {},
        {"kind": "steady"},
        {"file": "x"},
    ),
    *(
        {"file": 3},
        {"kind": 3},
        {"": 1},
        {"a": {"b": {"c": {}}}},
        Deep(50),
        Deep(900),
        Deep(20_000),
    ),
]
"""Lists and tables, that a file can have."""

PLAIN = [*NUMBERS, *WORDS, *LISTS, True, False]
"""All that a file can have; of TOML also dates, of JSON also null."""


class Hostile:
    """An object none of whose methods work."""

    def __repr__(self) -> str:
        raise RuntimeError("no repr")

    def __float__(self) -> float:
        raise RuntimeError("no float")

    def __len__(self) -> int:
        raise RuntimeError("no length")


def objects() -> list:
    """What only a Python call can give; made anew, as calls might change it."""
    cyclic = []
    cyclic.append(cyclic)
    return [
        *(
            None,
            b"x",
            1 + 2j,
            np.True_,
            np.float32(1),
            np.int8(-3),
            np.longdouble(1),
            np.datetime64("nat"),
        ),
        *(
            10**400,
            10**5000,
            -(10**5000),
            decimal.Decimal("1.5"),
            decimal.Decimal("NaN"),
            fractions.Fraction(1, 3),
        ),
        *(
            object(),
            object,
            Hostile(),
            len,
            lambda *_: None,
            Ellipsis,
            NotImplemented,
            int,
            Path("x"),
        ),
        *(
            set(),
            {1, 2},
            frozenset(),
            range(3),
            iter([1.0]),
            (x for x in [1.0]),
            cyclic,
            datetime.date(2000, 1, 1),
        ),
        *(
            np.zeros(0),
            np.zeros((0, 3)),
            np.zeros((2, 2, 2)),
            np.array(["a"]),
            np.array([1 + 1j]),
            np.array([None]),
        ),
        *(
            np.full((3, 3), np.nan),
            np.full(3, np.inf),
            np.ma.masked_array([1.0, 2.0], [True, False]),
            np.array(3.0),
        ),
        *(
            np.array([True, False]),
            np.ones((3, 3)),
            np.ones(3),
            np.full((3, 3), 1e308),
            np.array([10**400], object),
        ),
        *(np.ones((3, 3), dtype="timedelta64[s]"), np.zeros(3, dtype=[("a", float)])),
        np.broadcast_to(1.0, (10**8, 10**8)),
        *(
            Path("/dev/null"),
            "\0",
            "\ud800",
            "x\0.nc",
            bytearray(b"1"),
            memoryview(b"1"),
            type("Odd", (), {})(),
        ),
    ]
