"""Bodies that are no half-spaces: what a scene takes, and what refuses them."""

import pytest

import varcontact as vc

COAT = vc.Layered([vc.Layer(h=0.1, G=4.0, nu=0.3)], base=(1.0, 0.25))
HALF_SPACE = vc.Bodies(G=2.0, nu=0.3)
ENTRIES = {"surface": vc.Paraboloids(1.0, 1.0), "normal_force": 0.1, "friction": 0.3, "motion": vc.Steady(vx=1e-3)}


def test_one_body_stands_for_two():
    bodies = vc.Scene(bodies=COAT, **ENTRIES).bodies
    assert (bodies.upper, bodies.lower, bodies.coupled) == (COAT, COAT, False)
    assert (bodies.combined_G, bodies.combined_nu) == (4.0, 0.3)


def test_a_pair_has_the_constants_of_its_surfaces():
    pair = vc.Scene(bodies=(COAT, HALF_SPACE), **ENTRIES).bodies
    surfaces = vc.Bodies(G=(4.0, 2.0), nu=0.3)
    assert pair.coupled and pair.combined_G == surfaces.combined_G
    assert pair.softest.pairs[0] == (1.0, 2.0)


def test_two_half_spaces_are_plain_bodies():
    assert vc.Scene(bodies=(HALF_SPACE, vc.Bodies(1.0, 0.2)), **ENTRIES).bodies == vc.Bodies(
        G=(2.0, 1.0), nu=(0.3, 0.2)
    )


def test_no_hertz():
    scene = vc.Scene(bodies=COAT, **ENTRIES)
    assert scene.hertz is None
    for options in ({"normal": "hertz"}, {"tangential": "fastsim"}):
        with pytest.raises(vc.SceneError, match="half-spaces") as refused:
            vc.plan(scene, **options)
        assert refused.value.field == next(iter(options))
    with pytest.raises(vc.SceneError, match="Paraboloids"):
        vc.Scene(bodies=COAT, **ENTRIES | {"surface": vc.Ellipse(1.0, 1.0)})


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: vc.Layer(h=0.0, G=1.0, nu=0.3), "layer.h"),
        (lambda: vc.Layer(h=1.0, G=float("inf"), nu=0.3), "layer.G"),
        (lambda: vc.Layer(h=1.0, G=1.0, nu=0.6), "layer.nu"),
        (lambda: vc.Layered([], base="rigid"), "bodies.layers"),
        (lambda: vc.Layered([vc.Layer(1.0, 1.0, 0.3)], base="soft"), "bodies.base"),
        (lambda: vc.Layered([vc.Layer(1.0, 1.0, 0.3)], base=(0.0, 0.3)), "bodies.base[0]"),
        (lambda: vc.Scene(bodies=(COAT, vc.Bodies(G=(1.0, 2.0), nu=0.3)), **ENTRIES), "bodies.lower"),
        (lambda: vc.Scene(bodies=(COAT, 3.0), **ENTRIES), "bodies.lower"),
    ],
)
def test_bad_bodies_are_named(make, field):
    with pytest.raises(vc.SceneError) as refused:
        make()
    assert refused.value.field == field
