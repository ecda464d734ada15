"""The benchmark set: this package within the errors, second codes, files of other codes."""

import importlib
import random
from pathlib import Path

import pytest
from clearance.paper_figures.peers import Problem

import clearance as cl
from clearance.film.conserving import MemoryFilm
from clearance.scene.catalogue import case_names, library
from clearance.studies.benchmark.foreign import foreign
from clearance.studies.benchmark.problems import PROBLEMS, benchmark, named
from clearance.studies.benchmark.rows import references, source
from tests.oracles.benchmark.__main__ import unit
from tests.oracles.benchmark.rotating_load import steady
from tests.oracles.exudyn import Exudyn

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs/benchmark"
#: problems that take some seconds, or make a table
SLOW = {"rotating_load", "engine_load", "periodic_orbit", "chaotic_statistics", "worn_bushing"}
#: whose second code takes some seconds
LONG = {"feeder", "rotating_load", "engine_load", "periodic_orbit", "chaotic_statistics"}
#: rounding of another processor, over the error of a row
SPREAD = 2.0
#: what films of tables, and wear that jumps, are off by, over the value: as their pages state
OFF = {
    "rotating_load": {"finite_": 1e-3, "elastic_": 1e-3},
    "engine_load": {"finite_": 1e-3, "elastic_": 1e-2},
    "worn_bushing": {"": 1e-3},
}


def marked(names):
    """All problems, some of them slow."""
    return [pytest.param(n, marks=[pytest.mark.slow] * (n in names)) for n in PROBLEMS]


@pytest.mark.parametrize("name", marked(SLOW))
def test_this_package_is_within_the_errors(name):
    """All rows of a problem, as the command computes them; statistics with their intervals."""
    answer = benchmark(name)
    for row in answer.rows:
        shares = (s for n, s in OFF.get(name, {}).items() if row.row.quantity.startswith(n))
        allowed = row.row.error + row.width + sum(shares) * abs(row.row.value)
        assert abs(row.off) <= SPREAD * allowed, row.row.quantity
    assert answer.work.seconds > 0.0


@pytest.mark.parametrize("name", marked(LONG))
def test_a_second_code_is_within_the_errors(name):
    """All rows of a problem by the code that was written from its page."""
    code = importlib.import_module(f"tests.oracles.benchmark.{name}")
    values = getattr(code, "quick", code.solve)()
    for row in references(name):
        allowed = row.error + getattr(code, "ALLOWED", {}).get(row.quantity, 0.0)
        assert abs(values[row.quantity] - row.value) <= SPREAD * allowed, row.quantity


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:SimulationSettings:DeprecationWarning")  # names of exudyn 1.9
def test_exudyn_is_near_the_lubricated_feeder():
    """A complete multibody code of second order, extrapolated from 4,000 and 16,000 steps a turn:
    the journal at 100 ms within 1e-6 of the clearance.
    """
    pytest.importorskip("exudyn")
    laws = {"friction": "none", "film_torques": False, "film": "pinkus_sternlicht"}
    case = cl.load_case("six_bar_feeder", joints="B", viscosity=0.05, roughness=0.0, **laws)
    problem = Problem(case, 0.1)
    solver, columns = Exudyn(problem), list(problem.compared)
    coarse, fine = (solver(problem, 1.0 / n).states[-1][columns] for n in (4000, 16_000))
    rows = {row.quantity: row.value for row in references("feeder")}
    wanted = [rows[f"lubricated_B_{axis}_100ms"] for axis in "xy"]
    assert fine + (fine - coarse) / 15.0 == pytest.approx(wanted, abs=1e-6 * 1e-4)


