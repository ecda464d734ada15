"""Structures in the store: those that are traced, in another process."""

import gc

import pytest

import clearance as cl
from clearance.mechanism import build as building
from clearance.mechanism import kept, structure
from clearance.mechanism.build import build
from clearance.tracing.emission import kernel_text
from tests.mechanism.test_kernels import iterated, pendulum
from tests.mechanism.test_structures import scenery

CASES = {
    "six_bar_feeder": {"model": "mixed"},
    "slider_crank": {"model": "lubricated"},
    "four_bar": {"model": "dry", "friction": "stribeck"},
    "guide_slider": {},
}


@pytest.fixture
def later(tmp_path, monkeypatch):
    """Begins a later process: without structures, with the same store."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path))

    def begin():
        monkeypatch.setattr(building, "_structures", {})
        monkeypatch.setattr(structure, "_compiled", {})

    begin()
    return begin


@pytest.mark.parametrize("case", CASES)
def test_structures_are_those_traced(later, monkeypatch, case):
    """Layout, texts and digest; programs, which are traced where somebody reads them; no scene."""
    one = build(cl.load_case(case, **CASES[case])).structure
    later()
    monkeypatch.setattr(building, "_traced", None)
    two = build(cl.load_case(case, **CASES[case], speed=11.0)).structure
    for name in ("layout", "modes", "forced", "texts", "digest", "takes_moments", "alone"):
        assert getattr(one, name) == getattr(two, name)
    assert repr(two) == repr(one).replace(repr(one.programs), repr(two.programs)).replace(
        repr(one.derive), repr(two.derive)
    )
    assert scenery(two) == []
    monkeypatch.undo()
    assert {r: kernel_text(p, {}) for r, p in two.programs.items()} == {
        r: kernel_text(p, {}) for r, p in one.programs.items()
    }
    gc.collect()


def test_a_law_of_a_user_is_traced(later, tmp_path):
    """Nothing of it is in the store: its code may be another one in a later process."""
    build(pendulum(iterated(gain=0.8)))
    assert not list(tmp_path.glob("clearance_structure_*"))


def test_words_of_keys():
    """Equal values of different types have different words; unknown ones have none."""
    assert len({" ".join(kept.words((v,))) for v in (1, 1.0, True, "1", None, -0.0, 0.0)}) == 7
    with pytest.raises(kept.Unnamed, match="object"):
        list(kept.words((1, (object(),))))
