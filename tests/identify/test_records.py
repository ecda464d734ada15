"""Measurements of joint friction: files, their layout and units, and everything that can be wrong
with them.
"""

import dataclasses
import math

import h5py
import numpy as np
import pytest

from clearance.identify import records
from clearance.identify.records import Measurement, Trial, read, write
from clearance.results.reading import NewerFormat

STEP = 1e-3


def trial(name="a", axis=2, samples=400, frequency=5.0, amplitude=0.1, **more):
    """Sinusoidal motion [rad, Hz] about one axis, with a torque that has its sign."""
    time = STEP * np.arange(samples)
    rate, torque = np.zeros((2, samples, 3))
    rate[:, axis] = 2.0 * np.pi * frequency * amplitude * np.sin(2.0 * np.pi * frequency * time)
    torque[:, axis] = 2.0 * np.tanh(10.0 * rate[:, axis]) + 0.01 * np.random.default_rng(1).normal(
        size=samples
    )
    labels = {"kind": "sine", "axis": "spin" if axis == 2 else "tilt", "role": "training"}
    return Trial(
        name,
        **labels | more,
        time=time,
        rate=rate,
        torque=torque,
        measured=tuple(np.arange(3) == axis),
    )


@pytest.fixture
def measurement():
    first = dataclasses.replace(
        trial("a"), facts={"preload": 5000.0, "amplitude": 0.1, "cycles": 2}
    )
    second = dataclasses.replace(trial("b", 0, role="test"), measured=(True, True, True))
    facts = {
        "bench": "rig 3",
        "sensor_torque_range": [-20.0, 20.0],
        "synthetic": False,
        "sampling_rate": 1000.0,
    }
    return Measurement((second, first), facts)


def same(one: Measurement, other: Measurement):
    """Bit for bit."""
    assert one.facts == other.facts
    assert [t.name for t in one.trials] == [t.name for t in other.trials]
    for a, b in zip(one.trials, other.trials, strict=True):
        assert (a.kind, a.axis, a.role, a.measured, a.facts) == (
            b.kind,
            b.axis,
            b.role,
            b.measured,
            b.facts,
        )
        for name in ("time", "rate", "torque"):
            np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


# --- round trips and layout
@pytest.mark.parametrize("suffix", ["h5", "csv", "CSV"])
def test_what_is_written_comes_back_bit_for_bit(measurement, tmp_path, suffix):
    """Numbers, labels and facts pass through HDF5 and CSV, and from one to the other."""
    path = write(tmp_path / f"m.{suffix}", measurement)
    same(read(path), measurement)
    same(read(write(tmp_path / "again.h5", read(path))), measurement)


def test_layout_for_plain_h5py(measurement, tmp_path):
    """h5py alone shows format, facts, labels and each measured column with its units."""
    with h5py.File(write(tmp_path / "m.h5", measurement)) as file:
        assert file.attrs["format"] == "clearance-measurement"
        assert file.attrs["format_version"] == 1
        assert file.attrs["bench"] == "rig 3"
        assert file.attrs["created"]
        assert set(file["trials"]) == {"a", "b"}
        a, b = file["trials/a"], file["trials/b"]
        assert {n: v for n, v in a.attrs.items() if not n.endswith("_crc32")} == {
            "kind": "sine",
            "axis": "spin",
            "role": "training",
            "order": 1,
            "preload": 5000.0,
            "amplitude": 0.1,
            "cycles": 2,
        }
        assert set(a) == {"time", "rate_x", "rate_y", "rate_z", "torque_z"}
        assert set(b) == set(a) | {"torque_x", "torque_y"}
        units = {"time": "s", "rate": "rad/s", "torque": "N m"}
        for group in (a, b):
            for name, data in group.items():
                assert data.attrs["units"] == units[name.partition("_")[0]]
                assert data.attrs["long_name"]


def hand_made(path, **columns):
    """A file as a user may write it: (units, values) by column, of one trial without attributes."""
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": "clearance-measurement", "format_version": 1})
        group = file.create_group("trials/run")
        for name, (units, values) in columns.items():
            group[name] = values
            group[name].attrs["units"] = units
    return path


