"""The table of validation: what its rows state, and that the page in this folder has every test
that states one.
"""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STATED = """
import pytest

def test_good(validated):
    validated("speed", [1.0, 2.02], [1.0, 2.0], 0.02, source="a book", unit="m/s")
    validated("force", 3 + 4.5j, 3 + 4j, 0.11, source="a code", kind="independent", unit="N")
    of = {"source": "a code", "kind": "independent"}
    validated("share", [0.0, 10.2], [0.1, 10.0], 0.021, relative=10.0, **of)
    validated("nothing", [0.0, 0.0], 0.0, 0.0, source="a law", kind="exact")

@pytest.mark.parametrize("x", [1.25, 1.0, 0.5])
def test_worst(x, validated):
    validated("length", x, 1.0, 0.5, source="a law", kind="exact", unit="m", relative=False)

def test_bad(validated):
    validated("load | torque", 3.0, 2.0, 0.1, source="a paper", unit="N")

def test_lost(validated):
    validated("lost", [1.0, float("nan")], 1.0, 0.1, source="a paper")

def test_broken(validated):
    validated("time", 1.0, 1.0, 0.1, source="a clock", unit="s")
    raise RuntimeError("later")

def test_left_out(validated):
    pytest.skip("no such code")

def test_misspelt(validated):
    wrong = "kind must be one of published, independent, exact; got 'exakt'"
    with pytest.raises(ValueError, match=wrong):
        validated("time", 1.0, 1.0, 0.1, source="a clock", kind="exakt")

def test_silent():
    pass
"""
ROWS = """
| speed | a book | published | 2 values | 1.0e-02 | 2.0e-02 | passed | `TEST::test_good` |
| force | a code | independent | 5 N | 1.0e-01 | 1.1e-01 | passed | `TEST::test_good` |
| share | a code | independent | 2 values | 2.0e-02 | 2.1e-02 | passed | `TEST::test_good` |
| nothing | a law | exact | 2 values | 0.0e+00 | 0.0e+00 | passed | `TEST::test_good` |
| length | a law | exact | 3 values | 5.0e-01 m | 5.0e-01 m | passed | `TEST::test_worst` |
| load / torque | a paper | published | 2 N | 5.0e-01 | 1.0e-01 | FAILED | `TEST::test_bad` |
| lost | a paper | published | 2 values | nan | 1.0e-01 | FAILED | `TEST::test_lost` |
| time | a clock | published | 1 s | 0.0e+00 | 1.0e-01 | passed | `TEST::test_broken` |
| the whole test |  |  |  |  |  | FAILED | `TEST::test_broken` |
| the whole test |  |  |  |  |  | not run: no such code | `TEST::test_left_out` |
""".replace("TEST", "test_stated.py")


def stated(folder, *options):
    """The page and the output of tests that pass, fail and are skipped."""
    (folder / "test_stated.py").write_text(STATED)
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "tests.validation.table",
        "-p",
        "no:cacheprovider",
        "--rootdir",
        str(folder),
    ]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")} | {
        "PYTHONPATH": str(ROOT)
    }
    done = subprocess.run(
        [*command, "-m", "validation", "--validation-table", "page.md", *options],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    return (folder / "page.md").read_text(), done.stdout


@pytest.mark.parametrize("options", [(), ("-n", "2")], ids=["alone", "workers"])
def test_rows(tmp_path, options):
    """Deviations by hand; rows that fail and tests that do not run stand there too, whoever ran
    them.
    """
    page, output = stated(tmp_path, *options)
    assert {line for line in page.splitlines() if "`test_stated" in line} == set(
        ROWS.strip().splitlines()
    )
    assert (
        "8 comparisons of 14 values: 6 passed, 2 failed. Whole tests: 1 failed, 1 not run." in page
    )
    assert "load | torque: off by 0.5, allowed 0.1; 3.0 not 2.0" in output
    assert "3 failed, 5 passed, 1 skipped" in output  # and not the silent one


def stating(path):
    """Ids of the tests in a file with the fixture."""
    tree, name = ast.parse(path.read_text()), path.relative_to(ROOT).as_posix()
    for parent in (tree, *(node for node in tree.body if isinstance(node, ast.ClassDef))):
        for node in parent.body:
            asks = isinstance(node, ast.FunctionDef) and "validated" in [
                a.arg for a in node.args.args
            ]
            if asks and node.name.startswith("test_"):
                yield "::".join([name, *([parent.name] if parent is not tree else []), node.name])


def test_the_page_has_every_test_that_states_rows():
    """Otherwise write it again, with the command it begins with."""
    page = (ROOT / "tests/validation/README.md").read_text()
    wanted = {test for path in (ROOT / "tests").rglob("test_*.py") for test in stating(path)}
    assert set(re.findall(r"`(tests/\S+::\S+)`", page)) == wanted
    assert len(wanted) > 100
    assert "FAILED |" not in page
    assert "not run: " not in page
    assert "## Other" not in page
