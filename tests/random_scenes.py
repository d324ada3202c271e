"""Random scenes by kind, for studies of accuracy: what they are made of does not depend on any
grid.
"""

from dataclasses import dataclass, replace

import numpy as np

import varcontact as vc
from varcontact.study.converge import contact_of

KINDS = tuple(
    """
steady, forces, shift, unlike, unlike shift, line, line unlike, line forces, line shift, line unlike
shift, sampled, sampled shift, sampled normal, law, history, unlike history, line history, line
unlike history, sampled history, line sampled, line sampled shift, slender, slender shift, any law,
any law shift, patches, patches normal
""".replace("\n", " ")
    .strip()
    .split(", ")
)


def scenes(kind: str, count: int, seed: int) -> list[vc.Scene]:
    """So many scenes of a kind; the same for the same seed. A history has the bodies and creepages
    of such a scene.
    """
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    if not kind.endswith("history"):
        return [_scene(rng, kind) for _ in range(count)]
    like = kind.removesuffix("history").strip() or "steady"
    return [_history(rng, _scene(rng, like)) for _ in range(count)]


@dataclass(frozen=True)
class _Drawn:
    """What most scenes have: Poisson's ratio, semi-axes, friction, and slip by direction and
    size.
    """

    nu: float
    a: float
    b: float
    f: float
    slip: np.ndarray
    part: float
    angle: float

    @property
    def mean(self) -> float:
        return float(np.sqrt(self.a * self.b))


def _drawn(rng: np.random.Generator) -> _Drawn:
    ratio = float(np.exp(rng.uniform(np.log(0.12), np.log(8))))
    slip = rng.normal(size=3)
    kind = rng.random()
    if kind < 0.3:
        slip = np.where(np.arange(3) == rng.integers(3), slip, 0.0)  # pure creepage
    elif kind < 0.55:
        slip[2] = 0.0
    size = float(np.exp(rng.uniform(np.log(0.05), np.log(3))))
    nu = float(rng.choice([0.0, 0.1, 0.28, 0.28, 0.4, 0.5]))
    f = float(rng.choice([0.05, 0.1, 0.3, 0.3, 0.6]))
    slip *= size / np.linalg.norm(slip)
    return _Drawn(
        nu,
        ratio**0.5,
        ratio**-0.5,
        f,
        slip,
        float(rng.uniform(0.05, 0.97)),
        float(rng.uniform(0, 2 * np.pi)),
    )


def _slender(rng: np.random.Generator, drawn: _Drawn) -> _Drawn:
    """The same with an a/b, or b/a, from 8 to 33, and Poisson's ratios down to -0.5."""
    ratio = float(np.exp(rng.choice([-1, 1]) * rng.uniform(np.log(8), np.log(33))))
    return replace(drawn, a=ratio**0.5, b=ratio**-0.5, nu=float(rng.choice([-0.5, 0.0, 0.28, 0.5])))


def _scene(rng: np.random.Generator, kind: str) -> vc.Scene:
    drawn = _slender(rng, _drawn(rng)) if kind.startswith("slender") else _drawn(rng)
    if kind.startswith("line"):
        return _line(rng, kind, drawn)
    if kind.startswith("sampled"):
        return _sampled(rng, kind, drawn)
    if kind.startswith("patches"):
        return _patches(rng, kind, drawn)
    bodies = _unlike(rng) if kind.startswith("unlike") else vc.Bodies(G=1.0, nu=drawn.nu)
    if kind.startswith("unlike"):
        surface: vc.Paraboloids | vc.Ellipse = vc.Paraboloids(Rx=(drawn.a / drawn.b) ** 1.3, Ry=1.0)
        force = 1e-4
    else:
        surface, force = vc.Ellipse(a=drawn.a, b=drawn.b), 1.0
    hertz = vc.Scene(bodies=bodies, surface=surface, normal_force=force).hertz
    limit, mean = drawn.f * force, float(np.sqrt(hertz.a * hertz.b))
    friction: (
        float | vc.StaticKinetic | vc.LinearFalling | vc.RationalFalling | vc.ExponentialFalling
    ) = drawn.f
    if kind == "law":
        friction = vc.LinearFalling(
            static=drawn.f, kinetic=0.8 * drawn.f, half_velocity=float(rng.uniform(1, 4)) * limit
        )
    if kind.startswith("any law"):
        friction = _any_law(rng, drawn, hertz.a * hertz.b, kind.endswith("shift"))
    if kind.endswith("shift"):
        motion: vc.Steady | vc.Shift = _shift(drawn, bodies, limit, mean)
    else:
        motion = _steady(drawn, bodies, limit, hertz.a, hertz.b, rng if kind == "forces" else None)
    return vc.Scene(
        bodies=bodies, surface=surface, normal_force=force, friction=friction, motion=motion
    )


