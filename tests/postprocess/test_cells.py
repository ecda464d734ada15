"""Cells of notebooks: what they show of scenes, runs and sweeps."""

import html
import re

import pytest

import clearance as cl

POINTS = cl.grid(speed=[20.0, 30.0], clearance=[2e-5, 4e-5])


def shown(thing) -> str:
    """The cell of a thing, as text."""
    return html.unescape(thing._repr_html_())


def ids(text: str) -> set[str]:
    """Ids of the elements of a cell."""
    return set(re.findall(r'\bid="(p\d[^"]*)"', text))


@pytest.mark.parametrize("case", ["slider_crank", "double_pendulum", "six_bar_feeder"])
def test_users14_a_scene_is_a_sketch_with_tables(case):
    """Its picture and the names of all parts, whether something turns or not."""
    scene = cl.load_case(case)
    text = shown(scene)
    assert "<svg" in text
    assert all(part.name in text for part in (*scene.bodies, *scene.joints))


def test_a_scene_that_does_not_close_says_so():
    """A loop that cannot be closed is a sentence in place of the sketch."""
    crank = cl.Body("crank", 1.0, 1e-3, points={"A": (0, 0), "B": (0.1, 0)})
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank["A"], name="A"),
        cl.Revolute(cl.ground.at(1.0, 0), crank["B"], name="B"),
    )
    text = shown(scene)
    assert "<svg" not in text
    assert "not shown, for" in text


def test_users14_a_run_has_its_numbers_errors_warnings_and_moving_page():
    """Metrics with stated errors; a warning of the run; the page in a frame that may run scripts,
    and nothing that is loaded.
    """
    run = cl.simulate(cl.load_case("slider_crank", model="ideal", speed=30.0), turns=2)
    text = shown(run)
    assert "drive_crank_torque_max" in re.sub("<wbr>", "", text)
    assert "stated error" in text
    errors = shown(run.errors)
    assert "drive_crank_torque_max" in errors
    assert "by the film table" in errors
    described = "<description of slider_crank: 3 bodies; A:Revolute, B:Revolute, C:Revolute"
    assert repr(run.scene).startswith(described)
    assert '<iframe srcdoc="<!doctype html>' in text.lower()
    assert 'sandbox="allow-scripts"' in text
    assert not re.search(r'(?:src|href)="https?:', text)
    contact = "kelvin_voigt(stiffness=1e6,damping=0)"
    scene = cl.load_case("slider_crank", model="dry", contact=contact)
    with pytest.warns(cl.RunWarning):
        doubtful = cl.simulate(scene, turns=1)
    assert "Warnings (" in shown(doubtful)


def test_a_large_moving_page_is_named(monkeypatch):
    """Instead of many megabytes stands the call that writes them."""
    monkeypatch.setattr("clearance.postprocess.cells.LARGEST", 1000)
    run = cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1)
    assert "run.view('run.html') writes it" in shown(run)


def test_users14_a_sweep_is_a_map(tmp_path):
    """Counts and a picture; the ids of two cells differ."""
    swept = cl.sweep("slider_crank", POINTS, tmp_path, turns=2, channels=(), workers=1)
    text, again = shown(swept), shown(swept)
    assert "4 points" in text
    assert "<svg" in text
    assert ids(text)
    assert ids(text).isdisjoint(ids(again))


def test_motions_are_tables_and_pictures(tmp_path):
    """A periodic motion has its multipliers and its run, a branch its picture and its bifurcations,
    statistics their lines.
    """
    scene = cl.load_case("slider_crank", model="lubricated")
    text = shown(cl.steady(scene, 1e-4))
    assert "periodic after 1 turn" in text
    assert "multiplier" in text
    assert "<iframe" in text
    fixed = {"model": "lubricated"}
    branch = cl.follow("slider_crank", "speed", 100.0, 110.0, fixed=fixed, tolerance=1e-4)
    assert "a periodic motion over speed" in shown(branch)
    assert "<svg" in shown(branch)
    dry = cl.load_case("slider_crank", model="dry", speed=cl.rpm(5000), clearance=1e-3)
    counted = cl.statistics(dry, {"joint_C_force_peak": 0.5}, starts=2, max_turns=400)
    assert counted.verdict in shown(counted)
    assert "joint_C_force_peak" in shown(counted)