TIME = STEP * np.arange(200)
RATE = 0.5 * np.sin(2.0 * np.pi * 5.0 * TIME)
TORQUE = 2.0 * np.tanh(10.0 * RATE)


def test_a_file_made_by_hand_with_other_units(tmp_path):
    """Columns in ms, deg/s and N mm come in SI to rounding, labels from the columns."""
    path = hand_made(
        tmp_path / "own.h5",
        time=("ms", 1e3 * TIME),
        rate_z=("deg/s", np.degrees(RATE)),
        torque_z=("N mm", 1e3 * TORQUE),
    )
    actual = read(path).named("run")
    assert (actual.kind, actual.axis, actual.role) == ("other", "spin", "training")
    assert actual.measured == (False, False, True)
    np.testing.assert_allclose(actual.time, TIME, rtol=0, atol=1e-15)
    np.testing.assert_allclose(actual.rate, np.outer(RATE, (0, 0, 1)), rtol=0, atol=1e-15)
    np.testing.assert_allclose(actual.torque, np.outer(TORQUE, (0, 0, 1)), rtol=0, atol=1e-15)


SAMPLES = list(zip(TIME, RATE, TORQUE, strict=True))


def lines(header="time,rate_z,torque_z", rows=SAMPLES, mark=","):
    return [header, *(mark.join(map(repr, map(float, row))) for row in rows)]


ROWS = lines()


def own_csv(folder, text):
    path = folder / "my run.v2.csv"
    path.write_text("\n".join(text) + "\n", encoding="utf-8-sig")
    return path


def test_the_smallest_csv(tmp_path):
    """Three columns are enough: the name comes from the file, the axis from the columns."""
    actual = read(own_csv(tmp_path, ROWS))
    only = actual.trials[0]
    assert (only.name, only.role, only.axis, only.measured) == (
        "my_run_v2",
        "training",
        "spin",
        (False, False, True),
    )
    np.testing.assert_array_equal(only.rate[:, 2], RATE)


def test_csv_in_other_units_and_with_other_marks(tmp_path):
    """Semicolons, units in headers and facts in comments are read; unused columns are listed."""
    rows = zip(1e3 * TIME, np.degrees(RATE), 1e3 * TORQUE, 20.0 + TIME, strict=True)
    text = lines("time_ms;rate_x_deg_s;torque_x_N_mm;temperature", rows, ";")
    actual = read(own_csv(tmp_path, ["# preload = 5000.0", "# operator = A. B.", *text]))
    assert actual.facts == {
        "preload": 5000.0,
        "operator": "A. B.",
        "columns_left_aside": ["temperature"],
    }
    assert actual.trials[0].axis == "tilt"
    np.testing.assert_allclose(actual.trials[0].rate[:, 0], RATE, rtol=0, atol=1e-15)
    np.testing.assert_allclose(actual.trials[0].torque[:, 0], TORQUE, rtol=0, atol=1e-15)


def test_csv_of_several_trials_whose_torques_are_not_the_same(tmp_path):
    """A torque without numbers in one trial is not measured there, while it is in another."""
    text = ["trial,role,time,rate_x,rate_z,torque_x,torque_z"]
    rows = np.stack([TIME, RATE, TORQUE], axis=1).tolist()
    text += [f"spin,training,{t!r},0.0,{w!r},,{m!r}" for t, w, m in rows]
    text += [f"tilt,test,{t!r},{w!r},0.0,{m!r}," for t, w, m in rows]
    actual = read(own_csv(tmp_path, text))
    assert [(t.name, t.role, t.measured) for t in actual.trials] == [
        ("spin", "training", (False, False, True)),
        ("tilt", "test", (True, False, False)),
    ]


