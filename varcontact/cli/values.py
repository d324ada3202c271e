"""Values of an option: a range, a list, or one."""

from __future__ import annotations

import numpy as np

from varcontact.errors import SceneError

VALUES = "FROM:TO:NUMBER, so many values from one end to the other; values separated by commas; or one value."


def values_of(option: str, text: str) -> np.ndarray | float:
    """The values that an option gives.

    Parameters
    ----------
    option : str
        Its name, for errors.
    text : str
        As 0:5e-3:11, or 0,1e-3,5e-3, or 1e-3.

    Raises
    ------
    SceneError
        If the text is none of these.

    Examples
    --------
    >>> values_of("--vx", "0:0.004:3").tolist()
    [0.0, 0.002, 0.004]
    >>> values_of("--vx", "0,0.001").tolist()
    [0.0, 0.001]
    """
    try:
        if ":" in text:
            first, last, number = (float(part) for part in text.split(":"))
            if number == int(number) >= 2:
                return np.linspace(first, last, int(number))
        elif "," in text:
            return np.array([float(part) for part in text.split(",")])
        else:
            return float(text)
    except (ValueError, OverflowError):
        pass
    raise SceneError(option, text, "FROM:TO:NUMBER with two values or more, values separated by commas, or one value")
