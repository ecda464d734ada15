"""Results without a file: read as the file that they are saved in, which is made on demand only."""

import numpy as np
import pytest

import clearance as cl
from clearance.results import tables
from clearance.results.short_file import ShortFile

#: what the form of a file adds to the attributes of groups and columns
FORM = {"CLASS", "DIMENSION_LIST", "REFERENCE_LIST", "NAME", "_Netcdf4Dimid"}
FORM |= {"_Encoding", "coordinates"}
#: columns without values, which a file does not hold either
SCALES = ("events/event", "solver/step_number")
CASES = [
    ("six_bar_feeder", {"model": "mixed"}, {}),
    ("six_bar_feeder", {"model": "dry"}, {"channels": ["joints/B/*", "solver"]}),
    ("slider_crank", {"model": "lubricated"}, {"sensitivity": "clearance"}),
    ("slider_crank", {"model": "ideal"}, {"error": None}),
]


def same(one, other, path: str) -> None:
    """Equal values of equal kinds; texts may have more room in a file."""
    one, other = np.asarray(one), np.asarray(other)
    assert one.dtype == other.dtype or one.dtype.kind == other.dtype.kind == "U", path
    np.testing.assert_array_equal(one, other, path)


def compare(one, other, group: str = "") -> int:
    """Compare all below a group of two readers; the number of columns."""
    assert one.names(group) == other.names(group)
    _compare_attributes(one, other, group)
    count = 0
    for path in (f"{group}/{n}".lstrip("/") for n in one.names(group)):
        if path in one.columns() or path == "time":
            count += 1
            _compare_attributes(one, other, path)
            if path not in SCALES:
                same(one.column(path), other.column(path), path)
        else:
            count += compare(one, other, path)
    return count


def _compare_attributes(one, other, path: str) -> None:
    about, filed = dict(one.attributes(path)), dict(other.attributes(path))
    assert filed.keys() - FORM == about.keys(), path
    for name, value in about.items():
        assert isinstance(value, str) == isinstance(filed[name], str)
        same(value, filed[name], f"{path} {name}")


@pytest.mark.parametrize(("case", "values", "options"), CASES)
def test_reads_as_its_file(tmp_path, case, values, options):
    """Every name, attribute, kind and value; what is read is a copy."""
    result = cl.simulate(cl.load_case(case, **values), turns=1, **options)
    result.values(next(iter(result.reader.columns())))[:] = -1.0
    with cl.open_result(result.save(tmp_path / "run.h5")) as filed:
        assert compare(result.reader, filed.reader) > 20
        assert result.to_xarray().equals(filed.to_xarray())
        assert (result.errors.reason, dict(result.errors)) == (
            filed.errors.reason,
            dict(filed.errors),
        )
        assert [result.warnings, result.scene] == [filed.warnings, filed.scene]
    with pytest.raises(KeyError, match="no channel 'bodies/crank/nothing'"):
        result.values("bodies/crank/nothing")
    result.close()
    assert repr(result) == "<Result, closed>"
    with pytest.raises(ValueError, match="closed"):
        result.reader.column("time")


def test_no_file_is_made_unasked(monkeypatch):
    """Neither by a run in memory nor by looks at its numbers."""

    def refuse(*_):
        raise AssertionError("a file is made")

    monkeypatch.setattr(ShortFile, "_file", refuse)
    monkeypatch.setattr(tables, "in_memory", refuse)
    result = cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=1)
    assert result.errors
    assert result.solver["steps"] > 0
    assert result.joint("C").force.shape == (401, 2)
    assert not result.events["time"].size
    assert result.metrics()["joint_C_force_max"].value > 0.0
    with pytest.raises(AssertionError, match="a file is made"):
        _ = result.path