# --- bad files
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: [], "at least 2 lines are needed, a header and rows; got 0"),
        (lambda r: ["# preload = 3"], "at least 2 lines are needed, a header and rows; got 0"),
        (lambda r: r[:1], "a header and rows; got 1"),
        (lambda r: r[:20], "trial 'my_run_v2' has 19 samples; at least 50"),
        (
            lambda r: [x.replace("time", "t") for x in r],
            "no column time; there are t, rate_z, torque_z",
        ),
        (lambda r: [x.replace("rate_z", "omega") for x in r], "no column rate_x, rate_y or rate_z"),
        (
            lambda r: [x.replace("torque_z", "moment") for x in r],
            "no column torque_x, torque_y or torque_z",
        ),
        (
            lambda r: [x.replace("torque_z", "torque_x") for x in r],
            "a column torque_x but no column rate_x",
        ),
        (
            lambda r: [x.replace("rate_z", "rate_z_deg") for x in r],
            "column 'rate_z_deg' must be in rad/s or deg/s",
        ),
        (
            lambda r: [x.replace("rate_z", "torque_z") for x in r],
            "columns: 'torque_z' stands there twice",
        ),
        (
            lambda r: ["time,rate_z,rate_z_deg_s,torque_z", *(x + ",1.0" for x in r[1:])],
            "columns in SI: 'rate_z' stands there twice",
        ),
        (
            lambda r: [*r[:10], "0.009,nan,1.0", *r[11:]],
            "'my_run_v2', line 11, column rate_z: nan is not a finite",
        ),
        (
            lambda r: [*r[:10], "0.009,0.1,inf", *r[11:]],
            "'my_run_v2', line 11, column torque_z: inf is not a finite",
        ),
        (lambda r: [*r[:10], "0.009,0.1,", *r[11:]], "line 11, column torque_z: is empty"),
        (
            lambda r: [*r[:10], "0.009,fast,1.0", *r[11:]],
            "line 11, column rate_z: 'fast' is not a number",
        ),
        (lambda r: [*r[:10], "0.009,0.1", *r[11:]], "line 11, column torque_z: is empty"),
        (
            lambda r: [*r[:10], "0.009,0.1,1.0,2.0", *r[11:]],
            "line 11: 4 cells under a header of 3; decimal commas need semicolons or tabs",
        ),
        (
            lambda r: [*r[:10], *r[11:]],
            "line 11, column time: 0.002 s after the row before, others 0.001 s",
        ),
        (lambda r: [*r, *r[1:]], "line 202, column time: 0 s does not come after 0.199 s"),
        (
            lambda r: [r[0], r[2], r[1], *r[3:]],
            "line 3, column time: 0 s does not come after 0.001 s",
        ),
        (lambda r: [r[0], r[1], *r[1:]], "line 3, column time: 0 s does not come after 0 s"),
    ],
)
def test_bad_csv(tmp_path, change, message):
    """Each mistake is refused with its file, and its trial, line and column where it has them."""
    path = own_csv(tmp_path, change(list(ROWS)))
    with pytest.raises(ValueError, match="v2.csv: ") as error:
        read(path)
    assert message in str(error.value)


def test_lines_are_those_of_the_file(tmp_path):
    """Comments and empty lines count in the line of a mistake."""
    text = ["# a = 1", "", ROWS[0], "# b = 2", *ROWS[1:10], "0.009,nan,1.0", *ROWS[11:]]
    with pytest.raises(ValueError, match="line 14, column rate_z"):
        read(own_csv(tmp_path, text))


def several(names, roles=("training",) * 9, kinds=("other",) * 9):
    """A CSV whose blocks of samples have these labels."""
    rows = [",".join(map(repr, map(float, row))) for row in zip(TIME, RATE, TORQUE, strict=True)]
    labels = zip(names, roles, kinds, strict=False)
    return [
        "trial,role,kind,time,rate_z,torque_z",
        *(",".join([*label, row]) for label in labels for row in rows),
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (several("aba"), "line 402: trial 'a' comes a second time"),
        (several("ab", ["training", "exam"]), "trial 'b': role must be one of training, test"),
        (several("ab", kinds=["other", "square"]), "trial 'b': kind must be one of triangle"),
        (
            several(["a", "b c"]),
            "trial name must be a non-empty name without '/', '.' or blanks, got 'b c'",
        ),
        (
            several("a", ["training"])[:-1] + several("a", ["test"])[-1:],
            "trial 'a' has several roles: test, training",
        ),
    ],
)
def test_bad_labels_in_csv(tmp_path, text, message):
    """Labels that are unknown, repeated, or change within a trial are refused."""
    with pytest.raises(ValueError, match="v2.csv: ") as error:
        read(own_csv(tmp_path, text))
    assert message in str(error.value)


