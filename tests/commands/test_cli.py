"""The command line: exit status, one clear line for wrong input, JSON purity, a mechanism of one's
own.
"""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance import cli
from clearance.commands import COMMANDS
from clearance.commands.common import folded
from clearance.results.tables import provenance
from tests.seeds import few_of
from tests.typed import python, words

OWN = Path(__file__).parents[1] / "own_mechanisms"


def test_run_json(tmp_path, typed):
    """The document of a run has status, numbers and units."""
    out = tmp_path / "run.h5"
    ended = typed("run six_bar_feeder -p model=lubricated -p joints=B --turns 1 --json -o", out)
    assert not ended.err
    document = ended.document
    assert document["status"] == "complete"
    assert document["file"] == str(out)
    assert document["steps"] > 10
    assert document["energy_residual"] < 1e-4 * document["energy_turned_over"]
    assert document["joints"]["B"]["smallest_gap"] > 0.0
    assert out.exists()


def test_units_and_readable_summary(tmp_path, typed):
    """Units are understood; the summary and the picture are there."""
    text = typed(
        "run slider_crank -p speed=3000rpm -p 'clearance=0.2 mm' --until 1ms -o",
        tmp_path / "r.h5",
        "--plot",
    ).out
    assert "contacts" in text
    assert "energy       residual" in text
    assert (tmp_path / "r.png").stat().st_size > 20000


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("-p clearance=-1mm", "clearance must be positive, got -0.001"),
        ("-p clearance=20mm", "clearance 0.02 m must be smaller than radius 0.01 m"),
        ("-p colour=red", "no parameter 'colour'; it has speed, joints"),
        ("-p speed=10furlong", "speed: unknown unit 'furlong'"),
        ("-p clearance=3micron", "unknown unit 'micron' in '3micron'; known: m, cm, mm, um"),
        ("-p speed=fast", "speed: 'fast' is not a number"),
        ("-p speed", "expected NAME=VALUE"),
        ("-p speed=1 -p speed=2", "-p speed=2: speed is given twice, 1 before"),
        ("-p joints=Z", "joints must be one of A, B, C, D, E, F; got 'Z'"),
        ("-p joints=", "joints: name at least one"),
        ("-p model=wet", "model must be one of ideal, dry, lubricated, mixed; got 'wet'"),
        ("-p viscosity=0", "viscosity must be positive, got 0.0"),
        ("-p model=dry -p restitution=2", r"restitution must lie in [0, 1], got 2.0"),
        ("-p speed=0 --turns 1", "turns needs a constant-speed rotating drive"),
        ("-p speed=300mm", "speed: '300mm' is in m, expected rad/s"),
        ("--until 1mm", "'1mm' is in m, expected s"),
        ("-p joints=BC", "joints must be one of A, B, C, D, E, F; got 'BC'"),
        ("--turns -1", "turns must be positive"),
        ("--turns many", "'many' is not a number"),
        ("--rtol 0", "rtol must be positive"),
        ("--rtol -1e-6", "rtol must be positive, got -1e-06"),
        ("--turns 0", "turns must be positive, got 0.0"),
        ("--until 0", "until must be positive, got 0.0"),
        ("--rtol 1", "rtol must lie in [1e-14, 0.1]"),
        (
            "--method euler",
            "method must be one of auto, radau, dop853, rodas5p, radau5, radau9; got 'euler'",
        ),
        ("--method radau -p model=ideal", "no degree of freedom"),
        ("--turns 1 --until 1s", "not allowed with"),
    ],
)
def test_bad_input_is_one_clear_line(arguments, line, tmp_path, typed):
    """Wrong arguments of a run: one line, status 2, no file."""
    assert line in typed.line("run six_bar_feeder", arguments, "-o", tmp_path / "r.h5")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("work-precision slider_crank --turns 0", "turns must be positive, got 0.0"),
        (
            "work-precision slider_crank --until -1e-3",
            "until must be positive, got -0.001",
        ),
        (
            "work-precision double_pendulum --turns 1",
            "turns needs a constant-speed rotating drive",
        ),
        (
            "work-precision slider_crank --turns 1 --until 1",
            "not allowed with argument",
        ),
        ("work-precision six_bar_feeder -p model=ideal", "no degree of freedom"),
        (
            "work-precision slider_crank --physics --turns 0",
            "turns must be positive, got 0.0",
        ),
        ("work-precision double_pendulum --physics", "has no parameter model"),
        ("stress nosuch", "the stress matrix has six_bar_feeder"),
        ("stress --workers -1", "--workers must be a whole number of at least 1, got -1"),
        ("explain four_bar -p speed=fast --cost", "'fast' is not a number"),
    ],
)
def test_bad_input_of_the_studies(arguments, line, tmp_path, typed, monkeypatch):
    """Wrong arguments of the studies: one line, status 2."""
    monkeypatch.chdir(tmp_path)
    assert line in typed.line(arguments)


