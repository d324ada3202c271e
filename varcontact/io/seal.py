"""A checksum behind the bytes of a solution's file, where netCDF and HDF5 do not look.

HDF5 has none over the whole file, and does not come to an end in some that are damaged.
"""

from __future__ import annotations

import hashlib

MARK = b"\nvarcontact sha256 "


def sealed(content: bytes) -> bytes:
    """The bytes of a file with their checksum behind them."""
    return content + MARK + _digest(content)


def unsealed(content: bytes) -> bytes:
    """The bytes of a file without the checksum, which they have to fit; as they are, where there is none.

    A file that another program has written anew has none.
    """
    own, digest = content[:-64], content[-64:]
    if not own.endswith(MARK):
        return content
    own = own.removesuffix(MARK)
    if _digest(own) != digest:
        raise ValueError("its bytes are not those that were written")
    return own


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()
