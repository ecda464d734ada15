"""The table of completeness: its commands exist, and README has what the generator prints."""

import shlex
from pathlib import Path

import pytest
from clearance.paper_figures import completeness, workshop

from clearance import cli
from clearance.commands.common import scene_of
from clearance.identify import models

ROOT = Path(__file__).parents[2]
COMMANDS = sorted(
    {c for items in completeness.rows().values() for row in items for c in row["commands"]}
)
SCENES = ("run", "explain", "inverse", "sweep", "lyapunov")


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_can_be_given(command):
    """Each command of the table passes its parser."""
    program, *words = shlex.split(command)
    if program == "python":
        assert (ROOT / words[0]).is_file()
        return
    assert program == "clearance"
    options = cli.parser().parse_args(words)
    if options.command == "figures":
        assert workshop.chosen(options.names, workshop.names())
    elif options.command in SCENES:
        scene_of(options)
    elif options.command == "identify":
        reference = models.model(options.model).options
        assert {p.partition("=")[0] for p in options.parameters} <= set(reference)


def test_the_four_sources_are_there():
    """The table has all four sources."""
    assert list(completeness.rows()) == ["feeder", "chains", "manipulator", "ball joint"]


def test_readme_has_the_tables_of_the_generator():
    """The page is as the generator writes it."""
    text = completeness.README.read_text(encoding="utf-8")
    assert completeness.updated(text) == text


def test_a_part_that_lacks_a_reason_is_refused(tmp_path, monkeypatch):
    """Incomplete rows are refused with what they lack."""
    row = '[[feeder]]\nitem = "a"\nkind = "model"\ncommands = []\nresult = "{}"\nnote = ""\n'
    monkeypatch.setattr(completeness, "DATA", tmp_path / "c.toml")
    for result, message in (
        ("not possible", "not possible because"),
        ("trend only", "a command"),
        ("done", "result is one of"),
    ):
        completeness.DATA.write_text(row.format(result))
        with pytest.raises(ValueError, match=message):
            completeness.rows()
