"""`clearance film`: its commands, what they write, and the studies behind them."""

import math

import h5py
import numpy as np
import pytest
from clearance.paper_figures import film_ladder, films

import clearance as cl
from tests.film.states import bearing, moving


@pytest.fixture(scope="module")
def feeder(tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "run.h5"
    cl.simulate(cl.load_case("six_bar_feeder"), turns=1, path=path).close()
    return path


class TestPressure:
    def test_writes_all_it_says(self, tmp_path, typed):
        """Data, picture and text; fields have units and rising angles."""
        ended = typed("film pressure --eccentricity 0.7 --mesh 48x6 --json -o", tmp_path)
        document = ended.document
        assert ended.err == ""
        assert [p.rsplit(".")[-1] for p in document["files"]] == ["h5", "png", "md"]
        with h5py.File(document["files"][0]) as file:
            pressure, theta = file["film/pressure"][()], file["film/theta"][()]
            assert pressure.shape == (48, 7)
            assert pressure.max() == document["peak_pressure"]
            assert (np.diff(theta) > 0.0).all()
            assert all("units" in file[f"film/{n}"].attrs for n in file["film"])

    def test_is_the_solver(self, typed):
        """The defaults of the command are the feeder's joint at 300 rpm, and the drag that of its
        wet area.
        """
        document = typed("film pressure --eccentricity 0.6 --json").document
        wanted = cl.solve_film(bearing(), 0.6, 0.0, cl.rpm(300))
        assert document["load"] == pytest.approx(wanted.load, rel=1e-12)
        assert document["drag"] == pytest.approx(wanted.drag, rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("pressure --length -1mm", "length must be positive"),
        ("pressure --radius 0", "radius must be positive"),
        ("pressure --clearance 20mm", "must be smaller than radius"),
        ("pressure --mesh 4x2", "too coarse"),
        ("pressure --mesh 9000x9000", "at most 2048"),
        ("pressure --mesh 12", "is not a mesh such as 64x8"),
        ("pressure --eccentricity 1", "at or beyond contact"),
        ("pressure --groove 0,0,2", "outside the bearing"),
        ("pressure --groove left", "--groove left"),
        ("pressure --groove 1,2,3,4,5", "expected ANGLE"),
        ("pressure --cavitation boiling", "cavitation must be one of"),
        ("pressure --cavitation mass_conserving", "supply groove"),
        ("pressure --cavitation mass_conserving --solver fast", "the fast solver has"),
        ("pressure --solver slow", "solver must be one of"),
        ("pressure --solver fem --eccentricity 0.9995", "too coarse for eccentricity ratio"),
        ("pressure --roughness 80um", "flow factors need a clearance"),
        ("map --cavitation mass_conserving", "cavitation must be one of"),
        ("map --nodes 3", "from 5 to 257"),
        ("snapshots nowhere.h5", "nowhere.h5"),
    ],
)
def test_one_clear_line(arguments, message, typed):
    """Exit status 2, and the reason without a traceback."""
    assert message in typed.line(f"film {arguments}")


class TestMap:
    def test_holds_the_force(self, tmp_path, typed):
        """At the nodes of the picture: the solver's force within 1e-3 where the journal closes
        in.
        """
        typed("film map --json -o", tmp_path)
        film = bearing()
        actual, table = films.force_map(film)
        assert table.error_closing < 1e-3
        for i, j in ((20, 5), (60, 30), (100, 44)):
            eps, angle = -math.expm1(-actual["y"][i]), actual["angle"][j]
            wanted = cl.solve_film(film, *moving(eps, angle))
            assert actual["size"][i, j] == pytest.approx(wanted.load / film.force_scale, rel=1e-3)


class TestSnapshots:
    def test_are_the_run(self, feeder, tmp_path, typed):
        """The film solved anew from the file's motion has the force that the run had: 1e-3
        (5e-5).
        """
        chosen = "--joint B --count 4 --mesh 96x12 --json -o"
        shots = typed("film snapshots", feeder, chosen, tmp_path).document["snapshots"]
        assert len(shots) == 4
        for shot in shots:
            assert shot["load"] == pytest.approx(shot["recorded"], rel=1e-3)

    def test_warm_oil(self):
        """With a balance of heat the oil's viscosity of the moment counts."""
        from tests.film.test_heat import scene  # a journal in warming oil

        result = cl.simulate(scene(cl.HeatBalance(0.05, 0.1)), until=0.2, samples=21)
        shot = films.snapshots(result, count=1)[-1]
        assert result.joint("J").oil_temperature[-1] > 313.3
        assert shot.solution.load == pytest.approx(shot.recorded, rel=2e-3)

    def test_refusals(self, feeder, typed):
        """Joints without a film, and no snapshots."""
        for options, message in (("--joint A", "joints with one: B"), ("--count 0", "at least 1")):
            assert message in typed.line("film snapshots", feeder, options)

    @pytest.mark.slow
    def test_memory_is_not_in_a_file(self):
        """A film with memory cannot be solved anew from a file."""
        result = cl.simulate(cl.load_case("six_bar_feeder", film="conserving"), until=2e-4)
        with pytest.raises(ValueError, match="a film with a memory"):
            films.snapshots(result)


@pytest.mark.slow
class TestStudies:
    def test_convergence(self, tmp_path, typed):
        """One grid is of second order (1.5 to 2.5), extrapolation and finite elements gain: 4 times
        at like meshes.
        """
        meshes = typed("film convergence --json -o", tmp_path).document["meshes"]
        raw = [m for m in meshes if m["solver"] == "fast solver, one grid"]
        assert all(1.5 < m["order"] < 2.5 for m in raw[1:])
        by_name = {(m["solver"], m["mesh"]): m["error"] for m in meshes}
        assert (
            by_name["fast solver, extrapolated", "96x12"]
            < 0.25 * by_name["fast solver, one grid", "129x17"]
        )
        assert by_name["finite elements", "64x8"] < 0.25 * by_name["fast solver, one grid", "65x9"]

    def test_ladder(self, monkeypatch, tmp_path, typed):
        """Each rung is nearer than the one before, the table nearer than any formula. Costs are
        those of one call each, and not compared.
        """
        monkeypatch.setattr(film_ladder, "REPEATS", 1)
        document = typed("film ladder --quick --turns 0.02 --json -o", tmp_path).document
        rungs = {r["name"]: r for r in document["states"]}
        tables = [rungs[f"table {n}x{n}"]["error"] for n in (9, 17, 33)]
        assert tables == sorted(tables, reverse=True)
        assert tables[0] < rungs["harmonic"]["error"] < rungs["pinkus_sternlicht"]["error"]
        assert rungs["table 33x33"]["error_closing"] < 1e-3
        assert rungs["fast solver 48x6"]["error"] < rungs["fast solver 32x4"]["error"]
        assert rungs["FEM 32x4"]["error"] < rungs["FEM 16x2"]["error"]
        assert min(rung["seconds"] for rung in rungs.values()) > 0.0
        runs = {r["name"]: r["error"] for r in document["runs"]}
        assert runs["table 33x33"] < runs["harmonic"] < runs["pinkus_sternlicht"]