def _any_law(
    rng: np.random.Generator, drawn: _Drawn, area: float, shifted: bool
) -> vc.StaticKinetic | vc.LinearFalling | vc.RationalFalling | vc.ExponentialFalling:
    """One of four laws; half is lost at 0.003 to 3 times the creepage, or the shift, of
    saturation.
    """
    kinetic, full = (
        drawn.f * float(rng.uniform(0.1, 0.9)),
        0.7 * drawn.f * (area**0.5 if shifted else 1.0) / area,
    )
    half = full * float(np.exp(rng.uniform(np.log(0.003), np.log(3))))
    falling = [vc.LinearFalling, vc.RationalFalling, vc.ExponentialFalling][rng.integers(3)]
    if rng.random() < 0.25:
        return vc.StaticKinetic(static=drawn.f, kinetic=kinetic)
    return falling(static=drawn.f, kinetic=kinetic, half_velocity=half)


def _unlike(rng: np.random.Generator) -> vc.Bodies:
    return vc.Bodies(
        G=(1.0, float(np.exp(rng.uniform(0, 3)))), nu=tuple(map(float, rng.uniform(0, 0.5, 2)))
    )


def _steady(
    drawn: _Drawn,
    bodies: vc.Bodies,
    limit: float,
    a: float,
    b: float,
    forces: np.random.Generator | None,
) -> vc.Steady:
    full = 3 * limit / (bodies.combined_G * a * b * 4.5)  # about the saturation creepage
    vx, vy, spin = (float(v) for v in drawn.slip * full * [1, 1, 1.5 / np.sqrt(a * b)])
    if forces is None:
        return vc.Steady(vx=vx, vy=vy, spin=spin)
    Fx, Fy = drawn.part * limit * np.cos(drawn.angle), drawn.part * limit * np.sin(drawn.angle)
    given: list[dict[str, float]] = [
        {"Fx": Fx, "vy": 0.3 * vy},
        {"Fy": Fy, "vx": 0.3 * vx},
        {"Fx": Fx, "Fy": Fy},
    ]
    return vc.Steady(**given[forces.integers(3)], spin=0.3 * spin)


def _shift(drawn: _Drawn, bodies: vc.Bodies, limit: float, mean: float) -> vc.Shift:
    full = 3 * (2 - bodies.combined_nu) * limit / (8 * bodies.combined_G * mean)  # Cattaneo's
    ux, uy, rotation = (float(u) for u in drawn.slip * full * [1, 1, 1 / mean])
    return vc.Shift(ux=ux, uy=uy, rotation=rotation)


def _line(rng: np.random.Generator, kind: str, drawn: _Drawn) -> vc.Scene:
    bodies, force = _unlike(rng) if "unlike" in kind else vc.Bodies(G=1.0, nu=drawn.nu), 0.01
    surface: vc.Cylinders | vc.SampledDistance = vc.Cylinders(1.0, reference_depth=5.0)
    if "sampled" in kind:
        surface, force = _sampled_line(rng), float(np.exp(rng.uniform(np.log(5e-3), np.log(5e-2))))
    a = half_length(vc.Scene(bodies=bodies, surface=surface, normal_force=force))
    limit = drawn.f * force
    full = 4 * (1 - bodies.combined_nu) * limit / (np.pi * bodies.combined_G * a)  # Carter's
    vx, vy, _ = (float(v) for v in drawn.slip * full)
    motion: vc.Steady | vc.Shift = vc.Steady(vx=vx, vy=vy)
    if kind == "line forces":
        motion = vc.Steady(Fx=drawn.part * limit * np.sign(np.cos(drawn.angle)), vy=0.2 * vy)
    elif kind.endswith("shift"):
        motion = vc.Shift(ux=3 * a * vx, uy=3 * a * vy)
    return vc.Scene(
        bodies=bodies, surface=surface, normal_force=force, friction=drawn.f, motion=motion
    )


def _sampled_line(rng: np.random.Generator) -> vc.SampledDistance:
    """Between parabola and quartic, or with two summits."""
    x = np.linspace(-3.0, 3.0, 601)
    h = x**2 + float(rng.uniform(0.1, 1)) * x**4
    if rng.random() < 0.5:
        h = -0.1 * np.logaddexp(*(-((x - at) ** 2) / 0.1 for at in (-0.55, 0.5)))
    return vc.SampledDistance(0.02 * h, x=x, reference_depth=5.0)


