"""The examples of README and guide run as printed; their links and pictures exist."""

import itertools
import re
import shlex

import numpy as np
import pytest

import clearance as cl
from clearance import cli
from clearance.commands.common import scene_of
from clearance.laws.law import Law
from tests.pages import PAGES, ROOT, TEXT, anchors, block, blocks, prose

README, GUIDE = blocks(pages=("README.md",)), blocks()


@pytest.fixture
def example(tmp_path, monkeypatch, capsys):
    """Runs the first block that has a mark, in a folder of its own; returns what it prints."""

    def run(blocks, mark):
        monkeypatch.chdir(tmp_path)
        exec(compile(next(b for b in blocks if mark in b), "README", "exec"), {})
        return capsys.readouterr().out

    return run


def test_python_example(tmp_path, example):
    """The first example writes its file and prints."""
    assert example(README, "load_case")
    assert (tmp_path / "run.h5").exists()


def test_sweep_example(tmp_path, example):
    """The sweep of the guide ends and prints."""
    assert "slider_acceleration_max" in example(GUIDE, "slider_acceleration_max)")
    assert cl.open_sweep(tmp_path / "map").done.all()


def test_result_file_example(example):
    """The file opens as a tree with units."""
    out = example(GUIDE, "open_datatree")

    assert "0.0001 m" in out
    assert "step_number" in out


def test_example_of_numbers_that_change(tmp_path, example):
    """The clearance is 0.2 mm, 0.22 mm, 0.242 mm: eccentricity over its share of it."""
    assert len(example(GUIDE, "run.every(").splitlines()) == 3

    result = cl.open_result(tmp_path / "worn.h5")
    joint, turn = result.joint("C"), cl.load_case("slider_crank").turn
    clearance = np.hypot(joint.eccentricity_x, joint.eccentricity_y) / joint.eccentricity_ratio
    for n, wanted in enumerate((2e-4, 2.2e-4, 2.42e-4)):
        inside = (result.time > (n + 0.1) * turn) & (result.time < (n + 0.9) * turn)
        np.testing.assert_allclose(clearance[inside], wanted, rtol=1e-9)


@pytest.mark.parametrize(
    ("mark", "printed"), [("inverse_dynamics(", ""), ("identify.fit", "largest friction torque")]
)
def test_examples_of_the_guide(mark, printed, example):
    """Inverse dynamics and a fit print their numbers."""
    out = example(GUIDE, mark)
    assert out
    assert printed in out


def test_own_mechanism(tmp_path, typed):
    """The guide's mechanism runs from a file."""
    path = tmp_path / "my_mechanism.py"
    path.write_text(block("def scene(*, speed"))
    typed("run", path, "--turns 1 --json -o", tmp_path / "r.h5")

    assert cl.open_result(tmp_path / "r.h5").complete


def test_own_law(tmp_path):
    """The guide's law runs in a dropped ball."""
    path = tmp_path / "own_law.py"
    path.write_text(
        "import clearance as cl\n" + block("@contact") + "\ndef scene():\n"
        "    law = liner(stiffness=1e8, hardening=1e8, damping=200.0)\n"
        "    return cl.Scene(cl.ClearanceRevolute(cl.ground, cl.Body('ball', 0.5, 1e-4), name='J', "
        "radius=0.01,\n"
        "        clearance=1e-4, contact=law))\n"
    )
    result = cl.simulate(cl.load_case(path), until=0.02)
    assert (result.joint("J").contact_force >= 0.0).all()
    assert len(result.events["time"]) > 0


def test_first_command_is_the_main_job():
    """The first command of README runs the feeder with mixed joints."""
    job = "clearance run six_bar_feeder -p model=mixed --turns 6 -o run.h5 --plot"
    assert job in TEXT["README.md"]


def test_readme_is_short():
    """One reads it in five minutes: 150 lines at most."""
    assert len(TEXT["README.md"].splitlines()) <= 150


def test_one_cites_this_version():
    """The citation of README has this version."""
    assert f"version = {{{cl.__version__}}}" in TEXT["README.md"]


