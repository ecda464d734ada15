"""Measured records beside a run: reading, the fitted shift, the error stated."""

from pathlib import Path

import numpy as np
import pytest
from clearance.postprocess.channels import at

import clearance as cl
from clearance.identify.measured import read


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Two turns of a four-bar with a film."""
    path = tmp_path_factory.mktemp("measured") / "run.h5"
    return cl.simulate(cl.load_case("four_bar"), turns=2, path=path, error=None)


def written(path, heading, *columns):
    """A CSV file of columns."""
    rows = [",".join(f"{v:.17g}" for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(["# bench", heading, *rows]) + "\n")
    return path


def test_a_record_over_time_is_found_where_it_was_taken(run, tmp_path):
    """Units are converted. The shift to 1e-9 s: the record is of the run's own interpolation."""
    time = np.sort(np.random.default_rng(2).uniform(0.0, 0.15, 400))
    values = at(run, "rocker.alpha", time + 0.1234567)
    path = written(
        tmp_path / "a.csv", "time [ms], rocker.alpha [1/s2], b [N]", 1e3 * time, values, time
    )
    with pytest.raises(ValueError, match="unknown unit '1/s2'"):
        read(path, "rocker.alpha")
    path = written(tmp_path / "a.csv", "time [ms], rocker.alpha, b [N]", 1e3 * time, values, time)
    with pytest.raises(ValueError, match="name one of its columns: rocker.alpha, b"):
        cl.compare(run, path)
    actual = cl.compare(run, path, column="rocker.alpha")
    assert actual.shift == pytest.approx(0.1234567, abs=1e-9)
    assert actual.share < 1e-7
    assert actual.correlation == pytest.approx(1.0, abs=1e-9)
    assert str(actual).startswith("rocker angular acceleration: rms error")


def test_a_channel_names_its_column(run, tmp_path, typed):
    """As in fits: CHANNEL=COLUMN, in Python and in both commands; the others stay as they are."""
    time = np.linspace(0.0, 0.1, 50)
    path = written(tmp_path / "c.csv", "t [s],a [rad/s],b [N]", time, time, time)
    compared = cl.compare(run, path, "rocker.omega=a")
    assert (compared.measured.column, compared.channel) == ("a", "rocker.omega")
    cl.simulate(cl.load_case("six_bar_feeder"), until=0.2, path=tmp_path / "r.h5").close()
    for command in ("view", "plot"):
        words = ("--channels", "rocker.omega=a", "--measured", path, "-o", tmp_path / "out.html")
        words = (*words[:-1], tmp_path / "out.png") if command == "plot" else words
        assert "wrote" in typed(command, tmp_path / "r.h5", *words).out


def test_noise_is_the_error(run, tmp_path):
    """Normal noise of size s: rms s within its scatter s / sqrt(2 n), four times; the range is
    larger by its tails.
    """
    time = np.linspace(0.0, 0.2, 2001)
    values = at(run, "joints/C/force", time + 0.05)
    size = 0.02 * np.ptp(values)
    noisy = values + np.random.default_rng(3).normal(0.0, size, time.size)
    path = written(tmp_path / "b.csv", "t [s],F [kN]", time, 1e-3 * noisy)
    actual = cl.compare(run, path, "joints/C/force")
    assert actual.rms == pytest.approx(size, rel=4.0 / np.sqrt(2.0 * time.size))
    assert actual.shift == pytest.approx(0.05, abs=1e-4)
    assert actual.share == pytest.approx(actual.rms / np.ptp(noisy), rel=1e-12)


def test_a_record_over_the_angle(run, tmp_path):
    """An angle counts from the start of the run; a shift may be given."""
    angle = np.arange(0.0, 300.0, 2.0)
    turns = angle / 360.0 + 0.6
    path = written(
        tmp_path / "c.csv", "angle [deg],x [mm]", angle, 1e3 * at(run, "rocker.x", turns * run.turn)
    )
    actual = cl.compare(run, path, "rocker.x")
    assert actual.shift == pytest.approx(0.6, abs=1e-7)
    assert actual.shift_text.endswith("deg")
    shifted = cl.compare(run, path, "rocker.x", shift="216 deg")
    assert shifted.rms < 1e-7 * np.ptp(shifted.computed)
    assert cl.compare(run, path, "rocker.x", shift=236.0).rms > 1e-3
    with pytest.raises(ValueError, match="shift must lie in 0 to 422 deg"):
        cl.compare(run, path, "rocker.x", shift=430.0)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("time [s],a [m/s2]\n0,1\n1,2\n", "at least 5 lines are needed, a header and rows; got 3"),
        (
            "x [mm],a [m/s2]\n0,1\n1,2\n2,3\n3,4\n",
            "time or angle, by its name or its unit; columns: x, a",
        ),
        ("time [s],a [m/s3]\n0,1\n1,2\n2,3\n3,4\n", "bad.csv:1: column 'a': unknown unit 'm/s3'"),
        ("time [s],a [m/s2]\n0,1\n1,x\n2,3\n3,4\n", "bad.csv:3: column a: 'x' is no finite number"),
        ("time [s],a [m/s2]\n0,1\n2,2\n1,3\n3,4\n", "bad.csv:4: time must grow"),
        ("time [s],a [m/s2]\n0,1\n1,nan\n2,3\n3,4\n", "bad.csv:3: column a: 'nan' is no finite"),
        ("t [s],a [N]\n0,1\n1,\n2,2\n3,3\n", "bad.csv:3: column a: '' is no finite number"),
        ("t [s],a [m]\n0,nan\n1,\n2,nan\n3,-\n", "column a has no number, such as 'nan'"),
        ("t [s],a [m]\n2,1\n2,5\n2,2\n2,1\n", "column t: 2 s in all rows; nothing measured?"),
        ("t [s],a [m]\n0,1,1,5\n0,2,1,5\n0,3,1,5\n0,4,1,5\n", "line 2: 4 cells under a header"),
        ("Pump 3\n0,1\n1,2\n2,3\n3,4\n", "no header: a line above the rows needs a name"),
        ("0,1\n1,2\n2,3\n3,4\n4,5\n", "no header: a line above the rows needs a name"),
        ("time [s],a [N]\n0,1\n.1,2\n.2,3\n.3,4\n", "column 'a' is in N, rocker position x in m"),
        ("time [s],a [mm]\n0,1\n1,2\n2,3\n3,4\n", "are more than the 0.4 s of the run"),
    ],
)
def test_what_is_no_record_is_refused(run, tmp_path, text, reason):
    """The message has the file and the reason."""
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"bad\.csv") as error:
        cl.compare(run, path, "rocker.x")
    assert reason in str(error.value)