def _sampled(rng: np.random.Generator, kind: str, drawn: _Drawn) -> vc.Scene:
    """A surface between paraboloid and quartic, or with two summits, sampled finely enough for its
    spline.
    """
    x = np.linspace(-2.2, 2.2, 121)
    X, Y = np.meshgrid(x, x)
    if rng.random() < 0.5:
        quartic = float(rng.uniform(0.1, 1))
        h = sum(
            (side / axis) ** 2 + quartic * (side / axis) ** 4
            for side, axis in ((X, drawn.a), (Y, drawn.b))
        )
    else:
        h = -0.1 * np.logaddexp(*(-(((X - at) ** 2 + 1.2 * Y**2) / 0.1) for at in (-0.55, 0.5)))
    surface, bodies = vc.SampledDistance(0.02 * h, x=x, y=x), vc.Bodies(G=1.0, nu=drawn.nu)
    if kind == "sampled normal":
        return vc.Scene(
            bodies=bodies, surface=surface, normal_force=float(np.exp(rng.uniform(-7, -4)))
        )
    force = vc.solve(vc.Scene(bodies=bodies, surface=surface, approach=0.008)).normal_force
    full = 3 * drawn.f * force / 4.5 / 0.3
    vx, vy, spin = (float(v) for v in drawn.slip * full)
    motion: vc.Steady | vc.Shift = vc.Steady(vx=vx, vy=vy, spin=spin)
    if kind == "sampled shift":
        motion = vc.Shift(ux=0.3 * vx, uy=0.3 * vy, rotation=0.3 * spin)
    return vc.Scene(
        bodies=bodies, surface=surface, normal_force=force, friction=drawn.f, motion=motion
    )


def _patches(rng: np.random.Generator, kind: str, drawn: _Drawn) -> vc.Scene:
    """A ball, and one of a hundredth to half of its radius beside it, anywhere around it."""
    small, depth = (
        float(np.exp(rng.uniform(np.log(0.01), np.log(0.5)))),
        0.02 * float(np.exp(rng.uniform(-1, 1))),
    )
    half, above = float(np.sqrt(depth)), depth * (1 - float(rng.uniform(0.3, 1.5)))
    gap, angle = half * float(rng.uniform(1.5, 4)), float(rng.uniform(0, 2 * np.pi))
    x = np.linspace(-1, 1, 321) * (2.6 * half + gap / 2)
    X, Y = np.meshgrid(x, x)
    at_x, at_y = gap / 2 * np.cos(angle), gap / 2 * np.sin(angle)
    balls = (
        ((X + at_x) ** 2 + (Y + at_y) ** 2) / 2,
        ((X - at_x) ** 2 + (Y - at_y) ** 2) / (2 * small) + above,
    )
    bodies, surface = (
        vc.Bodies(G=1.0, nu=drawn.nu),
        vc.SampledDistance(np.minimum(*balls), x=x, y=x),
    )
    scene = vc.Scene(bodies=bodies, surface=surface, approach=depth, grid=vc.Grid(nx=48, ny=48))
    force = vc.solve(scene, certify="none").normal_force
    if kind == "patches normal":
        return vc.Scene(bodies=bodies, surface=surface, normal_force=force)
    vx, vy, spin = (
        float(v)
        for v in drawn.slip * drawn.f * force / (1.5 * half**2) * [1, 1, 1.5 / (half + gap)]
    )
    motion = vc.Steady(vx=vx, vy=vy, spin=spin)
    return vc.Scene(
        bodies=bodies, surface=surface, normal_force=force, friction=drawn.f, motion=motion
    )


def _history(rng: np.random.Generator, steady: vc.Scene) -> vc.Scene:
    """Steps of a length given: from rest, turned, under a load that swings, with a force from a
    shift to rolling, or to and fro in place.
    """
    motion, steps = steady.motion, int(rng.integers(4, 11))
    dq = float(np.exp(rng.uniform(np.log(0.03), np.log(0.8)))) * half_length(steady)
    rigid: dict[str, float | list[float]] = {"vx": motion.vx, "vy": motion.vy, "spin": motion.spin}
    way = rng.integers(5)
    if way == 1:
        turn = int(rng.integers(1, steps))
        rigid = {
            name: [size] * turn + [-0.5 * size] * (steps - turn) for name, size in rigid.items()
        }
    if way == 2:
        load = steady.normal_force * (1 + 0.4 * np.sin(np.arange(steps) + rng.uniform(0, 6)))
        return replace(steady, motion=vc.Transient(steps=steps, dq=dq, normal_force=load, **rigid))
    if way == 3:
        force = float(rng.uniform(-0.9, 0.9)) * steady.friction * steady.normal_force
        return replace(
            steady,
            motion=vc.Transient(
                steps=steps, dq=[0.0] + [dq] * (steps - 1), Fx=force, spin=0.3 * motion.spin
            ),
        )
    if way == 4:
        swing = 3 * half_length(steady) * np.cos(np.arange(steps) + rng.uniform(0, 6))
        moved = {"ux": swing * motion.vx, "uy": swing * motion.vy, "rotation": swing * motion.spin}
        return replace(steady, motion=vc.Transient(steps=steps, dq=0.0, **moved))
    return replace(steady, motion=vc.Transient(steps=steps, dq=dq, **rigid))


def half_length(scene: vc.Scene) -> float:
    """Half the length of a scene's contact along x."""
    if scene.hertz is not None:
        return scene.hertz.a
    left, right, _, _ = contact_of(replace(scene, motion=None, friction=None))
    return (right - left) / 2
