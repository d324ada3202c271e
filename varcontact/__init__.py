"""Kalker's rolling contact of elastic bodies as convex optimisation, with a
certificate of exactness.

The public names are listed in ``__init__.pyi``; each is imported when it is
first used, so that `import varcontact` is quick.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

_RENAMED = {
    "varcontact.results.normalised": "varcontact.results.physical",
    "varcontact.solvers.tally": "varcontact.solvers.interface",
    "varcontact.solvers.statistics": "varcontact.solvers.interface",
    "varcontact.solving.error_norm": "varcontact.results.quantities_of_interest",
    "varcontact.solving.ways": "varcontact.solving.discretisation_variants",
    "varcontact.study.table_make": "varcontact.data.make_table_book",
    "varcontact.study.comparison": "varcontact.study.compare",
    "varcontact.wheel_rail.fast": "varcontact.wheel_rail.virtual_penetration",
    "varcontact.wheel_rail.search": "varcontact.wheel_rail.patches",
    "varcontact.wheel_rail.series": "varcontact.wheel_rail.case_file",
    "varcontact.wheel_rail.standard_profiles": "varcontact.wheel_rail.profile_files",
}
"""Modules by their earlier documented names, which can still be imported."""


class _Renamed(MetaPathFinder, Loader):
    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(name, self) if name in _RENAMED else None

    def exec_module(self, module: ModuleType) -> None:
        names = vars(import_module(_RENAMED[module.__name__]))
        vars(module).update(
            {name: value for name, value in names.items() if not name.startswith("__")}
        )


sys.meta_path.append(_Renamed())
