"""Results as labelled arrays, tables and files for other programs."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from varcontact import checks
from varcontact.io.solution import netcdf_to_bytes
from varcontact.system.files import check_replaceable, write_whole

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


class Labelled:
    """Results that are data: `to_xarray` is their own; tables, files and notebooks follow from
    it.
    """

    more_formats: ClassVar[Mapping[str, tuple[Callable[[Any], bytes], bytes]]] = {}
    """File formats besides `.nc` and `.csv`, by ending: the function that makes the bytes, and the
    pattern of how they begin."""

    def to_xarray(self) -> xr.Dataset:
        """The numbers with names, coordinates and units."""
        raise NotImplementedError

    def to_dataframe(self) -> pd.DataFrame:
        """Data as a table, coordinates as columns, without empty rows; `attrs` has the units by
        column.
        """
        data = self.to_xarray()
        columns = [str(name) for name in data.data_vars]
        frame = data.to_dataframe()
        frame = frame.dropna(subset=_numbers_of(data, columns), how="all").reset_index()
        every = [str(name) for name in data.variables]
        frame.attrs = {"units": {name: data[name].attrs.get("units", "1") for name in every}}
        return frame

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a file in the format of its ending, whole or not at all.

        ``.nc`` (netCDF) is `to_xarray`, which ``xarray.open_dataset`` reads, ``.csv`` the table
        `to_dataframe`. A file at `path` that holds the same kind of result is replaced, any other
        only with `overwrite`; OutputError where that is missing, or the file cannot be written.
        """
        mark = f"varcontact {type(self).__name__} 1"
        file = checks.file_name("path", path)
        formats: dict[str, tuple[Callable[[Any], bytes], bytes]] = {
            ".nc": (lambda result: _netcdf(result, mark), b".*" + re.escape(mark.encode())),
            ".csv": (lambda result: _csv(result), _head(self)),
            **self.more_formats,
        }
        _, ours = formats.get(file.suffix.lower(), (None, b""))
        check_replaceable("path", file, tuple(formats), type(self).__name__, ours, overwrite)
        write, _ = formats[file.suffix.lower()]
        write_whole("path", file, write(self))

    def _repr_html_(self) -> str:
        html: str = self.to_xarray()._repr_html_()
        return html


def _numbers_of(data: xr.Dataset, columns: list[str]) -> list[str]:
    """Columns that vary along all dimensions: a row without any of them is empty."""
    most = max((data[name].ndim for name in columns), default=0)
    return [name for name in columns if data[name].ndim == most]


def _netcdf(result: Labelled, mark: str) -> bytes:
    return netcdf_to_bytes(result.to_xarray().assign_attrs(format=mark))


def _csv(result: Labelled) -> bytes:
    return result.to_dataframe().to_csv(index=False).encode()


def _head(result: Labelled) -> bytes:
    """Pattern of the first line of a table: the names of its columns."""
    columns = result.to_dataframe().columns
    return re.escape(",".join(columns).encode())


def variable(dims: tuple[str, ...] | str, values: Any, unit: str, words: str) -> Any:
    """A variable of a dataset, with its unit and words."""
    return dims, np.asarray(values), {"units": unit or "1", "long_name": words}