def test_a_folder_that_cannot_be_made_is_known_before_the_work(tmp_path, typed):
    """A file where a folder should be is named before the study runs."""
    (tmp_path / "taken").write_text("")
    err = typed.line("work-precision slider_crank -o", tmp_path / "taken")
    assert "taken" in err


@pytest.mark.parametrize("case", ["nosuch", "no/such.py", "nosuch.py"])
def test_unknown_case(case, typed):
    """An unknown case is answered with those that there are."""
    err = typed.line("run", case)
    assert "known: double_pendulum, five_axis_chain, four_bar" in err or "no case file" in err


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("def scene(:", "SyntaxError"),
        ("x = 1", "must define a function scene"),
        ("def scene(*, speed): return 1", "parameter 'speed' of scene() needs a default value"),
        ("def scene(): return 1", "scene() must return a Scene, got int"),
        (
            "import clearance as cl\ndef scene():\n    return cl.Body('b', 1, 1)['zz']",
            "body b has no point 'zz'",
        ),
        (
            "def scene():\n    return 1 / 0",
            "case own: ZeroDivisionError: division by zero (own.py, line 2)",
        ),
        (
            "import clearance as cl\nb = cl.Body('b', -1.0, 1.0)",
            "body b: mass must be positive, got -1.0 (own.py, line 2)",
        ),
        (
            "import clearance as cl\n"
            "def scene(*, joints: str = 'B', o: cl.JointOptions = cl.JointOptions(joints='B',\n"
            "    model='dry')): pass",
            "its arguments 'joints' and 'o' both give the parameter 'joints'",
        ),
    ],
)
def test_bad_case_files(text, line, tmp_path, typed):
    """A case file that fails is named in one line."""
    path = tmp_path / "own.py"
    path.write_text(text)
    assert line in typed.line("run", path, "--until 1")


def overloaded(folder, film):
    """A case whose film is too thin for its journal, which falls to the wall."""
    path = folder / "overloaded.py"
    path.write_text(
        "import clearance as cl\n"
        "def scene(*, viscosity: float = 1e-12):\n"
        "    journal = cl.Body('journal', 50.0, 1e-2)\n"
        "    return cl.Scene(cl.ClearanceRevolute(cl.ground, journal, name='J', radius=0.01, "
        "clearance=1e-4,\n"
        f"        length=0.02, film=cl.{film}(), lubricant=cl.Lubricant(viscosity)))\n"
    )
    return path


def test_a_run_that_fails_half_way(tmp_path, typed):
    """Exit status 1, the reason, and a file that holds what was computed."""
    path = overloaded(tmp_path, "pinkus_sternlicht")
    out = tmp_path / "r.h5"
    ended = typed("run", path, "--until 1s --json -o", out, status=1)
    assert ended.document["status"] == "failed"
    assert "joint J" in ended.document["message"]
    assert "at t = " in ended.err
    assert out.exists()


