"""Runs for other programs: CSV, MATLAB, LaTeX, BibTeX, and two runs side by side."""

import json
import re

import numpy as np
import pytest
from clearance.postprocess.citations import _fields
from clearance.postprocess.tables import _with_error, changed_facts, differences
from scipy.io import loadmat

import clearance as cl
from clearance.commands.diff import _pair, _short
from clearance.identify.measured import read

SLIDER = ["bodies/slider/*"]


@pytest.fixture(scope="module")
def runs():
    """Two lubricated runs that differ in their clearance."""
    wet = {"model": "lubricated", "film": "short"}
    return [
        cl.simulate(cl.load_case("slider_crank", clearance=c, **wet), turns=2) for c in (5e-5, 1e-4)
    ]


def test_users35_csv_is_read_by_what_compares(runs, tmp_path):
    """Columns have units, numbers all digits; a run beside its own table deviates by nothing."""
    every = runs[0].to_csv(tmp_path / "all.csv")
    assert read(every, "joints/C/gap").units == "m"
    path = runs[0].to_csv(tmp_path / "run.csv", SLIDER)
    heads = path.read_text().splitlines()[0].split(",")
    assert heads[0] == "time [s]"
    assert "bodies/slider/ax [m/s2]" in heads
    values = np.loadtxt(path, delimiter=",", skiprows=1)
    assert np.array_equal(values[:, heads.index("bodies/slider/ax [m/s2]")], runs[0]["slider"].ax)
    beside = cl.compare(runs[0], path, "slider.ax", column="bodies/slider/ax", shift=0.0)
    assert beside.share < 1e-12
    with pytest.raises(ValueError, match=r"no channel 'bodies/slyder/ax'.*did you mean"):
        runs[0].to_csv(tmp_path / "no.csv", ["bodies/slyder/ax"])


def test_users35_matlab_has_structures(runs, tmp_path):
    """Channels by their parts, units beside them, metrics."""
    runs[0].to_mat(tmp_path / "run.mat")
    data = loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert np.array_equal(data["joints"]["C"]["gap"], runs[0].joint("C").gap)
    assert data["units"]["joints"]["C"]["gap"] == "m"
    assert data["metrics"]["joint_C_force_max"] == runs[0].errors["joint_C_force_max"].value


def test_numbers_of_a_run_by_name(runs):
    """By column and by path, with their units; the start-up counts where nothing is left out."""
    numbers = runs[0].metrics()
    force = numbers["joints/C/force_max"]
    assert force == numbers["joint_C_force_max"]
    assert (force.value, force.units) == (runs[0].errors["joint_C_force_max"].value, "N")
    settled = runs[0].extreme("joints/C/force_max", runs[0].turn)  # the first turn is left out
    assert (force.value, force.time) == (settled.value, settled.time)
    entire = runs[0].metrics(settle=0)["joints/C/force_max"]
    largest = runs[0].extreme("joints/C/force_max")
    assert (entire.value, entire.time) == (largest.value, largest.time)
    with pytest.raises(ValueError, match="settle"):
        runs[0].metrics(settle=-1.0)


def test_users35_latex_has_errors(runs, tmp_path):
    """A row for each metric; numbers have their errors, signs of LaTeX are escaped."""
    text = runs[0].to_latex(tmp_path / "run.tex", ["joint_C_*"])
    assert (tmp_path / "run.tex").read_text() == text
    rows = [line for line in text.splitlines() if "&" in line][1:]
    force = next(row for row in rows if row.startswith("largest force in joint C"))
    assert re.search(r"\$[\d.]+ \\pm [\d.]+\$ & N", force)
    with pytest.raises(ValueError, match="no metric"):
        runs[0].to_latex(metrics=["joint_Q_*"])


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (128.14735, 0.00021, r"128.1473 \pm 0.0003"),
        (7.2948e-7, 3.3e-11, r"7.2948 \cdot 10^{-7} \pm 4 \cdot 10^{-11}"),
        (12345.0, 230.0, r"1.23 \cdot 10^{4} \pm 3 \cdot 10^{2}"),
        (0.5, 0.0, "0.5"),
        (float("inf"), 0.0, r"\infty"),
    ],
)
def test_numbers_with_errors(value, error, text):
    """As many digits as the error leaves, which is rounded up."""
    assert _with_error(value, error) == text


def test_users35_two_runs_side_by_side(runs, tmp_path, typed):
    """A run equals itself; another clearance changes forces by more than both errors."""
    assert not [d for d in differences(runs[0], runs[0]) if d.beyond]
    by_name = {d.name: d for d in differences(*runs)}
    force = by_name["joint_C_force_max"]
    assert force.beyond
    assert force.errors == pytest.approx(sum(r.errors[force.name].total for r in runs))
    paths = [run.save(tmp_path / f"{name}.h5") for name, run in zip("ab", runs, strict=True)]
    printed = typed("diff", *paths).out
    assert "joints/C/clearance: 5e-05 | 0.0001" in printed
    assert "joint_C_force_max" in printed
    assert "the runs share scene and options" in typed("diff", paths[0], paths[0]).out
    document = json.loads(typed("diff", *paths, "--json --metrics joint_C_force_max").out)
    assert document["metrics"][0]["change"] == force.change


@pytest.mark.parametrize("suffix", ["csv", "mat", "tex", "bib"])
def test_the_command_writes_each_kind(suffix, runs, tmp_path, typed):
    """By the suffix; another one is refused."""
    path = runs[0].save(tmp_path / "run.h5")
    typed("table", path, "-o", tmp_path / f"run.{suffix}")
    assert (tmp_path / f"run.{suffix}").stat().st_size > 100
    typed("table", path, "-o", tmp_path / "run.xls", status=2)


