"""A reduced stress matrix, and that the matrix states what went wrong."""

import dataclasses
import json
import math
import os
from pathlib import Path

import h5py
import numpy as np
import pytest
from clearance.paper_figures import stress
from clearance.paper_figures.stress import Cell, judge, matrix
from clearance.postprocess import study_pictures

import clearance as cl
from clearance import cli
from clearance.commands import common
from tests import mechanisms as m

pytestmark = pytest.mark.slow

#: shorter than the command's, and without what needs minutes
REDUCED = [
    dataclasses.replace(c, turns=min(c.turns, 0.3))
    for c in matrix()
    if c.turns <= 2.0 and c.case in ("slider_crank", "six_bar_feeder")
]


@pytest.mark.parametrize("cell", REDUCED, ids=lambda c: f"{c.column}: {c.row}")
def test_extremes_end_well(cell):
    """Done with a ledger that closes to 1e-3 (at rtol 1e-6; the square root of looser tolerances)
    and joints closed to 1e-12 of the size, or stopped for one of two reasons the scene itself
    gives.
    """
    verdict = judge(cell)
    # a film cannot begin outside its bearing
    if (cell.model, cell.row) == ("lubricated", "start at 1.01 c"):
        assert "outside the clearance circle" in verdict.reason
        return
    thinnest = "viscosity 1e-4, 12000 rpm, c 1 mm"
    if (cell.column, cell.row) == ("six_bar_feeder lubricated", thinnest):  # below 1e-9 c
        assert "joint B: the journal reached the bearing wall" in verdict.reason
        return
    assert verdict.kind == "done", verdict.reason
    assert verdict.energy < max(1e-3, cell.rtol**0.5)
    assert verdict.closure < 1e-12


@pytest.mark.parametrize("seed", range(100, 106))
def test_random_scenes_end_well(seed):
    """Random scenes end with ledger and joints closed."""
    verdict = judge(Cell("random", "random", stress.MODELS[seed % 3], seed=seed, turns=0.3))
    assert verdict.kind == "done", verdict.reason
    assert verdict.energy < 1e-3
    assert verdict.closure < 1e-12


def test_the_matrix_holds_the_extremes():
    """Every extreme that is promised is there, for films and for dry contact where it applies."""
    rows = {(c.row, c.model) for c in matrix("six_bar_feeder")}
    both = [
        "c 1 um",
        "c 1 mm",
        "30 rpm",
        "12000 rpm",
        "all joints",
        "no gravity",
        "mass ratio 1e4",
        "1000 turns",
    ]
    both += ["rtol 1e-3", "rtol 1e-12", "start at 0.9999 c", "start at 1.01 c"]
    assert {(r, m) for r in both for m in ("lubricated", "dry")} <= rows
    assert {
        ("viscosity 1e-4", "lubricated"),
        ("viscosity 10", "lubricated"),
        ("stiffness 1e13", "dry"),
    } <= rows
    assert {("restitution 0", "dry"), ("restitution 1", "dry")} <= rows


def test_unknown_case():
    """An unknown case is answered with those that there are."""
    with pytest.raises(
        ValueError,
        match="the stress matrix has six_bar_feeder, slider_crank, four_bar, random; got 'nothing'",
    ):
        matrix("nothing")


def test_a_fault_is_called_one(monkeypatch):
    """An unexpected exception, and a run out of time, are distinguished from each other and from a
    good end.
    """
    cell = Cell("as it comes", "slider_crank", "dry", turns=0.1)
    assert judge(cell).kind == "done"

    def explodes(*arguments, **options):
        raise ZeroDivisionError("no")

    monkeypatch.setattr(stress, "simulate", explodes)
    assert judge(cell).kind == "fault"
    monkeypatch.undo()
    monkeypatch.setattr(stress, "TIME_BUDGET", -1.0)
    verdict = judge(cell)
    assert verdict.kind == "named"
    assert "out of time" in verdict.reason


def test_command(tmp_path, typed, monkeypatch):
    """The command writes table, file and picture."""
    monkeypatch.setattr(stress, "matrix", lambda case, quick: REDUCED[:2])
    printed = typed("stress -o", tmp_path, "--json --workers 1").document
    assert [c["kind"] for c in printed["cells"]] == ["done", "done"]
    with h5py.File(tmp_path / "stress.h5") as file:
        assert list(file["cells/kind"].asstr()) == ["done", "done"]
    assert (tmp_path / "stress.png").stat().st_size > 5000