def test_a_run_that_fails_has_the_warnings_of_its_scene(tmp_path, typed):
    """The slip of a unit, random viscosities below the usual: on the terminal, in the document and
    in Python's traceback.
    """
    path, rng = overloaded(tmp_path, "long_film"), np.random.default_rng(8)
    for viscosity in 10.0 ** rng.uniform(-14.0, -9.0, 3):
        warning = f"lubricant: viscosity is {viscosity:g} Pa s, usual is"
        line = ["run", path, f"-p viscosity={viscosity} --until 1s -o", tmp_path / "r.h5"]
        assert f"\n  warning      {warning}" in typed(*line, status=1).err
        document = typed(*line, "--json", status=1).document
        assert any(text.startswith(warning) for text in document["warnings"])
        with pytest.raises(cl.SimulationError) as failed:
            cl.simulate(cl.load_case(str(path), viscosity=viscosity), until=1.0)
        assert any(f"warning: {warning}" in note for note in failed.value.__notes__)


def test_a_solver_without_an_answer_has_the_warnings_too(tmp_path, monkeypatch, typed):
    """Those of the scene, where no run has any; wrong input has one line."""
    path = tmp_path / "heavy.toml"
    path.write_text(
        "[body]\ncrank = { mass = 1e9, inertia = 1.0 }\n[joint]\n"
        'A = { kind = "Revolute", a = "ground", b = "crank" }\n'
    )

    def failing(*_, **__):
        raise RuntimeError("no period")

    monkeypatch.setattr("clearance.motions.steady.steady", failing)
    line = typed("run", path, "--steady 1e-6 --period 1s -o", tmp_path / "r.h5", status=1).err
    assert line.startswith("clearance: no period\n  warning      body crank: mass is 1e+09 kg")
    assert "\n  warning    body crank: mass is 1e+09 kg" in typed("explain", path).out
    typed.line("run", path, "--until -1s -o", tmp_path / "r.h5")


def test_long_lines_are_folded_behind_commas():
    """At most 100 letters, nothing lost; a part of at most 60 letters stays in one piece."""
    rng = np.random.default_rng(2)
    for _ in range(50):
        parts = [
            " ".join("x" * n for n in rng.integers(1, 9, rng.integers(1, 8)))
            for _ in range(rng.integers(1, 30))
        ]
        text = "  joint B      " + ", ".join(parts)
        lines = list(folded([text, "short"]))
        assert lines.pop() == "short"
        assert max(map(len, lines)) <= 100
        assert " ".join(line.strip() for line in lines) == text.strip()
        assert all(line.startswith(" " * 15) for line in lines[1:])
        assert all(line.endswith(",") for line in lines[:-1])


@pytest.mark.parametrize("name", ["watt", "stephenson"])
def test_a_mechanism_of_ones_own(name, tmp_path, typed):
    """A Watt six-bar, and a Stephenson six-bar whose loop no dyads solve, through the same
    command.
    """
    out = tmp_path / "own.h5"
    case = OWN / f"{name}.py"
    ended = typed("run", case, "-p clearance=0.05mm --turns 1 --json -o", out)
    assert not ended.err
    assert ended.document["status"] == "complete"
    ways = [group["solved"] for group in typed("explain --json", case).document["plan"]]
    assert any("Newton" in w for w in ways) == (name == "stephenson")


def test_what_a_case_prints_stays_out_of_the_json(tmp_path, typed):
    """Output of a user's file does not break the document."""
    path = tmp_path / "talking.py"
    path.write_text(
        "import clearance as cl\nprint('loading')\n"
        "def scene(*, mass: float | None = None, teeth=3):\n"
        "    'A pendulum.'\n    print('building')\n"
        "    body = cl.Body('bob', mass or 1.0, 1e-2 * teeth, points={'top': (0, 0.2)})\n"
        "    return cl.Scene(cl.Revolute(cl.ground, body['top'], name='A'))\n"
    )
    out = tmp_path / "r.h5"
    document = typed("run", path, "-p mass=2kg -p teeth=3.5 -o", out, "--json").document
    assert document["simulated_s"] == 2.0
    assert document["parameters"] == {"mass": 2.0, "teeth": 3.5}
    assert json.loads(cl.open_result(out).attributes["parameters"]) == document["parameters"]