@pytest.mark.slow
def test_other_films_are_within_the_errors():
    """Finite and elastic bearing under a load that turns by two solvers of the package: within
    1e-4, since the edge of the film lies between their cells.
    """
    rows = {row.quantity: row for row in references("rotating_load")}
    bearing = cl.Bearing(0.025, 5e-5, 0.025, 0.02)

    def finite(eps):
        film = cl.solve_film(bearing, eps, 0.0, 200.0, mesh=(512, 64))
        return film.radial, film.tangential

    soft = MemoryFilm(bearing, (256, 24), 1e-12, conserving=False)
    films = {"finite": finite, "elastic": lambda e: soft.trial(e, 0, 0, 0, 200.0, 1e9)[:2, 0]}
    for name, film in films.items():
        for kind, value in zip(("ratio", "lead"), steady(film, 1000.0, 0.65, 0.72), strict=True):
            row = rows[f"{name}_{kind}"]
            assert abs(value - row.value) <= 1e-4


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_page_has_all_rows(name):
    """Each reference value is on the page, to the digits of its error; the page needs no code."""
    page = (PAGES / f"{name}.md").read_text()
    table = {
        cells[0].strip("`"): cells[1:]
        for line in page.splitlines()
        if line.startswith("| `") and len(cells := [c.strip() for c in line.split("|")[1:-1]]) == 4
    }
    rows = references(name)
    assert list(table) == [row.quantity for row in rows]
    for row in rows:
        unit, value, error = table[row.quantity]
        assert unit == row.unit
        assert "torque" not in row.quantity or unit == "N m"
        assert abs(float(value) - row.value) <= 0.1 * row.error
        assert float(error) == row.error
    assert "clearance.studies" not in page
    assert "cl." not in page


def test_the_list_has_a_page_for_each_problem():
    """The table of the guide and the contents have all problems, in the order of the command."""
    text = (ROOT / "docs/benchmark.md").read_text()
    contents = text.rpartition("<!-- contents: ")[2].split()
    assert [f"benchmark/{name}" for name in PROBLEMS] == contents[:-1]
    assert all(f"(benchmark/{name}.md)" in text for name in PROBLEMS)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_maker_has_the_units_and_words_of_the_files(name):
    """Its unit of each row, and the second code's sentence in the remark, are those of the file."""
    code = importlib.import_module(f"tests.oracles.benchmark.{name}")
    for row in references(name):
        assert unit(row.quantity, getattr(code, "UNITS", {})) == row.unit
    assert source(name).splitlines()[0].endswith(" ".join(code.__doc__.split()))


@pytest.mark.parametrize("name", [*PROBLEMS, "multibody", "yielding", "free_edges"])
def test_second_codes_share_nothing(name):
    """They import numpy, scipy, numba and each other."""
    text = (ROOT / f"tests/oracles/benchmark/{name}.py").read_text()
    assert "import clearance" not in text
    assert "from clearance" not in text


# --- files of other codes
FORMS = {
    "plain": "1,impact_1_time,s,0.00441\n2,impact_2_time,s,0.0101\n",
    "turned round": "# mine\nvalue;name\n1,01e-2;Impact 2 time\n4,41E-3;Impact-1-TIME\n",
    "units": "impact_1_time [s]\t4.41 ms\tfine\nimpact_2_time\t10.1\tms\n",
    "spaces": "impact_1_time 0.00441\nimpact_2_time 1.01d-2\n",
    "bars": "\ufeff| quantity | value | unit |\n|---|---|---|\n| impact_2_time | 10100 | us |\n"
    "| `impact_1_time` | .00441 | |\n",
    "units of names": "impact_1_time [ms],4.41\nimpact_2_time (us),10100\n",
    "columns": "quantity,error,reference,value [ms],note\nimpact_1_time,1,1,4.41,fine\n"
    "impact_2_time,1,1,10.1,good\n",
    "references beside": "# quantity;reference;mine\nimpact_1_time;1;4.41e-3\n"
    "impact_2_time;1;.0101\n",
    "signs": "impact_1_time: 4410 µs\nimpact_2_time = 10.1 [ms]\n# made on 12 May, in 3 s\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_files_are_read_in_many_forms(form, tmp_path):
    """Order, header, delimiter, decimal commas, capitals and units."""
    path = tmp_path / "mine.csv"
    path.write_text(FORMS[form])
    values, unknown = foreign(path, references("bouncing_journal"))
    assert not unknown
    assert values == pytest.approx({"impact_1_time": 0.00441, "impact_2_time": 0.0101}, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("impact_1_tme,0.1\n", "no line has a quantity .*did you mean impact_1_time"),
        ("impact_1_time,0.1\nimpact_1_time,0.2\n", "mine.csv:2: impact_1_time is there twice"),
        ("impact_1_time,0.1,mm\n", "mine.csv:1: impact_1_time: mm is no unit of it; s is"),
        ("impact_1_time,4.41,msec\n", "mine.csv:1: impact_1_time: 'msec' is no unit .*mean ms"),
        ("impact_1_time,4.41msec\n", "'msec' is no unit"),
        ("impact_1_time [msec],4.41\n", "'msec' is no unit"),
        ("impact_1_time,soon\n", "'soon' is no number"),
        ("quantity,value\nimpact_1_time,soon\n", "'soon' is no number"),
        ("impact_1_time,5.28 10^-6\n", "write 5.28e-6"),
        ("impact_1_time 5.28 x 10^-6\n", "write 5.28e-6"),
        ("impact_1_time;1.234,5\n", "'1.234,5' has a comma and a point"),
        ("torque_1,0.1\n", "no line has .*; a line has torque_1.*; the problem has impact_1_time,"),
    ],
)
def test_other_files_are_refused_in_words(text, message, tmp_path):
    """Name, line and reason."""
    path = tmp_path / "mine.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        foreign(path, references("bouncing_journal"))


