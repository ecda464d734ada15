"""The page on exports: its commands, its script and its C program run as printed."""

import shlex
import subprocess

import pytest

from clearance.cli import main
from clearance.exporting import unit
from tests.pages import blocks

PAGE = ("docs/export.md",)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder to work in, with the host's compiler."""
    monkeypatch.setattr(unit, "has_zig", lambda: False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_commands_and_program(folder, capsys):
    """The check is within what the page states; the program prints a force of this turn."""
    exports, compiling = blocks("sh", PAGE)
    for line in exports.strip().splitlines():
        if "--page" in line:  # test_live.py has it
            continue
        assert main(shlex.split(line, comments=True)[1:]) == 0
    lines = [x for x in capsys.readouterr().out.splitlines() if "within" in x]
    shares = [float(x.split("within ")[1].split()[0]) for x in lines]
    assert shares[0] < 1e-6
    assert shares[1] < 1e-8
    subprocess.run(["sh", "-e", "-c", compiling], check=True)
    assert len((folder / "feeder.csv").read_text().splitlines()) == 102
    (program,) = blocks("c", PAGE)
    (folder / "feeder_c/main.c").write_text(program)
    subprocess.run(compiling.splitlines()[0], shell=True, check=True)
    done = subprocess.run([folder / "feeder_c/main"], capture_output=True, text=True, check=True)
    assert 10.0 < float(done.stdout.split()[0]) < 1000.0


@pytest.mark.slow
def test_motor(folder, capsys):
    """The motor of the script: within 1e-3 of that in one scene, what the steps leave."""
    (script,) = blocks("python", PAGE)
    exec(script, {"__name__": "script"})
    for line in capsys.readouterr().out.splitlines():
        coupled, together = (float(word) for word in line.split() if word[-1].isdigit())
        assert coupled == pytest.approx(together, rel=1e-3)
