"""`clearance plot` and `clearance lyapunov`: every kind of picture, one clear line for wrong input,
JSON purity.
"""

import json
import shutil
import sys

import h5py
import numpy as np
import pytest
from clearance.postprocess import pictures

import clearance as cl
from clearance.laws.joint_friction import joint_coulomb
from tests.seeds import few_of
from tests.typed import python

RPM = np.pi / 30.0


def rubbing():
    """A driven arm on a pin that rubs."""
    pin = cl.Revolute(
        cl.ground,
        cl.Body("arm", 1.0, 0.01, com=(0.1, 0.0)),
        name="pin",
        pin_radius=0.01,
        friction=joint_coulomb(coefficient=0.1),
    )
    return cl.Scene(pin, cl.Drive(pin, speed=3.0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A dry and a lubricated run of two turns, one that stored little, two with joint friction and
    with a slide that has clearance, a grid and samples.
    """
    folder = tmp_path_factory.mktemp("plots")
    for model in ("dry", "lubricated"):
        scene = cl.load_case("slider_crank", model=model, speed=RPM * 1000.0, clearance=5e-4)
        cl.simulate(scene, turns=2.0, samples_per_turn=60, path=folder / f"{model}.h5")
    cl.inverse_dynamics(rubbing(), turns=1.0, path=folder / "rubbing.h5")

    cl.simulate(cl.load_case("guide_slider"), until=0.01, samples=101, path=folder / "guided.h5")
    scene = cl.load_case("slider_crank", model="dry")
    cl.simulate(
        scene, turns=1.0, samples_per_turn=20, path=folder / "little.h5", channels=["bodies/slider"]
    )
    options = {"turns": 2.0, "samples_per_turn": 40, "rtol": 1e-5, "workers": 1}
    points = cl.grid(speed=RPM * np.array([500.0, 1000.0, 1500.0]), clearance=[2e-4, 5e-4])
    cl.sweep("slider_crank", points, folder / "grid", fixed={"model": "dry"}, **options)
    shutil.copytree(folder / "grid", folder / "map")  # named like a kind of picture
    cl.sweep(
        "slider_crank",
        cl.sampled(5, speed=(50.0, 100.0)),
        folder / "samples",
        channels=[],
        **options,
    )
    return folder


def size(path) -> int:
    """Bytes of a picture that is one."""
    content = path.read_bytes()
    assert content.startswith((b"\x89PNG", b"GIF89a"))
    return len(content)


@pytest.mark.parametrize(
    "kind", sorted(set(pictures.OF_RUNS) - {"pressure", "measured", "tornado"})
)
@pytest.mark.parametrize("picture", few_of(["undrawn", "drawn"], 1))
def test_pictures_of_a_run(kind, picture, folder, tmp_path, typed, request):
    """Every kind of picture of one run, drawn and undrawn."""
    if picture == "undrawn":
        request.getfixturevalue("undrawn")
    shutil.copy(
        folder / {"friction": "rubbing.h5", "guide": "guided.h5"}.get(kind, "dry.h5"),
        tmp_path / "dry.h5",
    )
    more = ["--frames", 5] if kind == "animation" else []
    ended = typed("plot --json", tmp_path / "dry.h5", kind, *more)
    assert not ended.err
    document = ended.document
    path = tmp_path / f"dry_{kind}{'.gif' if kind == 'animation' else '.png'}"
    assert document == {"status": "complete", "picture": str(path)}
    assert size(path) > (8000 if picture == "drawn" else 0)


@pytest.mark.parametrize("kind", sorted(set(pictures.OF_SWEEPS) - {"scatter"}))
@pytest.mark.parametrize("picture", few_of(["undrawn", "drawn"], 1))
def test_pictures_of_a_sweep(kind, picture, folder, tmp_path, typed, request):
    """Every kind of picture of a sweep."""
    if picture == "undrawn":
        request.getfixturevalue("undrawn")
    more = ["--at", "clearance=0.5mm"] if kind == "bifurcation" else []
    text = typed("plot", folder / "grid", kind, *more, "-o", tmp_path / "p.png").out
    assert text == f"wrote {tmp_path / 'p.png'}\n"
    assert size(tmp_path / "p.png") > (15000 if picture == "drawn" else 0)


def test_what_is_drawn_without_a_kind(folder, typed):
    """Without a kind each file has its usual picture."""
    for name, picture in (
        ("grid", "grid/map.png"),
        ("samples", "samples/curves.png"),
        ("map", "map/map.png"),
        ("lubricated.h5", "lubricated_overview.png"),
    ):
        assert typed("plot --json", folder / name).document["picture"] == str(folder / picture)


@pytest.mark.slow
def test_a_sweep_that_draws_its_picture(tmp_path, typed):
    """A grid leads to its map, points along one line to curves."""
    words = "slider_crank -p model=dry -p speed=1000rpm:2000rpm:3 --samples-per-turn 20"
    words += " --channels none --workers 1 --plot"
    for more, picture in (("", "curves.png"), ("-p clearance=0.2mm,0.5mm", "map.png")):
        folder = tmp_path / picture.removesuffix(".png")
        text = typed("sweep", words, more, "-o", folder).out
        assert text.splitlines()[-1] == f"  picture      {folder / picture}"
        assert size(folder / picture) > 8000


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("history", "--channels slider.ax,*.force --along angle --last 1"),
        ("phase", "--channels slider.x,slider.vx,C.epsilon_x,C.epsilon_y --settle 0.5"),
        ("poincare", "--joint C --angle 90deg --settle 0"),
        ("spectrum", "--channels slider.ax --settle 1"),
    ],
)
def test_several_runs(kind, options, folder, tmp_path, typed):
    """Pictures of two runs name both."""
    inputs = folder / "dry.h5", folder / "lubricated.h5"
    assert not typed("plot", *inputs, kind, options, "-o", tmp_path / "p.svg").err
    assert {"dry", "lubricated"} <= set(
        (tmp_path / "p.svg").read_text().replace("<!--", "\n").split()
    )


def test_options_reach_the_picture(folder, tmp_path, typed, monkeypatch):
    """The command hands on the requested values in SI units."""
    from clearance.postprocess import animation, contacts, drawing, efforts, maps, plots

    seen = {}

    def catch(module, name):
        def drawn(*arguments, **options):
            seen[name] = options
            return arguments[1]

        monkeypatch.setattr(module, name, drawn)

    for module, name in (
        (animation, "animate"),
        (contacts, "contacts"),
        (drawing, "sketch"),
        (plots, "orbits"),
        (maps, "maps"),
        (maps, "curves"),
        (maps, "bifurcation_of"),
        (efforts, "friction"),
    ):
        catch(module, name)
    file, swept = folder / "dry.h5", folder / "grid"
    for command in (
        "animation --turns 0.5 --magnify 20",
        "contacts --joint C --settle 1",
        "sketch --turns 0.25",
        "orbit --joint 'B, C'",
        "friction --joint A",
    ):
        typed("plot", file, command, "-o", tmp_path / "p.gif")
    for command in (
        "map --metrics period,joint_*_force_max --x clearance --y speed --at speed=600rpm",
        "curves --x speed",
        "bifurcation --x speed --angle 180deg --settle 1 --channels slider.vx",
    ):
        typed("plot", swept, command, "-o", tmp_path / "p.png")
    # all samples of half a turn
    assert seen["animate"] == {"frames": 30, "turns": 0.5, "magnify": 20.0}
    assert seen["contacts"] == {"joints": ["C"], "settle": 1.0}
    assert seen["sketch"] == {"at": 0.25}
    assert seen["orbits"] == {"joints": ["B", "C"]}
    assert seen["friction"] == {"joints": ["A"]}
    at = seen["maps"].pop("at")
    assert at == {"speed": pytest.approx(600.0 * RPM)}
    assert seen["maps"] == {
        "metrics": ["period", "joint_*_force_max"],
        "x": "clearance",
        "y": "speed",
    }
    assert seen["curves"] == {"metrics": None, "x": "speed", "at": {}}
    assert seen["bifurcation_of"].pop("angle") == pytest.approx(np.pi)
    assert seen["bifurcation_of"] == {
        "parameter": "speed",
        "channels": ["slider.vx"],
        "at": {},
        "settle": 1.0,
    }


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("nosuch.h5", "no file or directory nosuch.h5"),
        (
            "dry.h5 portrait",
            "portrait is no kind of picture; those are life, animation, overview",
        ),
        ("dry.h5 map", "dry.h5 is a run file, of which there is no map; there is overview"),
        (
            "grid history",
            "grid is a sweep, of which there is no history; there is map, curves, bifurcation",
        ),
        (
            "grid map --settle 1",
            "--settle does not belong to map; it belongs to overview, phase",
        ),
        (
            "dry.h5 --x speed",
            "--x does not belong to overview; it belongs to map, curves, bifurcation",
        ),
        ("samples --y speed", "--y does not belong to curves; it belongs to map"),
        (
            "dry.h5 lubricated.h5",
            "several runs are for history, phase, poincare, spectrum, not for overview",
        ),
        (
            "grid dry.h5 history",
            "grid is a directory: a sweep or a life has a picture of its own",
        ),
        (
            "lubricated.h5 pressure",
            "lubricated.h5 has no pressure fields; run it with --pressure-fields N",
        ),
        ("grid --metrics wear", "no metric 'wear'"),
        ("grid --x colour", "'colour' is no parameter that varies"),
        ("grid --at speed", "--at speed: expected NAME=VALUE"),
        ("grid --at colour=red", "colour is not swept in grid; swept are speed, clearance"),
        ("grid --at speed=3mm", "--at speed: '3mm' is in m, expected rad/s"),
        ("samples map", "were drawn, not spread on a grid: ask for curves"),
        ("samples bifurcation", "keeps no run files"),
        ("dry.h5 phase --channels slider.x", "expected pairs X,Y"),
        ("dry.h5 history --channels slider.jerk", "no channel 'slider.jerk'"),
        (
            "dry.h5 history --along way",
            "along must be one of time, turns, angle; got 'way'",
        ),
        ("dry.h5 orbit --joint A", "no journal path of joint 'A' in dry.h5; of C"),
        ("dry.h5 friction", "dry.h5: this run has no joint friction"),
        ("little.h5 efforts", "little.h5: this run has stored no driving effort"),
        (
            "rubbing.h5 friction --joint door",
            "no friction of joint 'door' in rubbing.h5; of pin",
        ),
        (
            "dry.h5 efforts --joint C",
            "--joint does not belong to efforts; it belongs to",
        ),
        ("little.h5", "overview needs more channels than were stored"),
        ("little.h5 orbit", "has the eccentricity of no clearance joint"),
        ("dry.h5 -o p.txt", "its name must end in .png, .pdf, .svg"),
        ("dry.h5 animation -o p.png", "its name must end in .gif or .mp4"),
        ("dry.h5 animation --frames 1", "frames must be a whole number of at least 2"),
        ("dry.h5 sketch --angle 1mm", "'1mm' is in m, expected rad"),
        ("grid/sweep.h5", "is not a clearance result"),
    ],
)
def test_bad_input_is_one_clear_line(arguments, line, folder, typed, monkeypatch):
    """Wrong arguments: one line and status 2."""
    monkeypatch.chdir(folder)
    assert line in typed.line("plot", arguments)


def test_bad_input_is_a_document_where_one_is_asked_for(folder, typed):
    """With --json wrong input is a document."""
    text = typed("plot", folder / "dry.h5", "map --json", status=2).out
    assert json.loads(text)["status"] == "wrong input"


def test_a_run_of_one_sample(folder, tmp_path, typed):
    """One sample cannot be drawn, which is stated."""
    run_file = cl.simulate(
        cl.load_case("slider_crank", model="ideal"), turns=1e-3, samples_per_turn=10
    )
    short = run_file.save(tmp_path / "short.h5")
    with h5py.File(short, "a") as file:
        time = file["time"][:1]
        del file["time"]
        file["time"] = time
    err = typed.line("plot", short)
    assert "1 sample(s): there is nothing to draw" in err


def test_a_package_that_is_not_installed_is_one_line(folder, typed, monkeypatch):
    """Without a package the command ends in one line."""
    monkeypatch.setitem(sys.modules, "clearance.postprocess.plots", None)
    typed.line("plot", folder / "dry.h5")


def test_only_pictures_import_matplotlib():
    """Commands that draw nothing do not import matplotlib."""
    code = (
        "import sys, clearance.cli as cli; cli.main(['cases', '--json'])\n"
        "cli.main(['plot', 'nosuch.h5', '--json'])\n"
        "sys.exit('matplotlib' in sys.modules)"
    )
    python("-c", code)


# --- Lyapunov exponents
def test_lyapunov(tmp_path, typed):
    """A full film forgets its start within a turn: the exponent is far below zero."""
    words = (
        "lyapunov slider_crank -p model=lubricated -p film=pinkus_sternlicht --turns 4 --settle 1"
    )
    ended = typed(words, "--json -o", tmp_path / "out")
    assert not ended.err
    document = ended.document
    actual = document["slider_crank model=lubricated film=pinkus_sternlicht"]
    assert actual["verdict"] == "regular"
    assert actual["per_turn"] < -5.0
    assert (actual["turns"], actual["settle"]) == (4, 1)
    assert [p.rpartition("/")[2] for p in document["files"]] == [
        "lyapunov.h5",
        "lyapunov.png",
        "lyapunov.md",
    ]
    assert size(tmp_path / "out" / "lyapunov.png") > 10000
    assert (
        "| slider_crank model=lubricated film=pinkus_sternlicht |"
        in (tmp_path / "out" / "lyapunov.md").read_text()
    )
    assert "regular" in typed(words).out


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ("slider_crank --turns 2", "turns must be a whole number of at least 4, got 2"),
        ("slider_crank --turns many", "invalid int value: 'many'"),
        ("slider_crank -p model=ideal", "no degree of freedom"),
        ("double_pendulum", "no drive of constant speed"),
        ("double_pendulum --interval 1mm", "'1mm' is in m, expected s"),
        ("nosuch", "unknown case 'nosuch'"),
    ],
)
def test_bad_lyapunov(arguments, line, typed):
    """Wrong arguments of `lyapunov`: one line and status 2."""
    assert line in typed.line("lyapunov", arguments)


# --- from Python
def test_pictures_have_their_path_of_before():
    """It is a documented one."""
    from clearance.commands.plot import Pictures

    assert Pictures is pictures.Pictures


def test_pictures_of_a_result(folder, tmp_path):
    """A figure that notebooks show, or a file; the first argument is what the kind shows."""
    with cl.open_result(folder / "dry.h5") as run:
        figure = run.plot.orbit("C")
        assert figure._repr_png_().startswith(b"\x89PNG")
        assert "joint C" in figure.axes[0].get_title()
        (axes,) = run.plot.history("slider.ax", along="angle").axes
        assert axes.get_xlabel() == "crank angle [deg]"
        assert run.plot.phase(output=tmp_path / "p.png", settle=1.0) == tmp_path / "p.png"
        assert size(tmp_path / "p.png") > 8000
        assert len(run.plot().axes) == len(cl.plot(run, "overview").axes)
        assert {"orbit", "history", "animation"} <= set(dir(run.plot))
        assert "map" not in dir(run.plot)
        assert repr(run.plot).startswith(f"<pictures of {run!r}: ")


def test_pictures_of_a_result_without_a_file(tmp_path):
    """Efforts of a prescribed motion, which is stored in memory."""
    result = cl.inverse_dynamics(rubbing(), turns=1.0)

    assert len(result.plot.efforts().axes) > 1
    assert result.view(tmp_path / "arm.html").exists()


def test_pictures_of_an_open_sweep(folder):
    """`sweep.plot` draws the metrics that are named, else the usual ones."""
    sweep = cl.open_sweep(folder / "grid")
    figure = sweep.plot.map("drive_crank_torque_rms", x="clearance")
    assert figure.axes[0].get_xlabel() == "clearance [mm]"
    assert len(sweep.plot().axes) > len(figure.axes)  # the default metrics


@pytest.mark.parametrize(
    ("draw", "error", "message"),
    [
        (lambda run: run.plot.orbits(), AttributeError, "no picture 'orbits' .did you mean orbit"),
        (lambda run: run.plot.map(), AttributeError, "no picture 'map'"),
        (lambda run: run.plot.efforts("C"), TypeError, "efforts takes no argument but options"),
        (lambda run: run.plot.animation(), ValueError, "an animation needs a file"),
        (lambda run: run.plot.orbit("X"), ValueError, "X"),
        (lambda run: run.plot.orbit(metrics="a"), ValueError, "--metrics does not belong to orbit"),
    ],
)
def test_pictures_that_there_are_not(draw, error, message, folder):
    """A picture that a run cannot have is refused."""
    with cl.open_result(folder / "dry.h5") as run, pytest.raises(error, match=message):
        draw(run)


def test_a_run_as_a_dataset(folder):
    """By short names, with units and what they are; turns count with time at a constant speed."""
    with cl.open_result(folder / "dry.h5") as run:
        data = run.dataset
        np.testing.assert_array_equal(data["slider.ax"], run["slider"].ax)
        assert data["C.gap"].attrs["units"] == "m"
        assert "film thickness" in data["C.gap"].attrs["long_name"]
        assert {"energy.kinetic", "crank.torque", "B.force_x"} <= set(data)
        assert data["turns"][-1] == pytest.approx(2.0)
        nearest = np.abs(run.time - 0.03).argmin()
        assert data["slider.x"].sel(time=0.03, method="nearest") == run["slider"].x[nearest]
        assert data.attrs["status"] == "complete"


def test_names_that_two_parts_share_are_paths(monkeypatch, folder):
    """A body and a joint of one name are distinguished."""
    with cl.open_result(folder / "dry.h5") as run:
        names = {"bodies": ("J",), "joints": ("J",), "bodies/J": ("x",), "joints/J": ("x",)}
        monkeypatch.setattr(run, "names", lambda group: names.get(group, ()))
        monkeypatch.setattr(run, "values", lambda path: np.arange(3.0))
        monkeypatch.setattr(run, "_about", lambda path: {})
        monkeypatch.setattr(run, "turning", None)
        assert set(run.dataset) == {"bodies/J/x", "joints/J/x"}


@pytest.mark.usefixtures("undrawn")
def test_pages_of_a_result(folder, tmp_path):
    """A result writes its moving view and its report."""
    with cl.open_result(folder / "dry.h5") as run:
        assert run.view(tmp_path / "moving.html").stat().st_size > 50_000
        assert run.report(tmp_path / "report.html").stat().st_size > 10_000
