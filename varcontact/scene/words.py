"""Names that people know from other programs and books, and what to write instead."""

CREEPAGES = {
    "cksi": "vx, the longitudinal creepage",
    "ceta": "vy, the lateral creepage",
    "cphi": "spin",
    "phi": "spin",
    "xi": "vx, the longitudinal creepage",
    "eta": "vy, the lateral creepage",
}
STEADY = CREEPAGES | {
    "ux": "Shift for a shift, or vx for a creepage",
    "uy": "Shift for a shift, or vy for a creepage",
}
SHIFT = {"vx": "ux, or Steady for a creepage", "vy": "uy, or Steady for a creepage", "spin": "rotation"}
GRID = {"mx": "nx", "my": "ny", "xl": "x0", "yl": "y0", "n": "nx and ny"}
BODIES = {"E": "Bodies.from_young(E, nu)", "mu": "G for the modulus of rigidity, and friction in the Scene"}
SCENE = {
    "FN": "normal_force",
    "fn": "normal_force",
    "Fz": "normal_force",
    "N": "normal_force",
    "pen": "approach",
    "penetration": "approach",
    "mu": "friction",
    "fstat": "friction",
    "f": "friction",
    "vx": "motion=Steady(vx=...)",
    "vy": "motion=Steady(vy=...)",
    "spin": "motion=Steady(spin=...)",
    "material": "bodies",
    "geometry": "surface",
}
