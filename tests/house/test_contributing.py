"""The walks of CONTRIBUTING.md, applied as printed to a copy of the repository, and run there."""

import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance.machine import store
from tests.seeds import few_of

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text()
FENCED = re.compile(
    r"^(New file `[^`]+`|`[^`]+`, at the end):\n\n```python\n(.*?)^```", re.MULTILINE | re.DOTALL
)
LINE = re.compile(r"^- `([^`]+)`, below `([^`]+)`:\s+`([^`]+)`$", re.MULTILINE)
COMMANDS = re.findall(r"`((?:python -m pytest|clearance run) [^`]+)`", TEXT)
#: folders that the walks leave alone and whose compiled code numba keeps beside them: linked, so
#: that nothing compiles
COMPILED = ("stepping", "film", "identify")
LAW, CASE, JOINT = (
    "tests/laws/test_carvalho_martins.py",
    "tests/cases/test_quick_return.py",
    "tests/elements/test_oldham.py",
)


def apply(root: Path) -> list[Path]:
    """Write what the walks print; returns the files."""
    written = set()
    for where, block in FENCED.findall(TEXT):
        path = root / where.split("`")[1]
        new = where.startswith("New file")
        assert path.exists() != new, path
        path.write_text(block if new else f"{path.read_text()}\n\n{block}")
        written.add(path)
    for name, above, text in LINE.findall(TEXT):
        lines = (root / name).read_text().splitlines(keepends=True)
        at = [i for i, line in enumerate(lines) if line.strip() == above]
        assert len(at) == 1, f"{name}: {above} stands {len(at)} times"
        line = lines[at[0]]
        indent = line[: len(line) - len(line.lstrip())] + (
            "    " if line.rstrip().endswith(("(", "[", "{")) else ""
        )
        lines.insert(at[0] + 1, f"{indent}{text}\n")
        (root / name).write_text("".join(lines))
        written.add(root / name)
    return sorted(written)


def copy(root: Path) -> Path:
    """The package, its cases and its tests, arranged so that they are imported from there.

    Byte code goes with them; that of a file that is written here is older than the file.
    """
    without = shutil.ignore_patterns("*.nb?", "*.h5", "*.png", "references", *COMPILED)
    shutil.copytree(ROOT / "clearance", root / "clearance", ignore=without)
    for name in COMPILED:
        (root / "clearance" / name).symlink_to(ROOT / "clearance" / name, target_is_directory=True)
    for folder in ("cases", "postprocess", "paper_figures"):
        shutil.copytree(ROOT / folder, root / folder, ignore=without)
    shutil.copytree(ROOT / "tests", root / "tests", ignore=shutil.ignore_patterns("*.h5"))
    shutil.copy(ROOT / "pyproject.toml", root)
    (root / "docs").mkdir()
    for name in ("fields.py", "elements.md", "mechanism.md", "wear.md"):
        shutil.copy(ROOT / "docs" / name, root / "docs")
    return root


def run(root: Path, *arguments: str) -> subprocess.CompletedProcess:
    """Python in the copy, whose modules come before installed ones; kernels are those of this
    session.
    """
    before = os.environ.get("PYTHONPATH", "")
    environment = os.environ | {
        "PYTHONPATH": f"{root}{os.pathsep}{before}" if before else str(root)
    }
    environment |= {"CLEARANCE_STORE": str(store.folder()), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, *arguments], cwd=root, env=environment, capture_output=True, text=True
    )


def printed(command: str) -> list[str]:
    """A printed command as arguments of Python."""
    program, *arguments = shlex.split(command)
    if program == "clearance":
        return ["-m", "clearance.cli", *arguments]
    return [*arguments, "-q", "-p", "no:cacheprovider", "-p", "no:xdist"]


@pytest.fixture(scope="module")
def walked(tmp_path_factory) -> Path:
    root = copy(tmp_path_factory.mktemp("repository"))
    apply(root)
    return root


