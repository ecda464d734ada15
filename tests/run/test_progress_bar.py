"""Bars of progress: in terminals and notebooks, once, and of the outermost study."""

import io
import sys
from types import SimpleNamespace

import pytest

import clearance as cl
from clearance.run import progress_bar

POINTS = cl.grid(speed=[20.0, 30.0])


class Terminal(io.StringIO):
    """Text that counts as a terminal."""

    def isatty(self) -> bool:
        """It is one."""
        return True


def stream(monkeypatch, text=Terminal, **state):
    """Text that a Python session writes to a new stream; bars stand from the start."""
    monkeypatch.setattr(progress_bar, "DELAY", 0.0)
    monkeypatch.setattr(progress_bar, "_state", {"command": False, "study": False} | state)
    monkeypatch.setattr(sys, "stderr", fresh := text())
    return fresh.getvalue


def ideal(**options):
    """An ideal slider-crank, one turn."""
    return cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1, **options)


def test_users15_a_terminal_shows_a_bar(monkeypatch):
    """A run and a sweep have a bar by their names, which is gone at the end."""
    shown = stream(monkeypatch)
    ideal()
    assert "simulate:" in shown()
    assert shown().endswith("\r")


def test_a_sweep_shows_its_points(monkeypatch, tmp_path):
    """A sweep has one bar, its runs have none; beside it stand the points."""
    shown = stream(monkeypatch)
    cl.sweep("slider_crank", POINTS, tmp_path / "swept", turns=1, workers=1)
    assert "sweep:" in shown()
    assert "simulate" not in shown()
    bar = progress_bar.ProgressBar("sweep")
    bar(SimpleNamespace(done=1, failed=1, total=4, running=2, rate=0.5))
    words = "1 of 4 done, 1 failed, 2 running, 0.5 runs/s"
    assert (bar.bar.postfix, bar.bar.n) == (words, 50.0)


def test_news_of_a_sweep_stand_beside_the_bar(monkeypatch):
    """Commands show them at once, above the bar; a silent one shows nothing."""
    shown, lines = stream(monkeypatch), []
    state = SimpleNamespace(
        done=1, failed=1, total=4, running=2, rate=0.5, before=3, news=("lost", "failed")
    )
    bar = progress_bar.ProgressBar("sweep", lines.append)
    bar(state)
    bar(state)
    assert lines == 2 * ["lost", "failed"]
    assert bar.before == 3
    assert bar.bar.n == 50.0
    assert shown().endswith("\r")  # the bar made room
    silent = progress_bar.ProgressBar("sweep", lines.append, silent=True)
    silent(state)
    assert len(lines) == 4
    assert silent.before == 3
    assert silent.bar is None


def test_a_study_without_a_share_shows_its_words(monkeypatch):
    """A sentence stands with the time alone, a later share has its bar."""
    shown = stream(monkeypatch)
    bar = progress_bar.ProgressBar("steady")
    bar("period 2")
    assert "steady: 00:00 passed, period 2" in shown()
    assert "%" not in shown()
    bar(0.25)
    bar.bar.refresh()
    assert "25%" in shown()


@pytest.mark.parametrize("kernel", [True, False])
def test_notebooks_have_bars_and_pipes_none(kernel, monkeypatch):
    """A kernel of notebooks shows a bar on a stream that is no terminal."""
    shown = stream(monkeypatch, io.StringIO)
    if kernel:
        monkeypatch.setitem(sys.modules, "ipykernel", sys)
    ideal()
    assert ("simulate:" in shown()) == kernel


@pytest.mark.parametrize("progress", [False, [].append])
def test_no_bar_where_none_is_wanted(progress, monkeypatch):
    """Neither for False nor beside a function of the user."""
    shown = stream(monkeypatch)
    ideal(progress=progress)
    assert shown() == ""


def test_commands_show_bars_where_they_are_requested(monkeypatch):
    """Inside a command a run has one where it is requested."""
    shown = stream(monkeypatch, command=True)
    ideal()
    assert shown() == ""
    ideal(progress=True)
    assert "simulate:" in shown()


def test_a_log_has_a_line_now_and_then(monkeypatch, caplog):
    """The logger has lines at the interval, if nobody sees a bar; with a long interval none."""
    shown = stream(monkeypatch, io.StringIO)
    caplog.set_level("INFO", "clearance")
    monkeypatch.setattr(progress_bar, "INTERVAL", 0.0)
    ideal()
    assert "simulate: 0 s, " in caplog.text
    assert "% done" in caplog.text
    monkeypatch.setattr(progress_bar, "INTERVAL", 1e9)
    caplog.clear()
    ideal()
    assert "simulate" not in caplog.text + shown()