def test_csv_that_is_no_text(tmp_path):
    """A CSV of bytes is refused as not a text file."""
    path = tmp_path / "x.csv"
    path.write_bytes(b"\xff\xfe\x00time")
    with pytest.raises(ValueError, match="not a text file"):
        read(path)


@pytest.mark.parametrize("name", ["none.h5", "none.csv"])
def test_no_file(tmp_path, name):
    """A missing file is refused by its name."""
    with pytest.raises(FileNotFoundError, match=f"no measurement file .*{name}"):
        read(tmp_path / name)


GOOD = {"time": ("s", TIME), "rate_z": ("rad/s", RATE), "torque_z": ("N m", TORQUE)}


def spoilt(column, row, value):
    values = GOOD[column][1].copy()
    values[row] = value
    return {column: (GOOD[column][0], values)}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": None}, "trial 'run' has no column 'time'; it has rate_z, torque_z"),
        ({"torque_z": None}, "no column torque_x, torque_y or torque_z"),
        ({"rate_z": None}, "a column torque_z but no column rate_z"),
        ({"rate_z": ("rpm", RATE)}, "column rate_z: its units must be rad/s or deg/s, got 'rpm'"),
        ({"time": ("", TIME)}, "column time: its units must be s or ms, got ''"),
        ({"rate_z": ("rad/s", RATE[:-1])}, "columns of different length"),
        ({"rate_z": ("rad/s", np.stack([RATE, RATE]))}, "column rate_z must be one row of numbers"),
        ({"rate_z": ("rad/s", ["a"] * 200)}, "column rate_z must be one row of numbers"),
        (
            spoilt("torque_z", 7, np.nan),
            "trial 'run', row 7, column torque_z: nan is not a finite number",
        ),
        (
            spoilt("time", 7, 0.0075),
            "trial 'run', row 7, column time: 0.0015 s after the row before",
        ),
        (
            spoilt("time", 7, 0.006),
            "trial 'run', row 7, column time: 0.006 s does not come after 0.006 s",
        ),
    ],
)
def test_bad_hdf5(tmp_path, change, message):
    """Columns that are missing, wrong or not finite are refused with file, trial and column."""
    path = hand_made(
        tmp_path / "own.h5", **{n: v for n, v in (GOOD | change).items() if v is not None}
    )
    with pytest.raises(ValueError, match="own.h5: ") as error:
        read(path)
    assert message in str(error.value)


def test_hdf5_files_of_other_kinds(tmp_path):
    """Text, a result, a newer version and no trials are refused, each with its reason."""
    (tmp_path / "text.h5").write_text("time,rate_z")
    with pytest.raises(ValueError, match="not a readable HDF5 file"):
        read(tmp_path / "text.h5")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file.attrs["format"] = "clearance-result"
    with pytest.raises(ValueError, match="not a clearance measurement"):
        read(tmp_path / "other.h5")
    with h5py.File(hand_made(tmp_path / "new.h5", **GOOD), "a") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(NewerFormat):
        read(tmp_path / "new.h5")
    with h5py.File(hand_made(tmp_path / "empty.h5"), "a") as file:
        del file["trials"]
    with pytest.raises(ValueError, match="has no trials"):
        read(tmp_path / "empty.h5")


# --- units
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"rate_z": ("rad/s", np.degrees(2.0 * RATE))},
            "'run', row 50, column rate_z: 57.2958 rad/s is more than 50",
        ),
        (
            {"rate_z": ("rad/s", np.full(TIME.size, 40.0) + RATE)},
            "in HDF5; if these are SI, --trust-units (trusted=True)",
        ),
        (
            {"rate_z": ("rad/s", np.full(200, 45.0))},
            "column rate_z: it turns through 8.955 rad, more than 6.283 rad",
        ),
        (
            {"torque_z": ("N m", 1e3 * TORQUE)},
            "column torque_z: no ball joint has a largest torque of 1999.82 N m",
        ),
        ({"torque_z": ("N m", 1e-4 * TORQUE)}, "is it in kN m? Then call it torque_z_kN_m"),
        (
            {"torque_z": ("N m", np.full(200, 0.3))},
            "column torque_z: 0.3 N m in all rows; nothing measured?",
        ),
        (
            {"time": ("s", 1e3 * TIME)},
            "column time: steps of 1 s; is it in ms? Then call it time_ms in CSV, or",
        ),
    ],
)
def test_units_that_cannot_be_right(tmp_path, change, message):
    """Numbers beyond any ball joint are refused with likely units, but read where trusted."""
    path = hand_made(tmp_path / "own.h5", **GOOD | change)
    with pytest.raises(ValueError, match="own.h5: trial 'run'") as error:
        read(path)
    assert message in str(error.value)
    assert read(path, trusted=True).samples == 200