def test_users36_citations_of_what_a_run_used():
    """The code, the law of the contact and the stepper; keys differ, braces are closed."""
    scene = cl.load_case("slider_crank", model="dry", contact="lankarani_nikravesh")
    text = cl.simulate(scene, turns=0.1).citations()
    assert "@article{lankarani1990," in text
    assert "journal = {J. Mech. Design}" in text
    assert "author = {Lankarani and Nikravesh}" in text
    assert "hairer1993" in text
    keys = re.findall(r"^@\w+\{(\w+),$", text, re.MULTILINE)
    assert len(keys) == len({*keys}) >= 3
    assert text.count("{") == text.count("}")


def test_users36_every_law_has_a_source_that_can_be_cited():
    """Of the laws of contact, friction, film and asperities, which papers cite."""
    from clearance.postprocess.citations import _sources

    families = (cl.contact, cl.friction, cl.bristle, cl.asperity, cl.transition)
    named = {n: getattr(cl, n) for n in cl.laws.__all__}
    bare = [
        n
        for n, law in named.items()
        if isinstance(law, cl.Law)
        and law.family in families
        and not _sources(f"{law.__module__}:{n}")
    ]
    assert bare == ["impact", "superposed"]


def test_every_key_has_the_first_author():
    """Of all laws of the package: the first word of the source, none with the name of the law; a
    title is not an author.
    """
    from clearance.postprocess.citations import _key, _sources

    named = {n: law for n, law in vars(cl.laws).items() if isinstance(law, cl.Law)}
    named |= {n: getattr(cl, n) for n in cl.laws.__all__ if isinstance(getattr(cl, n), cl.Law)}
    sources = {t for n, law in named.items() for t in _sources(f"{law.__module__}:{n}")}
    assert len(sources) > 40
    for text in sources:
        fields = _fields(text)
        first = re.match(r"[A-Za-z]+", text)[0]
        assert _key(fields, ["law"]) == f"{first.lower()}{fields['year']}", text
        assert text.startswith(fields["author"])
        assert fields.get("title", "") not in ("Friction", "Wear")
    assert "author" not in _fields("ISO 21920-2 (2021)")


def test_articles_without_a_page_are_articles():
    """A journal and its volume make an article; books have a title."""
    fields = _fields("Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994)")
    assert (fields["journal"], fields["volume"], fields["year"]) == ("Automatica", "30", "1994")
    assert not {"title", "pages"} & fields.keys()
    assert _fields("Hunt and Crossley, J. Appl. Mech. 42 (1975) 440")["pages"] == "440"
    assert "journal" not in _fields("Hairer and Wanner, Solving Equations II (1996)")


def test_sources_of_laws_do_not_drown_differences():
    """`clearance diff` prints how long a text of several lines is, not the text."""
    assert _short("a = 1\nb = 2\n") == "text of 2 lines"
    assert _short(0.3) == "0.3"
    assert len(_short("x" * 500)) == 80


LAW = """import clearance as cl


@cl.signal
def pulse(time, size):
    \"\"\"A force [N].\"\"\"
    return size * time
"""
CASE = """import clearance as cl
from pulses import pulse


def scene(*, size: float = 1.0) -> cl.Scene:
    \"\"\"A block.\"\"\"
    block = cl.Body("block", mass=1.0, inertia=1.0)
    slide = cl.Prismatic(cl.ground, block, name="slide")
    return cl.Scene(slide, cl.Force(block, x=pulse(size=size), name="push"), name="block")
"""
FILE = """[parameters]
size = 1.0
[body]
block = { mass = 1.0, inertia = 1.0 }
[joint]
slide = { kind = "Prismatic", a = "ground", b = "block" }
[force]
push = { kind = "Force", point = "block", x = { law = "pulses.py:pulse", size = "$size" } }
"""


def test_a_law_of_a_file_is_one_law(tmp_path):
    """`clearance diff` of a case and a scene file with it: nothing but what changed."""
    for name, text in (("pulses.py", LAW), ("block.py", CASE), ("block.toml", FILE)):
        (tmp_path / name).write_text(text)

    def run(name, **values):
        return cl.simulate(cl.load_case(tmp_path / name, **values), until=1e-3, samples=2)

    first, second = run("block.py"), run("block.toml")
    assert list(changed_facts(first, second)) == []
    changed = {name for name, *_ in changed_facts(first, run("block.toml", size=2.0))}
    assert changed == {"parameter size", "loads/push/x/size"}
    (tmp_path / "pulses.py").write_text(LAW.replace("* time", "* time**2"))
    assert [name for name, *_ in changed_facts(first, run("block.toml"))] == [
        "sources/pulses.py/text"
    ]


@pytest.mark.parametrize("seed", range(20))
def test_the_first_line_that_differs_is_named(seed):
    rng = np.random.default_rng(seed)
    lines = [f"    x{i} = {rng.integers(99)}" for i in range(rng.integers(2, 40))]
    at = int(rng.integers(len(lines)))
    other = [*lines[:at], "    changed", *lines[at + 1 :]]
    expected = f"line {at + 1}: {lines[at].strip()} | changed"
    assert _pair("\n".join(lines), "\n".join(other)) == expected
    longer = _pair("\n".join(lines), "\n".join([*lines, "more"]))
    assert longer == f"line {len(lines) + 1}:  | more"