def test_H3_json_is_strict(capsys, monkeypatch):
    """A cell without a result has no energy and no closure: null, which every parser reads; NaN is
    no JSON.
    """
    monkeypatch.setattr(stress, "TIME_BUDGET", 0)
    out_of_time = judge(Cell("as it comes", "slider_crank", "lubricated"))
    assert np.isnan(out_of_time.energy)
    monkeypatch.setattr(stress, "stress", lambda *options, **more: [out_of_time])
    cli.main(["stress", "--json"])
    printed = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert printed["cells"][0]["energy"] is None
    assert printed["cells"][0]["warnings"] == []


def test_H3_every_command_prints_by_the_one_writer():
    """No command writes JSON of its own, so that nothing but finite numbers and null goes out."""
    folder = Path(cli.__file__).parent / "commands"
    texts = {path.name: path.read_text() for path in folder.glob("*.py")}
    assert [name for name, text in texts.items() if "json.dumps" in text] == ["common.py"]
    odd = {
        "a": (math.nan, 1.5),
        "b": [np.float64(-math.inf)],
        "c": {"d": math.inf},
        "e": "NaN",
        "f": None,
        "g": 3,
    }
    plain = {"a": [None, 1.5], "b": [None], "c": {"d": None}, "e": "NaN", "f": None, "g": 3}
    assert json.loads(common.json_text(odd), parse_constant=pytest.fail) == plain


def killed(cell):
    """A judge whose process dies on one cell."""
    if cell.row == "dies":
        os._exit(1)
    return stress.Verdict(cell.row, cell.column, "done")


def test_a_process_that_dies_takes_no_other_cell_with_it(monkeypatch):
    """A dead process is a fault of its cell alone."""
    monkeypatch.setattr(stress, "judge", killed)
    cells = [Cell(r, "slider_crank", "dry") for r in ("a", "dies", "b", "c", "d")]
    monkeypatch.setattr(stress, "matrix", lambda case, quick: cells)
    verdicts = stress.stress(workers=2)
    assert [(v.row, v.kind) for v in verdicts] == [
        (c.row, "fault" if c.row == "dies" else "done") for c in cells
    ]


def test_bad_workers(typed):
    """No workers are refused."""
    assert "--workers must be a whole number of at least 1, got 0" in typed.line(
        "stress --workers 0"
    )


def test_picture_and_table_of_named_stops(tmp_path):
    """Stops and faults are numbered in table and picture."""
    verdicts = [
        stress.Verdict("a", "x", "done", energy=1e-6, closure=1e-15),
        stress.Verdict("a", "y", "named", "at t = 1 s: why"),
        stress.Verdict("b", "x", "fault", "its process died"),
    ]
    lines = stress.table(verdicts)
    assert "| a | 1e-06 | stops [1] |" in lines
    assert "| b | FAULT [2] |  |" in lines
    assert "1 of 3 done, 1 with a named reason, 1 faults" in "\n".join(lines)
    assert study_pictures.stress(verdicts, tmp_path / "s.png").exists()


def test_films_are_never_left_by_a_trial_step():
    """At a tolerance wider than the film is thin the journal stays inside: steps out of the film
    are refused.
    """
    scene = cl.load_case("slider_crank", model="lubricated", viscosity=1e-4)
    result = cl.simulate(scene, turns=1, rtol=1e-2)
    assert result.complete
    assert result.joint("C").gap.min() > 0.0


@pytest.mark.parametrize("rtol", [1e-3, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("viscosity", [1e-4, 1e-2, 0.1])
def test_a_sinking_journal_sinks(viscosity, rtol):
    """Gravity squeezes a journal towards the wall, ever slower: the gap never grows (but by 5 % of
    itself, the error a thin film is allowed), although it gets a million times thinner than the
    tolerance; and the ledger closes.
    """
    body = cl.Body("journal", 0.5, 1e-4)
    scene = cl.Scene(m.film(cl.ground, body.at(0, 0), "J", clearance=1e-4, viscosity=viscosity))
    result = cl.simulate(scene, until=20.0, rtol=rtol, samples=2001)
    gap = result.joint("J").gap
    assert result.complete
    assert (gap[1:] / np.minimum.accumulate(gap)[:-1]).max() < 1.05
    assert gap[-1] < 1e-2 * 1e-4
    assert result.solver["energy_residual_share"] < max(1e-3, 300 * rtol)