@pytest.mark.parametrize("page", PAGES)
def test_links_and_pictures_exist(page):
    """Links and pictures of all pages lead to files, and to headings in them."""
    links = re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)|src=\"(.*?)\"", prose(page))
    for link, anchor, picture in links:
        path = (ROOT / page).parent / (link or picture) if link or picture else ROOT / page
        away = link.startswith("http")
        assert away or path.exists(), link or picture
        assert not anchor or away or anchor in anchors(path.read_text()), f"{link}#{anchor}"


def commands(block):
    """Words after `clearance` of each command of a shell block; files that it writes are left
    out.
    """
    block = re.sub(r"(<<'END')\n.*?\nEND$", r"\1", block, flags=re.DOTALL | re.MULTILINE)
    for line in block.splitlines():
        lexer = shlex.shlex(line, posix=True, punctuation_chars=";&|")
        lexer.whitespace_split = True
        for end, words in itertools.groupby(lexer, lambda word: word in (";", "&&", "|", "do")):
            actual = list(words)
            if not end and actual[0].rpartition("/")[2] == "clearance":
                yield actual[1:]


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_understood(page):
    """Each printed `clearance ...` line has options that the command line has; cases and parameters
    exist.
    """
    for text in blocks("sh", (page,)):
        for words in commands(text.replace("${n}", "3000").replace("$n", "3000")):
            options = cli.parser().parse_args(words)
            named = options.command in ("run", "explain", "work-precision", "inverse", "lyapunov")
            if named and not options.case.endswith((".py", ".toml", ".h5")):
                scene_of(options)


def test_law_families_are_all_named():
    """The guide's table of laws has every law of the package."""
    table = TEXT["docs/own_laws.md"].partition("| family |")[2].partition("\n\n")[0]
    laws = [n for n in cl.__all__ if isinstance(getattr(cl, n), Law)]
    assert len(laws) > 40
    assert [n for n in laws if f"`{n}`" not in table] == []


def test_elements_are_all_named():
    """The guide's table of elements has every element of the package."""
    table = TEXT["docs/elements.md"].partition("| element |")[2].partition("\n\n")[0]
    assert [n for n in cl.elements.__all__ if f"`{n}`" not in table] == []


def test_start_page(tmp_path, example):
    """The site's first example prints the force of its page (1e-5), and its page moves."""
    out = example(blocks(pages=("docs/index.md",)), "run.view")
    (printed,) = blocks("text", ("docs/index.md",))
    assert float(out.split()[0]) == pytest.approx(float(printed.split()[0]), rel=1e-5)
    assert (tmp_path / "feeder.html").exists()


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def test_users21_printed_block(tmp_path, monkeypatch, capsys):
    """The block of README is what the command prints: words, and numbers to 1e-5 or one in the last
    digit, which a value on its edge changes. Stated errors are differences of two runs, whose steps
    follow last bits: one of them may cancel by chance, so within a factor of thirty. The number
    with the largest of them is left out.
    """
    monkeypatch.chdir(tmp_path)
    block = next(b for b in re.findall(r"```text\n(.*?)```", TEXT["README.md"], re.DOTALL))
    command, *lines = block.splitlines()
    assert cli.main([*shlex.split(command.removeprefix("$ clearance ")), "-o", "run.h5"]) == 0
    printed = re.split(r"\n(?=  \w)", capsys.readouterr().out)
    shown = {tuple(line.split()[:2]): line for line in printed}
    for line in re.split(r"\n(?=  \w)", "\n".join(lines)):
        texts = " ".join(line.split()), " ".join(shown[tuple(line.split()[:2])].split())
        wanted, actual = (re.sub(r"\(\w*_\w*\)", "", text) for text in texts)
        assert NUMBER.sub("#", wanted) == NUMBER.sub("#", actual)
        before = NUMBER.split(wanted)
        for words, *pair in zip(before, *map(NUMBER.findall, (wanted, actual)), strict=False):
            stated = words.endswith("+- ") or wanted.startswith("error")
            low, high = sorted(map(float, pair))
            places = max(len(n.partition(".")[2]) for n in pair)
            digit = 1.01 * 10.0**-places if places else 0.0  # the last one printed
            assert high <= (30.0 if stated else 1.0 + 1e-5) * low + digit