def test_the_copy_is_what_runs(walked):
    """Modules come from the copy of the repository."""
    modules = (
        "clearance",
        "clearance.laws.contact",
        "clearance.cases",
        "clearance.postprocess",
        "tests.laws.test_laws",
    )
    code = (
        f"import importlib; print(*(importlib.import_module(m).__file__ for m in {modules}), "
        "sep='\\n')"
    )
    actual = run(walked, "-c", code)
    assert actual.returncode == 0, actual.stderr
    assert all(Path(line).is_relative_to(walked) for line in actual.stdout.split())


@pytest.mark.parametrize("command", few_of([c for c in COMMANDS if "pytest" in c], 1))
def test_printed_tests_pass(walked, command):
    """The tests of the walks pass."""
    actual = run(walked, *printed(command))
    assert actual.returncode == 0, actual.stdout[-3000:] + actual.stderr[-1000:]
    assert " passed" in actual.stdout


def test_the_new_case_is_listed(walked):
    """`clearance cases` has the new case."""
    actual = run(walked, "-m", "clearance.cli", "cases", "--json")
    assert actual.returncode == 0, actual.stderr
    assert "quick_return" in json.dumps(json.loads(actual.stdout))


def test_the_guide_takes_up_the_new_joint(walked):
    """The printed command writes a row of the table of fields for it."""
    assert "`python docs/fields.py`" in TEXT
    actual = run(walked, "docs/fields.py")
    assert actual.returncode == 0, actual.stderr
    assert "| `[joint]` | `Oldham` |" in (walked / "docs" / "elements.md").read_text()


def test_printed_run(walked):
    """The printed run is complete and has the new law."""
    (command,) = (c for c in COMMANDS if c.startswith("clearance run"))
    actual = run(walked, *printed(command))
    assert actual.returncode == 0, actual.stdout + actual.stderr
    with cl.open_result(walked / shlex.split(command)[-1]) as result:
        assert result.complete
        assert "carvalho_martins" in result.attributes["scene"]
        assert (result.joint("B").contact_force > 0.0).any()


@pytest.mark.parametrize(
    ("file", "right", "wrong", "test"),
    [
        ("clearance/laws/contact.py", "(11.0 - restitution)", "(10.0 - restitution)", LAW),
        pytest.param(
            "cases/quick_return.py",
            "cl.ground.at(0.12, 0)",
            "cl.ground.at(0.12001, 0)",
            CASE,
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "clearance/elements/oldham.py",
            'FREE, FREE, Known("angle")',
            "FREE, FREE, Known()",
            JOINT,
            marks=pytest.mark.slow,
        ),
    ],
)
def test_printed_tests_can_fail(walked, file, right, wrong, test):
    """A wrong number is noticed, by an assertion and not by an import that breaks."""
    path = walked / file
    text = path.read_text()
    assert text.count(right) == 1
    path.write_text(text.replace(right, wrong))
    try:
        actual = run(walked, *printed(f"python -m pytest {test}"))
    finally:
        path.write_text(text)
    assert actual.returncode == 1, actual.stdout[-2000:]
    assert "AssertionError" in actual.stdout or "assert " in actual.stdout


@pytest.mark.skipif(importlib.util.find_spec("ruff") is None, reason="ruff is not installed")
def test_the_linter_has_nothing_to_say(walked):
    """Files of the walks pass the linter."""
    names = {where.split("`")[1] for where, _ in FENCED.findall(TEXT)} | {
        name for name, _, _ in LINE.findall(TEXT)
    }
    actual = run(walked, "-m", "ruff", "check", "--no-cache", *sorted(names))
    assert actual.returncode == 0, actual.stdout


def test_the_law_is_new():
    """The walk adds what the package lacks."""
    assert "carvalho_martins" not in cl.__all__
    assert not (ROOT / "cases" / "quick_return.py").exists()


def test_the_page_stays_short():
    """Words, lines and blocks of the page are counted."""
    prose = re.sub(r"<!-- street -->.*<!-- street:end -->", "", TEXT, flags=re.DOTALL)
    assert len(prose.split()) <= 1400  # the table is made: a row for each folder
    assert max(map(len, TEXT.splitlines())) <= 160
    assert len(FENCED.findall(TEXT)) == 6
    assert len(LINE.findall(TEXT)) == 2
    assert len(COMMANDS) == 4
