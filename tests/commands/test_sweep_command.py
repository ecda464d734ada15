"""`clearance sweep` as a user types it: words, progress, exit status, JSON."""

import math
import re
from functools import partial

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.code import natural_width
from clearance.run import progress_bar
from clearance.sweeping.journal import Ways

QUICK = "--turns 1 --samples-per-turn 40 --rtol 1e-5 --workers 2"
FILM = "-p model=lubricated -p film=pinkus_sternlicht"


@pytest.fixture
def swept(typed, tmp_path):
    """A sweep of the slider-crank with words of one's own."""
    return partial(typed, "sweep slider_crank -o", tmp_path / "out", QUICK)


def test_a_grid_again_and_its_summary(tmp_path, swept):
    """The second call runs nothing and has the same summary."""
    words = f"{FILM} -p speed=20,30 -p clearance=0.1mm:0.3mm:3"
    text = swept(words).out
    assert "slider_crank: 6 of 6 points done, 0 failed" in text
    assert "joint_C_force_max" in text
    again = swept(words, "--json")
    assert (again.document["done"], again.document["done_before"]) == (6, 6)
    assert again.document["metrics"]["joint_C_force_max"]["units"] == "N"
    assert not again.err
    assert cl.open_sweep(tmp_path / "out").definition.fixed == {
        "model": "lubricated",
        "film": "pinkus_sternlicht",
    }
    log = (tmp_path / "out" / "sweep.log").read_text()
    assert "6 points, 6 to run" in log
    assert "finished: 6 done, 0 failed" in log


def test_the_summary_says_which_way_points_ran(tmp_path, swept):
    """Points in lanes and each by itself, with the reason, as in the log; none where none ran."""
    words = f"{FILM} -p speed=20:40:24 -p clearance=0mm,0.1mm --channels none"
    ways = swept(words, "--json", status=1).document["ways"]
    assert (ways["in_lanes"], ways["by_themselves"]) == (24, 24)
    assert ways["lanes"] == natural_width()
    assert list(ways["reasons"].values()) == [24]
    assert f"  {Ways(**ways)}\n" in (tmp_path / "out" / "sweep.log").read_text()
    assert "ways" not in swept(words, status=1).out
    (reason,) = ways["reasons"]
    again = f"  ways         no points in lanes; the ordinary way for 24: {reason}\n"
    assert again in swept(words, "--retry-failed", status=1).out


def test_lists_of_texts_and_of_numbers_that_go_together(tmp_path, typed):
    """Texts are separated by semicolons; --zip pairs numbers."""
    words = "-p 'joints=B;B,C' -p model=dry,ideal -p speed=20,30 -p clearance=0.1mm,0.2mm"
    words += " --zip speed,clearance --quiet -o"
    assert typed("sweep six_bar_feeder", QUICK, words, tmp_path / "out").out == ""
    points = cl.open_sweep(tmp_path / "out").definition.points
    assert points.axes == ((("joints",), 2), (("model",), 2), (("speed", "clearance"), 2))
    assert points[1] == {"joints": "B", "model": "dry", "speed": 30.0, "clearance": 2e-4}


def test_a_text_that_the_case_takes_whole_is_one_value(tmp_path, typed):
    """A list of joints is one value of its parameter."""
    words = "-p joints=B,C -p speed=20,30 -p film=pinkus_sternlicht --json -o"
    typed("sweep six_bar_feeder", QUICK, words, tmp_path / "out")
    assert cl.open_sweep(tmp_path / "out").definition.fixed["joints"] == "B,C"


def test_samples(tmp_path, swept):
    """Samples are those of the Python interface for the seed."""
    swept(FILM, "--sample 5 --seed 2 -p speed=20:30 -p clearance=50um:200um:log --channels none")
    expected = cl.sampled(5, seed=2, speed=(20.0, 30.0), clearance=(5e-5, 2e-4, "log"))
    points = cl.open_sweep(tmp_path / "out").definition.points
    assert points.columns["speed"] == expected.columns["speed"]
    assert points.columns["clearance"] == pytest.approx(expected.columns["clearance"], rel=1e-12)