def test_a_shift_of_another_unit_and_no_text(run, tmp_path):
    """The message names the shift and what the record runs along."""
    path = tmp_path / "d.csv"
    path.write_text("t [ms],x [mm]\n0,1\n1,2\n2,3\n3,4\n")
    with pytest.raises(ValueError, match=r"shift of .*d\.csv: '90deg' is in rad, expected s, for"):
        cl.compare(run, path, "rocker.x", shift="90deg")
    path.write_bytes(b"\x89HDF")
    with pytest.raises(ValueError, match=r"d\.csv is not a text file"):
        read(path)


@pytest.mark.parametrize("heading", ["T [degC]", "T (°C)", "T_degC"])
def test_temperatures_have_their_zero(tmp_path, heading):
    """Degrees Celsius come in K, to rounding."""
    celsius = np.random.default_rng(0).uniform(-20.0, 120.0, 9)
    path = written(tmp_path / "t.csv", f"t [s],{heading}", np.arange(9.0), celsius)
    assert read(path).units == "K"
    np.testing.assert_allclose(read(path).values, celsius + 273.15, rtol=1e-14)


def test_decimal_commas_and_semicolons(tmp_path):
    """As spreadsheets of half the world write them."""
    path = tmp_path / "d.csv"
    path.write_text("t [ms];a (m/s2)\n0,5;1,25\n1,5;2\n2,5;3\n3,5;4\n")
    record = read(path)
    assert record.x[0] == 5e-4
    assert record.values[0] == 1.25
    assert record.units == "m/s2"


@pytest.mark.parametrize(
    "text",
    [
        "Winkel [°];T [foo];a_x [m/s²];b\n" + "{};;{};ok\n" * 6,
        "phi,T,a_x,b\ndeg,foo,m/s^2,-\n" + "{},,{},ok\n" * 6,
        "\ufeffshaft_deg,T,a_x (m/s2),b\n" + "{},hot,{},1\n" * 6,
    ],
)
def test_columns_of_loggers(tmp_path, text):
    """An angle by its unit, which begins anew after a turn; units in a row of their own, with signs
    of powers; columns that nobody reads may have any unit and any text.
    """
    path = tmp_path / "d.csv"
    pairs = [(90 * k % 360, 0.5 * k) for k in range(6)]
    path.write_text(text.format(*(number for pair in pairs for number in pair)), encoding="utf-8")
    record = read(path, "a_x")
    assert (record.along, record.units) == ("angle", "m/s2")
    np.testing.assert_allclose(record.x, np.arange(6) / 4.0)
    np.testing.assert_allclose(record.values, 0.5 * np.arange(6))


def test_the_command(run, tmp_path, typed):
    """The picture, and the numbers in print and as JSON."""
    time = np.linspace(0.0, 0.1, 50)
    path = written(tmp_path / "e.csv", "time [s],v [m/s]", time, at(run, "rocker.vx", time + 0.25))
    plot = "plot", Path(run.path)
    record = "--measured", path, "--channels rocker.vx -o", tmp_path / "e.png"
    assert "rocker velocity x: rms error" in typed(*plot, *record).out
    printed = typed(*plot, *record, "--json").document
    assert printed["shift"] % run.turn == pytest.approx(0.05, abs=1e-7)
    assert printed["share"] < 1e-6
    assert (tmp_path / "e.png").stat().st_size > 10_000
    line = typed.line(*plot, "history", *record)
    assert "--measured does not belong to history" in line
    assert "needs a record" in typed.line(*plot, "measured")
    assert run.plot.measured(path, channels="rocker.vx").axes