@pytest.mark.parametrize("seed", range(40))
def test_files_of_spreadsheets_are_read(seed, tmp_path):
    """Random values in random order: encodings, units with micro signs, minus signs of type
    setters, decimal commas behind spaces, remarks behind a value.
    """
    rng = random.Random(seed)
    name = rng.choice(["bouncing_journal", "feeder", "guide", "friction_rig"])
    rows = rng.sample(references(name), 12)
    wanted = {r.quantity: rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-7, 3) for r in rows}
    parts, coding = rng.choice(";\t| "), rng.choice(["utf-8", "utf-8-sig", "utf-16", "cp1252"])
    units = {"m": ("µm", 1e6), "s": ("µs", 1e6), "m/s": ("mm/s", 1e3), "N m": ("N*mm", 1e3)}
    lines = []
    for row in rows:
        unit, factor = units.get(row.unit, ("", 1.0))
        number = f"{wanted[row.quantity] * factor:.13{rng.choice('efg')}}".replace(".", ",")
        if coding != "cp1252" and rng.random() < 0.5:
            number = number.replace("-", "\N{MINUS SIGN}")
        cells = [row.quantity, number] + [unit] * bool(unit)
        lines.append(parts.join(cells) + rng.choice(["", " # of run 2, fine"]))
    path = tmp_path / "mine.csv"
    path.write_text("\n".join(lines), encoding=coding)
    values, unknown = foreign(path, references(name))
    assert not unknown
    assert values == pytest.approx(wanted, rel=1e-11, abs=1e-12)  # of 13 digits or decimals


@pytest.mark.parametrize("seed", range(20))
def test_commas_that_part_a_number_are_refused(seed, tmp_path):
    """Decimal commas between commas, which were read as the digits before them, and thousands."""
    rng = random.Random(seed)
    value = rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-4, 3)
    unit = rng.choice(["", ",s", ",s,fine"])
    path = tmp_path / "mine.csv"
    path.write_text(f"impact_1_time,{value:.12{rng.choice('ef')}}".replace(".", ",") + unit)
    with pytest.raises(ValueError, match="mine.csv:1: impact_1_time: decimal commas need semicol"):
        foreign(path, references("guide"))
    path.write_text(f"impact_1_time;{rng.uniform(1e3, 1e7):,.6f}{unit.replace(',', ';')}")
    with pytest.raises(ValueError, match="has a comma and a point"):
        foreign(path, references("guide"))