def test_failed_points_give_status_1(swept):
    """Points that fail are counted, with their reasons."""
    message = swept(FILM, "-p speed=20,30 --max-steps 3 --channels none", status=1)
    assert "0 of 2 points done, 2 failed" in message.out
    assert "step limit" in message.out or "steps" in message.out
    assert "--retry-failed" in message.out
    assert "failed speed=20" in message.err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("-p spead=1,2", "no parameter 'spead' (did you mean speed?); it has speed"),
        ("-p speed=1:2:0", "is empty"),
        ("-p speed=1,2 -p speed=3", "given twice"),
        ("-p speed=20:30", "LO:HI:N"),
        ("-p speed=20,30 --zip speed,clearance", "no -p gives values of 'clearance'"),
        ("--sample 3 --zip speed,clearance", "--zip belongs to grids"),
        ("--sample 3 -p speed=20:30 --kind sobol", "latin, random"),
        ("-p speed=20,30 --workers 0", "workers"),
        ("-p speed=20,30 --metric none.py:f", "no file"),
        ("-p speed=20,30 --scheduler tcp://127.0.0.1:1", "not both"),
        ("-p model=soft,wet", "model must be one of"),
    ],
)
def test_wrong_input_is_one_line(words, reason, tmp_path, typed):
    """Wrong words of a sweep: one line and status 2."""
    out = tmp_path / "x"
    assert reason in typed.line("sweep slider_crank --turns 1 --workers 2", words, "-o", out)
    assert not out.exists()


def test_points_with_warnings(swept):
    """A loose film at high speed: its thin film warns, a stiff one does not."""
    words = f"{FILM} -p viscosity=0.01 -p speed=5000rpm -p clearance=0.03mm,0.2mm"
    swept(words)
    text = swept(words).out
    assert re.search(r"1 point has warnings: most, \d, at clearance=0.2 mm", text)


def test_channels_as_a_text(tmp_path):
    """A text for channels is refused with the list that is meant."""
    points = cl.grid(speed=[20.0])
    with pytest.raises(TypeError, match=r"channels: give a list .* got the text 'none'; \[\] "):
        cl.sweep("slider_crank", points, tmp_path / "out", channels="none")


def test_another_sweep_in_the_directory(swept):
    """A directory of another sweep is refused with the difference."""
    swept(FILM, "-p speed=20,30")
    message = swept(FILM, "-p speed=20,31", status=2)
    assert "holds another sweep: speed 20.0,30.0 instead of 20.0,31.0" in message.err


@pytest.mark.parametrize(("every", "shown"), [(math.inf, False), (0.0, True)])
def test_progress_on_a_pipe_is_lines(every, shown, monkeypatch, swept):
    """Failures are reported at once; a line of what is done comes after some time, here never or
    with each run.
    """
    monkeypatch.setattr(progress_bar, "INTERVAL", every)
    lines = swept(FILM, "-p speed=20,30 --max-steps 3", status=1).err.splitlines()
    failures = [line for line in lines if line.startswith("clearance: failed speed=")]
    progress = [
        line
        for line in lines
        if re.match(r"clearance: sweep: \d+ s, \d+% done \d of 2 done, ", line)
    ]
    assert len(failures) == 2
    assert bool(progress) is shown
    assert len(lines) == len(failures) + len(progress)


@pytest.mark.slow
def test_the_summary_has_the_units_of_the_user(tmp_path, typed):
    """Random units: extremes and their places as written on the command line; SI in JSON."""
    rng = np.random.default_rng(19)
    for i, unit in enumerate(("rpm", " rpm", "Hz", " Hz", "rad/s", "")):
        low, high = np.sort(rng.uniform(1.0, 5.0, 2)).round(2)
        text = f"speed={low}{unit},{high}{unit}"
        words = "-p model=ideal --channels none --workers 1 -o"
        sweep = partial(typed, f"sweep slider_crank -p '{text}'", QUICK, words, tmp_path / str(i))
        line = next(n for n in sweep().out.splitlines() if "acceleration_max" in n)
        assert line.endswith(f"largest at speed={high:g} {unit.strip()}".strip())
        at = sweep("--json").document["metrics"]["slider_acceleration_max"]["max_at"]
        assert at["speed"] == cl.units.quantity(f"{high}{unit}")
