"""Thresholds that a sweep stores for its maps."""

import json

import pytest

import clearance as cl
from clearance.files.texts import signed
from clearance.sweeping import definition as definitions
from clearance.sweeping.definition import regimes
from clearance.sweeping.sweep import define

MIXED = {"model": "mixed", "joints": "B,C", "roughness": 1e-6}
JOINT = {"roughness": 1e-6, "dry": 0.4, "mixed": 1.0, "full": 3.0}


def stated(fixed, **swept):
    """Regimes of a sweep of the feeder."""
    return regimes(
        define("six_bar_feeder", cl.grid(**swept), fixed, [], 0, None, (), {"turns": 1.0})
    )


def test_what_all_points_share_is_stored():
    """Thresholds of every joint; those that differ at one end of what is swept are left out."""
    assert stated(MIXED, speed=[10.0, 20.0]) == {"B": JOINT, "C": JOINT}
    swept = stated(MIXED, speed=[10.0, 20.0], thresholds=["0.4,1,3", "0.5,1,3"])
    assert swept["C"] == {n: v for n, v in JOINT.items() if n != "dry"}
    rough = {"model": "mixed", "transition": "load_sharing(full=4)"}
    swept = stated(rough | {"asperity": "greenwood_tripp"}, roughness=[1e-6, 2e-6])
    assert swept == {"B": {"dry": 0.4, "mixed": 1.0, "full": 4.0}}


def test_nothing_is_stored_of_joints_without_a_transition():
    """Dry ones; those that have one at some points only; a point that is none does not count."""
    assert stated({"model": "dry"}, speed=[10.0, 20.0]) == {}
    assert stated({}, model=["mixed", "lubricated"], speed=[10.0, 20.0]) == {}
    assert stated({"model": "mixed"}, clearance=[0.0, 1e-4])["B"]["full"] == 3.0


def test_elastic_joints_have_none():
    """Their transition goes by the elastic film, not by the ratio that maps draw. The word true and
    the value are one.
    """
    for elastic in ("true", True):
        assert stated(MIXED | {"elastic": elastic}, speed=[10.0, 20.0]) == {}


def test_a_sweep_keeps_them(tmp_path):
    """In its directory; one of before has none, and numbers that are none are refused."""
    points, fixed = cl.grid(speed=[30.0, 31.0]), {"model": "mixed"}
    folder = tmp_path / "s"
    swept = cl.sweep("six_bar_feeder", points, folder, fixed=fixed, turns=0.01, channels=[])
    assert cl.open_sweep(folder).definition.regimes["B"]["mixed"] == 1.0
    document = json.loads(swept.definition.to_json())
    for wrong in ({"B": {"dry": "thin"}}, {"B": {"dry": float("nan")}}, {"B": 3.0}):
        (folder / "sweep.json").write_text(signed(document | {"regimes": wrong}))
        with pytest.raises(ValueError, match="is not the definition of a sweep"):
            definitions.read(folder)
    del document["regimes"]
    (folder / "sweep.json").write_text(signed(document))
    assert definitions.read(folder).regimes == {}
    again = cl.sweep("six_bar_feeder", points, folder, fixed=fixed, turns=0.01, channels=[])
    assert again.done.all()
    assert cl.open_sweep(folder).definition.regimes == swept.definition.regimes
