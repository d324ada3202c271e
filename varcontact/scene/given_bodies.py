"""Bodies that a user gives by numbers: the members that a scene needs of the pair."""

from __future__ import annotations

import base64
import hashlib
import math
import zlib
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.system.process import lazy_property

if TYPE_CHECKING:
    from varcontact.scene.grid import Grid
    from varcontact.scene.scene import Scene


class GivenBodies(ABC):
    """Both bodies of a scene, given by numbers."""

    longest_relaxation: ClassVar[float] = 0.0
    relaxes: ClassVar[bool] = False
    slides: ClassVar[bool] = False

    @property
    @abstractmethod
    def combined_G(self) -> float:
        """A modulus of rigidity by which tractions are scaled [stress]."""

    @property
    @abstractmethod
    def combined_nu(self) -> float:
        """Poisson's ratio that belongs to `combined_G`."""

    @property
    @abstractmethod
    def K(self) -> float:
        """Size of the coupling of pressure and tractions; 0: independent."""

    @property
    def coupled(self) -> bool:
        """True where pressure and tractions depend on each other."""
        return self.K != 0

    @property
    def grounded(self) -> bool:
        """True where displacements count from places that do not move."""
        return False

    @property
    def by_place(self) -> bool:
        """True where influence numbers depend on more than the offset of elements."""
        return False

    @property
    @abstractmethod
    def softest(self) -> Any:
        """Half-spaces with a contact at least as large; None: the grid must be given."""

    @abstractmethod
    def check(self, scene: Scene) -> None:
        """Refuse a scene whose grid, surface or motion these bodies have no numbers for."""

    @abstractmethod
    def reaches(self, grid: Grid) -> bool:
        """True where there are numbers for a grid, and places beyond the scene's own."""

    @abstractmethod
    def medium(self, length: float, depth: float) -> Any:
        """The medium in units of a length; in line contact displacements count from a depth."""


@dataclass(frozen=True, eq=False)
class Numbers:
    """An array that does not change: equal to another one of the same shape and bytes.

    Examples
    --------
    >>> one = Numbers.of([1.0, 2.0])
    >>> one == Numbers.of([1.0, 2.0]), one == Numbers.of([[1.0, 2.0]])
    (True, False)
    >>> Numbers.of_table("numbers", one.to_table()) == one
    True
    """

    array: np.ndarray

    @classmethod
    def of(cls, values: Any) -> Numbers:
        """A copy of real numbers."""
        array = np.array(values, dtype="<f8")
        array.flags.writeable = False
        return cls(array)

    @classmethod
    def of_table(cls, field: str, table: Mapping[str, Any]) -> Numbers:
        """Array from a file, whose checksum must match."""
        refusal = SceneError(
            field, "numbers", message=f"{field}: the numbers are not those that were written"
        )
        try:
            shape = [checks.whole(field, size, least=0) for size in table["shape"]]
            size = 8 * math.prod(shape)
            packed = base64.b64decode(table["float64"], validate=True)
            data = zlib.decompressobj().decompress(packed, size + 1)
            array = np.frombuffer(data, dtype="<f8").reshape(shape)
        except (KeyError, TypeError, ValueError, zlib.error, MemoryError):
            raise refusal from None
        made = cls.of(array)
        if made.sha256 != table.get("sha256"):
            raise refusal
        return made

    def to_table(self) -> dict[str, Any]:
        """The array as text, with its checksum."""
        text = base64.b64encode(zlib.compress(self.array.tobytes(), 1)).decode()
        return {"float64": text, "shape": list(self.array.shape), "sha256": self.sha256}

    @lazy_property
    def sha256(self) -> str:
        """The checksum of shape and bytes."""
        shape = str(self.array.shape).encode()
        return hashlib.sha256(shape + self.array.tobytes()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Numbers) and self.sha256 == other.sha256

    def __hash__(self) -> int:
        return hash(self.sha256)

    def __repr__(self) -> str:
        return f"Numbers(shape={self.array.shape}, sha256={self.sha256[:12]})"
