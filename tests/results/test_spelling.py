"""One quantity in two spellings: paths and names of columns."""

import json

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.metrics.metrics import metrics
from clearance.values.spelling import as_column, as_path


@pytest.fixture(scope="module")
def run():
    """A lubricated slider-crank with stated errors."""
    return cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=2)


@pytest.mark.parametrize("end", ["force_max", "gap_min"])
def test_either_spelling_names_the_same_number(run, end):
    """Extremes, metrics and stated errors by path and by column."""
    path, column = f"joints/C/{end}", f"joint_C_{end}"
    assert run.extreme(path) == run.extreme(column)
    assert run.error(path) == run.error(column)
    table = metrics(run)
    assert path in table
    assert table[path] == table[column] == table.get(path)
    assert table.get("joints/C/none") is None
    assert run.errors["drives/crank/torque_rms"] == run.errors["drive_crank_torque_rms"]


def test_columns_and_paths():
    """There and back, for names with underscores; other names stay."""
    scene = {"joints": [{"name": "B"}, {"name": "B_2"}], "loads": [{"name": "crank"}]}
    for path in ("joints/B/force_max", "joints/B_2/gap_min", "drives/crank/torque_max"):
        assert as_path(as_column(path), scene) == path
    assert as_column("bodies/slider/acceleration_max") == "slider_acceleration_max"
    for name in ("dissipated_per_turn", "trajectory", "joints", "springs/a/force_max"):
        assert as_path(name, scene) == as_column(name) == name


def test_requests_sweeps_and_maps_take_paths(tmp_path, capsys):
    """A requested error, a sweep's metrics, a picture of them."""
    scene = cl.load_case("slider_crank", model="lubricated")
    run = cl.simulate(scene, turns=2, error={"joints/C/force_max": 1e-4})
    assert run.error("joints/C/force_max").relative <= 1e-4
    with pytest.raises(ValueError, match="joints/C/force_mex"):
        cl.simulate(scene, turns=2, error={"joints/C/force_mex": 1e-4})
    folder = tmp_path / "map"
    points = cl.grid(speed=[20.0, 30.0], clearance=[1e-4, 2e-4])
    swept = cl.sweep(
        "slider_crank", points, folder, fixed={"model": "lubricated"}, turns=2.0, channels=[]
    )
    np.testing.assert_array_equal(
        swept.metrics["joints/C/force_max"], swept.metrics["joint_C_force_max"]
    )
    command = [
        "plot",
        str(folder),
        "--metrics",
        "joints/C/force_max",
        "-o",
        str(tmp_path / "a.png"),
    ]
    assert main(command) == 0
    capsys.readouterr()
    words = [
        "run",
        "slider_crank",
        "-p",
        "model=lubricated",
        "--turns",
        "2",
        "--error",
        "joints/C/force_max=1e-3",
        "--json",
    ]
    assert main([*words, "-o", str(tmp_path / "run.h5")]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "complete"