def test_outputs_that_cannot_be_written(tmp_path, typed):
    """Impossible output names are refused, and nothing is written."""
    for out, options, line in (
        (tmp_path, "", "is a directory"),
        (tmp_path / "r.png", "--plot", "would be overwritten by the picture"),
    ):
        assert line in typed.line("run four_bar -o", out, options)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("options", ["", "--checkpoint 60"])
def test_a_pipe_is_not_replaced(options, tmp_path, typed):
    """Nor is a device: a result file would take its name."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert f"{pipe} is a device, a pipe or a socket" in typed.line("run four_bar -o", pipe, options)
    assert pipe.is_fifo()
    assert [p.name for p in tmp_path.iterdir()] == ["pipe"]


def test_peaks_are_those_of_the_contacts(tmp_path, typed):
    """A contact is shorter than the sampling: the summary's peaks reach those of the events, to the
    1e-9 located.
    """
    out = tmp_path / "r.h5"
    joint = typed("run four_bar -p model=dry --json --settle 0 -o", out).document["joints"]["C"]
    events = cl.open_result(out).events
    assert joint["peak_force"] >= events["peak_force"].max() * (1.0 - 1e-9)
    assert joint["smallest_gap"] == pytest.approx(-events["peak_penetration"].max(), rel=1e-9)


def test_cases(typed):
    """All parameters of all cases have units and a text."""
    document = typed("cases --json").document
    assert {"six_bar_feeder", "slider_crank", "four_bar", "double_pendulum"} <= set(document)
    for case in document.values():
        for name, parameter in case["parameters"].items():
            assert parameter["units"] != "?", name
            assert parameter["text"], name
    assert typed("cases").out.count("m ") > 5


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_help_text(command, typed):
    """A per cent sign that is not doubled ends `--help` with a traceback. A parser of one command
    has the same options of it as that of all commands.
    """
    alone, all_of_them = (
        next(a for a in parser._actions if a.dest == "command").choices
        for parser in (cli.parser(command), cli.parser())
    )
    assert [*alone] == [*all_of_them] == [*COMMANDS]
    assert alone[command].format_help() == all_of_them[command].format_help()
    assert alone[command].format_help().startswith("usage:")
    assert COMMANDS[command] in " ".join(cli.parser("").format_help().split())


def test_explain(typed):
    """The document lists states, and what the scene does without."""
    document = typed("explain six_bar_feeder -p model=dry -p friction=none --json").document
    assert document["states"][:2] == ["joints/B/eccentricity_x", "joints/B/eccentricity_y"]
    assert {"film", "lubricant", "friction", "Newton loops"} <= set(document["left_out"])
    assert "jacobian" not in document["kernels"]
    assert not any("film" in c for k in document["kernels"].values() for c in k["calls"])
    ideal = typed("explain six_bar_feeder -p model=ideal --json").document
    assert ideal["states"] == ["energy input"]
    assert "clearance states" in ideal["left_out"]
    text = typed("explain six_bar_feeder").out
    assert "left out" in text
    assert text.count("clearance.") == 0  # no names of modules before the costs
    assert "  sweeps     points side by side, in lanes\n" in text
    assert (
        "points side by side"
        in typed("explain six_bar_feeder -p model=mixed -p transition=flores").out
    )
    words = "explain six_bar_feeder -p film=fem"
    text = typed(words).out
    reason = typed(words, "--json").document["not_in_lanes"]
    assert reason == "a film is solved as the run goes"
    assert f"  sweeps     each point by itself: {reason}\n" in text


def test_explain_lists_what_a_run_imports():
    """The modules of a dry run have its stepper."""
    line = "clearance.cli explain six_bar_feeder -p model=dry --json"
    modules = json.loads(python("-m", *words(line)).stdout)["modules"]

    assert "clearance.stepping.dop853" in modules
    assert not {"skfem", "matplotlib", "clearance.stepping.radau"} & set(modules)


def test_installed_entry_point():
    """The module run as a program prints the same line."""
    done = subprocess.run(
        [sys.executable, "-m", *words("clearance.cli run six_bar_feeder -p clearance=-1mm")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == "clearance: clearance must be positive, got -0.001\n"


@pytest.mark.parametrize("stored", ["bodies/slider/x", "joints/C/ecc*", "none"])
def test_a_run_that_keeps_little_is_summed_up_all_the_same(stored, tmp_path, typed):
    """The summary does not depend on the channels that are stored."""
    words = "run slider_crank -p model=dry --turns 6 --samples-per-turn 40 --json"
    entire = typed(words, "-o", tmp_path / "all.h5").document
    some = typed(words, "--channels", stored, "-o", tmp_path / "some.h5").document
    assert some["energy_residual"] == entire["energy_residual"] > 0.0
    assert some["contacts"] == entire["contacts"]
    assert entire["joints"]["C"].pop("mean_loss") > 0.0  # of a channel that is left out
    assert some["joints"]["C"] == entire["joints"]["C"]


@pytest.mark.parametrize("model", few_of(["mixed", "dry", "lubricated"], 2))
def test_users20_losses_and_powers_of_a_summary_balance(model, tmp_path, typed):
    """At a random point: what drives give is what joints lose and what the energy grows by.

    Between samples the rows are interpolated: 1e-3 of the loss. Sums over the samples of a drive's
    power miss impacts: they were off by a twentieth of it.
    """
    rng = np.random.default_rng(20)
    speed, gap = rng.uniform(15.0, 60.0), rng.uniform(0.05, 0.3)
    words = ["run", "six_bar_feeder", "-p", f"model={model}", "-p", "joints=B,E"]
    words += ["-p", f"speed={speed:.3f}", "-p", f"clearance={gap:.4f}mm", "--turns", "3"]
    path = tmp_path / "run.h5"
    summary = typed(*words, "--json -o", path).document
    begin, end = (summary["settled"][word] for word in ("begin_s", "end_s"))
    supplied = sum(drive["mean_power"] for drive in summary["drives"].values())
    lost = sum(joint.get("mean_loss", 0.0) for joint in summary["joints"].values())
    with cl.open_result(path) as result:
        energy = result.energy.kinetic + result.energy.potential
        grown = np.diff(np.interp([begin, end], result.time, energy))[0] / (end - begin)
    assert min(j["mean_loss"] for n, j in summary["joints"].items() if n in "BE") > 0.0
    assert supplied - lost == pytest.approx(grown, abs=1e-3 * lost)


SPRUNG = """
import clearance as cl