def test_the_command_compares_a_file(typed, tmp_path):
    """The reference file is within its errors; a value that is off is outside, others missing."""
    path = tmp_path / "guide.csv"
    typed(f"benchmark guide -o {path}")
    again = cl.benchmark("guide", path)
    assert again.work is None
    assert all(c.inside and c.off == 0.0 for c in again.rows)
    path.write_text("impact_1_time,2.7,ms\n")
    document = typed(f"benchmark guide --against {path} --json", status=1).document["guide"]
    assert document["rows"][0]["value"] == pytest.approx(2.7e-3)
    assert document["rows"][1]["value"] is None
    printed = typed(f"benchmark guide --against {path}", status=1).out
    assert "outside" in printed.splitlines()[2]
    assert "missing" in printed.splitlines()[3]
    assert "0 of 36 within the errors of their references, 35 missing;" in printed
    before = path.read_text()
    typed(f"benchmark guide --against {path} -o {path}", status=2)
    typed(f"benchmark guide --against {path} --rtol 1e-9", status=2)
    printed = typed(f"benchmark guide -o {path}", status=2).err
    assert f"-o {path} is there already; give another name" in printed
    assert path.read_text() == before


def test_unknown_names_are_listed_and_missing_values_are_missing(typed, tmp_path):
    """A line with a number and a name that the problem lacks is listed; a dash is no value."""
    path = tmp_path / "mine.csv"
    path.write_text(
        "# mine, 3\ndepth_10,-\ndepth_10000,5e-6\ndepth_100,\nmade by hand\ndepth_1000,3.4e-5\n"
    )
    values, unknown = foreign(path, references("worn_bushing"))
    assert values == {"depth_1000": 3.4e-5}
    assert unknown == ["depth_10000 (did you mean depth_1000?)"]
    printed = typed(f"benchmark 11 --against {path}", status=1).out
    assert "unknown: depth_10000 (did" in printed
    assert printed.count("  missing") == 2


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_file_of_references_is_read_back(name, typed, tmp_path):
    """All values as they are: its header names the column, also of the unit 1."""
    path = tmp_path / "mine.csv"
    typed(f"benchmark {name} -o {path}")
    assert foreign(path, references(name)) == ({r.quantity: r.value for r in references(name)}, [])
    assert typed(f"benchmark {name} --against {path}", status=0)


def test_a_printed_table_is_read_back(tmp_path):
    """The answer of the command, in spaces: all values, and no line of it is a stranger."""
    path, answer = tmp_path / "mine.txt", benchmark("bouncing_journal")
    path.write_text(str(answer))
    again = benchmark(1, path)
    assert again.unknown == ()
    assert again.inside
    assert [c.value for c in again.rows] == pytest.approx([c.value for c in answer.rows], rel=1e-9)


def test_the_unit_one_is_no_value(tmp_path):
    """Without a header, too: a 1 between a name without unit and its value."""
    path = tmp_path / "mine.csv"
    path.write_text("ratio_1,1,0.9888,1e-9\nratio_3;0,9807\nshaft,ratio_10,0.9649\n")
    values, unknown = foreign(path, references("friction_rig"))
    assert values == {"ratio_1": 0.9888, "ratio_3": 0.9807, "ratio_10": 0.9649}
    assert unknown == []


def test_numbers_are_names(typed):
    """The number of a problem stands for its name, as the pages have it."""
    for number, name in enumerate(PROBLEMS, 1):
        assert named(number) == named(str(number)) == named(name) == name
        assert (PAGES / f"{name}.md").read_text().startswith(f"# {number} ")
    typed("benchmark 13", status=2)


def test_the_command_lists(typed):
    """A line for each problem; an unknown name has the close one."""
    assert [line.split()[1] for line in typed("benchmark").out.splitlines()] == list(PROBLEMS)
    assert list(typed("benchmark --list --json").document) == list(PROBLEMS)
    typed("benchmark feder", status=2)
    typed("benchmark --against mine.csv", status=2)


def test_the_set_is_no_case():
    """Its folder beside the cases is none of them, nor are its modules."""
    folder = library() / "benchmark"
    assert (folder / "mechanisms.py").exists()
    assert not {folder.name, *(p.stem for p in folder.iterdir())} & set(case_names())
    for name in ("benchmark", *(p.stem for p in folder.glob("*.py"))):
        with pytest.raises(ValueError, match="unknown case"):
            cl.load_case(name)


@pytest.mark.parametrize("name", PROBLEMS)
def test_references_have_eight_digits(name):
    """An error is below 5e-9 of its value, or the page states how many digits a row has."""
    worst = max(row.error / abs(row.value) for row in references(name))
    assert worst < 5e-9 or "digits" in (PAGES / f"{name}.md").read_text()
