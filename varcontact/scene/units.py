"""Names of the units of a scene: for reports, files and pictures, nothing is converted."""

from __future__ import annotations

from dataclasses import dataclass

from varcontact.errors import SceneError


@dataclass(frozen=True, kw_only=True)
class Units:
    """Names of the units a scene is given in, for labels only: nothing is converted.

    Parameters
    ----------
    length, force : str
        As "mm" and "N".

    Examples
    --------
    >>> Units(length="mm", force="N").of("pressure")
    'N/mm^2'
    >>> Units(length="mm", force="N").of("force", line=True)
    'N/mm'
    """

    length: str
    force: str

    def __post_init__(self) -> None:
        for name in ("length", "force"):
            if not isinstance(getattr(self, name), str):
                raise SceneError(f"units.{name}", getattr(self, name), "a name, in quotes")

    def of(self, quantity: str, line: bool = False) -> str:
        """Unit of a quantity.

        Parameters
        ----------
        quantity : str
            "length", "force", "pressure", "moment", "spin", "area", or "1".
        line : bool
            Of a line contact: forces and moments per unit length.

        Returns
        -------
        str
            Without brackets.
        """
        L, F = self.length, self.force
        force, moment, area = (f"{F}/{L}", F, L) if line else (F, f"{F} {L}", f"{L}^2")
        names = {"length": L, "force": force, "pressure": f"{F}/{L}^2", "moment": moment, "spin": f"1/{L}"}
        return names.get(quantity, area if quantity == "area" else "1")
