"""What a plan says that it costs, and other methods: it grows as the methods do, and follows what is solved."""

import pytest

import varcontact as vc
from varcontact.planning.costs import seconds_of


def by_method(scene):
    return {cost.method: cost for cost in vc.plan(scene).costs}


def test_costs_of_all_methods_that_lead_there(rolling):
    found = by_method(rolling(grid=vc.Grid(nx=40, ny=40)))
    assert list(found) == ["auto", "convex", "active-set"]
    assert found["auto"].tangential == "newton"
    assert found["auto"].seconds < found["active-set"].seconds < found["convex"].seconds
    assert found["auto"].bytes < found["active-set"].bytes < found["convex"].bytes


def test_dense_methods_cost_the_cube_of_the_elements():
    for method in ("norm", "tang-safeguarded", "clarabel"):
        assert seconds_of(method, "complementary", 20_000) == pytest.approx(
            8 * seconds_of(method, "complementary", 10_000), rel=1e-2
        )
    assert seconds_of("newton", "", 2_000_000) < 2.2 * seconds_of("newton", "", 1_000_000)


def test_what_is_not_known_is_not_guessed(rolling):
    assert seconds_of("scs", "gap", 100) is None
    plan = vc.plan(rolling(), tangential="scs")
    assert plan.costs[0].seconds is None
    assert "seconds not known" in str(plan)


def test_many_problems_cost_more_than_one(rolling):
    scene = {"surface": vc.Paraboloids(1.0, 1.0), "grid": vc.Grid(nx=12, ny=12)}
    one = by_method(rolling(**scene))["active-set"].seconds
    for changes in (
        {"friction": vc.StaticKinetic(static=0.4, kinetic=0.3)},
        {"motion": vc.Transient(steps=10, vx=0.01)},
        {"bodies": vc.Bodies(G=(1.0, 3.0), nu=0.3)},
    ):
        assert by_method(rolling(**scene, **changes))["active-set"].seconds > 2 * one


def test_costs_are_told_in_words_and_in_json(rolling):
    plan = vc.plan(rolling(grid=vc.Grid(nx=40, ny=40)))
    assert "auto (hertz, newton): about 0.0" in str(plan)
    assert [set(cost) for cost in plan.summary()["costs"]] == [
        {"method", "normal", "tangential", "seconds", "bytes"}
    ] * 3


def test_what_does_not_fit_names_what_would(rolling, monkeypatch):
    monkeypatch.setattr("varcontact.system.memory.available", lambda: 3e7)
    with pytest.raises(vc.TooLarge, match=r'"newton" needs about 0\.\d+ GiB and 0\.\d+ s; or'):
        vc.solve(rolling(grid=vc.Grid(nx=60, ny=60)), method="active-set")