def test_degrees_of_the_whole_programme_are_noticed(tmp_path):
    """Of tests from half a degree to ten, in degrees, the larger ones sweep more than a joint
    can.
    """
    trials = [
        trial(f"t{n}", 0, 2000, 1.0, math.degrees(math.radians(a)))
        for n, a in enumerate((0.5, 2.0, 10.0))
    ]
    path = write(tmp_path / "m.csv", Measurement(trials))
    with pytest.raises(
        ValueError, match=r"'t1', line \d+, column rate_x: it turns through 4 rad.*rate_x_deg_s"
    ):
        read(path)
    text = path.read_text().replace("rate_x,", "rate_x_deg_s,")
    path.write_text(text)
    # trapezoids
    assert read(path).named("t2").angle[:, 0].max() == pytest.approx(math.radians(20.0), rel=1e-4)


# --- what is made in memory
@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "a.b"}, "trial name must be"),
        ({"kind": "ramp"}, "trial 'a': kind must be one of"),
        ({"axis": "z"}, "trial 'a': axis must be one of"),
        ({"role": ""}, "trial 'a': role must be one of"),
        ({"rate": np.zeros((400, 2))}, r"rate has shape \(400, 2\), expected \(400, 3\)"),
        ({"time": np.zeros((400, 1))}, r"time has shape \(400, 1\), expected \(400,\)"),
        ({"measured": (False, False, False)}, "at least one"),
        ({"measured": (True, True)}, "three flags"),
        ({"time": TIME[::-1].repeat(2)}, "column time"),
    ],
)
def test_bad_trials(change, message):
    """Labels, shapes, times and flags that cannot be are refused by name."""
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(trial(), **change)


def test_trials_keep_their_own_numbers_and_drop_what_was_not_measured():
    """Later changes of the caller's array do not count; torque about other axes is zero."""
    torque = np.ones((400, 3))
    actual = dataclasses.replace(trial(), torque=torque, measured=(True, False, True))
    torque[:] = 5.0
    np.testing.assert_array_equal(actual.torque, np.outer(np.ones(400), (1, 0, 1)))
    assert actual.step == pytest.approx(STEP, rel=1e-12)
    assert actual.samples == 400


def test_angle_is_the_integral_of_the_rate():
    """Trapezoids of step h are off by at most A (w h)^2 / 6 = 1.6e-5 rad."""
    actual = trial(amplitude=0.1, frequency=5.0)
    exact = 0.1 * (1.0 - np.cos(2.0 * np.pi * 5.0 * actual.time))
    np.testing.assert_allclose(actual.angle[:, 2], exact, rtol=0, atol=2e-5)
    assert not actual.angle[:, :2].any()


def test_measurements(measurement):
    """Parts are taken by role and by name; missing and repeated names are refused."""
    assert measurement.samples == 800
    assert measurement.roles == ("training", "test")
    assert [t.name for t in measurement.of("test").trials] == ["b"]
    assert measurement.of("test", "training").samples == 800
    assert measurement.of("test").facts == measurement.facts
    assert measurement.named("a").axis == "spin"
    with pytest.raises(KeyError, match="no trial 'c'; there are b, a"):
        measurement.named("c")
    with pytest.raises(
        ValueError, match="no trial has a role of 'extrapolation'; there are test, training"
    ):
        measurement.of("extrapolation")
    with pytest.raises(ValueError, match="names of trials: 'a' stands there twice"):
        Measurement((trial(), trial()))
    with pytest.raises(ValueError, match="has no trials"):
        Measurement(())


def test_labels_and_units_are_documented():
    """The module states what a user may write."""
    for name in (*records.LABELS, "time_ms", "rate_z_deg_s", "torque_z_N_mm", "preload [N]"):
        assert name in records.__doc__
