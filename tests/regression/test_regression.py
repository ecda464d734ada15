"""Complete runs with default settings against the references, see references.py.

What is allowed is a few times (mostly five) the deviation of the run when its reference was made:
the error of rtol = 1e-6, or of rounding where the motion is prescribed. A change beyond it is a
change of model or of accuracy.
"""

import numpy as np
import pytest

from clearance.scene.catalogue import case_names
from tests.regression import references
from tests.regression.references import (
    RUNS,
    Estimation,
    Statistics,
    described,
    deviations,
    read,
    result,
)
from tests.seeds import few_of

#: one run of each case and model; others belong to the slow ones
OTHERS = {
    "six_bar_feeder_lubricated_bce",
    "six_bar_feeder_fuzzy",
    "six_bar_feeder_dry",
    "slider_crank_impacts",
    "double_pendulum",
    "four_bar_ideal",
    "five_axis_chain",
    "three_loop_chain",
    "three_loop_chain_forward",
    "ball_joint_lugre1d",
}
FIRST = [n for n in RUNS if n not in OTHERS]
MOVABLE = [n for n, run in RUNS.items() if not isinstance(run, Statistics | Estimation)]


def worst(off: dict[str, float]) -> str:
    return ", ".join(f"{n}: {off[n]:.3g}" for n in sorted(off, key=off.get, reverse=True)[:5])


@pytest.mark.parametrize("name", few_of([*FIRST, *sorted(OTHERS)], len(FIRST)))
def test_run_is_as_its_reference(name):
    """No number is off by more than its tolerance."""
    reference, facts = read(name)
    assert facts["run"] == described(RUNS[name]), "the reference is of another run: make it again"
    off = deviations(RUNS[name], result(RUNS[name]), reference)
    assert all(value <= 1.0 for value in off.values()), worst(off)


@pytest.mark.slow
@pytest.mark.parametrize("name", MOVABLE)
def test_a_thousandth_is_noticed(name):
    """One parameter a thousandth larger: at least three times what is allowed, in some channel."""
    off = deviations(RUNS[name], result(RUNS[name], factor=1.001), read(name)[0])
    assert max(off.values()) > 3.0, worst(off)


def test_other_parameters_of_friction_are_noticed():
    """Each value a hundredth off is beyond what is allowed (five times: the fit itself stops within
    7e-4).
    """
    reference, _ = read("ball_joint_lugre1d")
    moved = {t: columns | {"value": 1.01 * columns["value"]} for t, columns in reference.items()}
    off = deviations(RUNS["ball_joint_lugre1d"], moved, reference)
    assert min(off.values()) > 3.0


@pytest.mark.parametrize("name", [n for n, run in RUNS.items() if isinstance(run, Statistics)])
def test_statistics_see_a_model(name):
    """Metrics at half their value, as by a lost factor of two: at least three of the six are beyond
    what is allowed.
    """
    reference, _ = read(name)
    moved = {"metrics": reference["metrics"] | {"value": 0.5 * reference["metrics"]["value"]}}
    off = np.array(list(deviations(RUNS[name], moved, reference).values()))
    assert (off > 1.0).sum() >= 3, off


def test_a_missing_channel_is_named():
    """A run with other channels than its reference is refused."""
    reference, _ = read("slider_crank_ideal")
    less = reference | {"channels": {c: v[1:] for c, v in reference["channels"].items()}}
    with pytest.raises(ValueError, match="channels: found"):
        deviations(RUNS["slider_crank_ideal"], less, reference)


def test_every_case_has_a_reference():
    """A case of the library without one fails here."""
    assert set(case_names()) == {
        run.case for run in RUNS.values() if not isinstance(run, Estimation)
    }


def test_files_are_small_and_no_others():
    """60 kB each: they live in the repository."""
    files = sorted(references.FOLDER.glob("*"))
    assert [f.stem for f in files] == sorted(RUNS)
    assert all(f.stat().st_size < 60e3 for f in files)


def test_nothing_is_overwritten_unasked(capsys):
    """References stay without the option."""
    before = references.path_of("four_bar_ideal").read_bytes()
    with pytest.raises(SystemExit):
        references.main(["four_bar_ideal"])
    assert "give --overwrite" in capsys.readouterr().err
    assert references.path_of("four_bar_ideal").read_bytes() == before
