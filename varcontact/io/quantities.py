"""Quantities of solutions and sweeps in files, by name: dimensions if any, the quantity that gives
the unit, and a description.
"""

from __future__ import annotations

ELEMENTS = ("y", "x")
PARTS = ("y_parts", "x_parts")
FIELDS = {
    "pressure": (ELEMENTS, "pressure", "normal traction, compression positive"),
    "traction": (("component", *ELEMENTS), "pressure", "tangential traction on body 1"),
    "slip": (("component", *ELEMENTS), "slip", "relative slip of body 1 over body 2"),
    "power_density": (
        ELEMENTS,
        "power density",
        "work lost by friction per area, per distance rolled",
    ),
    "distance": (ELEMENTS, "length", "deformed distance"),
    "state": (ELEMENTS, "1", "0 exterior, 1 stick, 2 slip, 3 plastic"),
    "traction_bound": (ELEMENTS, "pressure", "friction coefficient times pressure"),
    "normal_force": ((), "force", "total compressive force"),
    "force": (("component",), "force", "total tangential force on body 1"),
    "moment": ((), "moment", "twisting moment on body 1 about the origin"),
    "approach": ((), "length", "approach of the bodies"),
    "creepage": (
        ("rigid",),
        "1",
        "longitudinal, lateral and spin creepage (of a shift: ux, uy, rotation)",
    ),
}
AROUND = ("relaxation", "axis", "y_around", "x_around")
CARRIED = {
    "weakening": (
        ELEMENTS,
        "1",
        "part of static - kinetic friction that particles have lost by slip",
    ),
    "memory": (AROUND, "pressure", "tractions that viscoelastic bodies remember"),
    "plastic_displacement": (
        ("component", *ELEMENTS),
        "length",
        "plastic displacement of the layer between the bodies",
    ),
    "yield_stress": (ELEMENTS, "pressure", "yield stress of the layer between the bodies"),
}
"""Quantities that particles carry."""
OPTIONAL = {"pressure_on_parts": (PARTS, "pressure", "normal traction, on parts of elements")}
"""Fields that only some solutions have: on parts of elements."""
EARLIER = {"plastic": ("flow", *ELEMENTS)}
"""Fields of earlier versions: plastic displacement and yield stress in one."""

NUMBERS = {
    "normal_force": ("force", "total compressive force"),
    "approach": ("length", "approach of the bodies"),
    "Fx": ("force", "longitudinal force on body 1"),
    "Fy": ("force", "lateral force on body 1"),
    "Mz": ("moment", "twisting moment on body 1"),
    "vx": ("creepage", "longitudinal creepage (of a shift: ux)"),
    "vy": ("creepage", "lateral creepage (of a shift: uy)"),
    "spin": ("spin creepage", "spin creepage (of a shift: rotation)"),
    "contact_area": ("area", "area of contact"),
    "stick_area": ("area", "area of stick"),
    "slip_area": ("area", "area of slip"),
    "max_pressure": ("pressure", "largest pressure"),
    "friction_work": ("work", "work lost by friction: per distance rolled, of a shift in all"),
    "gap": ("moment", "duality gap"),
    "relative_gap": ("1", "relative duality gap"),
    "residual": ("1", "residual by the largest traction"),
    "Fx_bound": ("force", "bound on the error of Fx on this grid"),
    "Fy_bound": ("force", "bound on the error of Fy on this grid"),
    "Mz_bound": ("moment", "bound on the error of Mz on this grid"),
}
"""Quantity that gives the unit, and description, of each number by its name."""
COUNTS = {
    "contact": ("1", "elements in contact"),
    "stick": ("1", "elements that stick"),
    "slip": ("1", "elements that slip"),
    "iterations": ("1", "iterations"),
}
ERRORS = {
    f"{name}_error": (NUMBERS[name][0], f"error bar of {name}")
    for name in ("Fx", "Fy", "Mz", "vx", "vy")
}
"""Error bars of sweeps to an accuracy or within a time."""