def scene(*, speed: float = 20.0, pull: float = 100.0, push: float = 0.0, model: str = "dry"):
    made = cl.load_case("six_bar_feeder", model=model, joints="B,E", speed=speed)
    slider = next(body for body in made.bodies if body.name == "slider")
    spring = cl.SpringDamper(cl.ground, slider.at(0, 0), stiffness=pull, damping=0.1 * pull / speed)
    loads = [*made.loads, spring] + [cl.Force(slider.at(0, 0), x=push)] * (push != 0.0)
    return cl.Scene(*made.joints, *loads, gravity=made.gravity)
"""


@pytest.mark.parametrize("seed", few_of(range(6), 1))
def test_users20_a_spring_puts_no_power_in(seed, tmp_path, typed):
    """Beside a spring with a damper, the mean power of a drive is that of the ledger too, with the
    impacts: 1e-9.
    """
    speed, pull = np.random.default_rng(seed).uniform([15.0, 10.0], [60.0, 1000.0])
    case, path = tmp_path / "sprung.py", tmp_path / "run.h5"
    case.write_text(SPRUNG)
    words = ["run", case, "-p", f"speed={speed}", "-p", f"pull={pull}", "--turns 3"]
    summary = typed(*words, "--json -o", path).document
    span = summary["settled"]["begin_s"], summary["settled"]["end_s"]
    with cl.open_result(path) as result:
        supplied = np.diff(np.interp(span, result.time, result.energy.input))[0]
    power = summary["drives"]["crank"]["mean_power"]
    assert power * (span[1] - span[0]) == pytest.approx(supplied, rel=1e-9)


@pytest.mark.parametrize(("model", "printed"), [("dry", False), ("lubricated", True)])
def test_users20_no_power_that_impacts_make_unknown(model, printed, tmp_path, typed):
    """The ledger has one sum for a drive and a force, and samples miss impacts: such a mean power
    had the wrong sign.
    """
    (case := tmp_path / "sprung.py").write_text(SPRUNG)
    words = ["run", case, "-p push=-46 -p", f"model={model}", "--turns 2"]
    summary = typed(*words, "--json -o", tmp_path / "run.h5").document
    assert ("mean_power" in summary["drives"]["crank"]) is printed
    assert bool(sum(summary["contacts"].values())) is not printed


IDEAL_RUN = ["run", "slider_crank", "-p", "model=ideal", "--turns", "1"]


def test_R10_a_replaced_result_is_told(tmp_path, monkeypatch, typed):
    """A second run states that it replaced the first one's file."""
    monkeypatch.chdir(tmp_path)
    assert typed(*IDEAL_RUN, "--json").document["replaced"] is False
    assert typed(*IDEAL_RUN, "--json").document["replaced"] is True
    assert "slider_crank.h5 (it replaced an earlier one)" in typed(*IDEAL_RUN).out


def test_R10_an_option_whose_value_is_two_dashes(capsys):
    """Two dashes are no value."""
    with pytest.raises(SystemExit, match="2"):
        cli.main([*IDEAL_RUN, "--rtol=--"])
    assert capsys.readouterr().err == "clearance: argument --rtol: expected a value, got '--'\n"


def test_R10_more_starts_than_can_end():
    """A count of starts beyond all time is refused."""
    from clearance.identify.fit import fit

    with pytest.raises(
        ValueError, match="starts must be a whole number from 1 to 10000, got 99999999999999999999"
    ):
        fit(None, "curve", starts=99999999999999999999)


@pytest.mark.parametrize("command", ["run", "sweep", "scatter", "wear", "identify", "figures"])
def test_a_slip_in_a_command_is_answered(command, capsys):
    """Two letters that change places, at each place of each command where they differ."""
    for i in range(len(command) - 1):
        slip = command[:i] + command[i + 1] + command[i] + command[i + 2 :]
        if slip != command:
            with pytest.raises(SystemExit):
                cli.main([slip])
            assert f"did you mean {command}?" in capsys.readouterr().err


def test_the_version_is_one(capsys):
    """Command line, package and result files state the version of pyproject.toml, which is that of
    the changelog.
    """
    root = Path(__file__).parents[2]
    with pytest.raises(SystemExit) as ended:
        cli.main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"clearance {cl.__version__}\n"
    changes = (root / "CHANGELOG.md").read_text()
    newest = re.search(r"^## (\S+) \((unreleased|\d{4}-\d\d-\d\d)\)$", changes, re.MULTILINE)
    assert re.sub(r"\.dev\d+$", "", cl.__version__) == newest[1]
    assert (newest[2] == "unreleased") == (".dev" in cl.__version__)
    document = tomllib.loads((root / "pyproject.toml").read_text())
    assert document["tool"]["setuptools"]["dynamic"]["version"] == {
        "attr": "clearance.version.VERSION"
    }
    assert provenance()["version_clearance"] == cl.__version__
