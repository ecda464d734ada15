"""Caches are named by the code of what makes them: a changed docstring rebuilds nothing."""

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance.files import sealed
from tests.seeds import few_of

PACKAGE = Path(cl.__file__).parent
#: prints the names of all that stays in the store
KEYS = """
import json
from clearance.film import bands, table, pad_table
from clearance.identify import axis_kernel
from clearance.laws.contact import flores
from clearance.machine import store
store.cached = store.Entry = lambda function, *arguments, **options: function
from clearance.lanes import queue
from clearance.stepping import types

def files(function):
    return function._cache._cache_file._index_path

def files_of(function, made_from):
    dispatcher = store.njit()(function)
    store._keep(dispatcher, made_from)
    return files(dispatcher)

print(json.dumps({
    "bearing": table.Key(1.0).name(),
    "pad": pad_table.PadKey(1.0).name(),
    "film": files(bands.film),
    "identify": files(axis_kernel.step),
    "law": store._digest_of(flores.function),
    "kernel": store.digest_of("one"),
    "loop": types.DIGEST,
    "driver": files_of(queue.run, queue.SOURCE),
}))
"""
#: a file whose change renames a key, and all keys that it renames
CHANGES = {
    "film/bands.py": {"bearing", "pad", "film"},
    "stepping/loop.py": {"loop", "driver"},
    "film/lookup.py": {"bearing", "pad", "film"},
    "film/pad_lookup.py": {"pad", "film"},
    "film/table.py": {"bearing", "pad", "film"},
    "film/pad_table.py": {"pad", "film"},
    "film/bearing.py": {"film"},
    "identify/models.py": {"identify"},
    "laws/law.py": {"law"},
    "machine/callback.py": {"kernel"},
    "machine/store.py": {"kernel"},
    "tracing/ir.py": {"kernel"},
    "machine/numba_passes.py": {"loop", "driver"},
    "lanes/queue.py": {"driver"},
    "lanes/steps.py": {"driver"},
}


@pytest.fixture
def package(tmp_path):
    """A copy of the package."""
    ignored = shutil.ignore_patterns("__pycache__", "tables")
    return shutil.copytree(PACKAGE, tmp_path / "clearance", ignore=ignored)


def keys(package):
    """Names in a fresh process."""
    paths = {"PYTHONPATH": str(package.parent), "CLEARANCE_STORE": str(package.parent / "store")}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", KEYS],
        capture_output=True,
        text=True,
        env=os.environ | paths | {"PYTHONDONTWRITEBYTECODE": "1", "NUMBA_CACHE_DIR": ""},
        cwd=package.parent,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def change_words(path):
    """Another sentence in each docstring of a file, a comment and lines before all."""
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    for node in ast.walk(ast.parse("".join(lines))):
        if isinstance(node, sealed.DOCUMENTED) and ast.get_docstring(node):
            row, end = node.body[0].end_lineno - 1, node.body[0].end_col_offset
            text = lines[row].encode()
            lines[row] = (text[: end - 3] + b" Another. " + text[end - 3 :]).decode()
    path.write_text("# another comment\n\n" + "".join(lines), encoding="utf-8")


def test_changed_docstrings_and_comments_rename_nothing(package):
    """Other words in all files: all keys stay."""
    before = keys(package)
    paths = sorted(package.rglob("*.py"))
    assert len(paths) > 200
    for path in paths:
        change_words(path)
    assert keys(package) == before


@pytest.mark.parametrize("name", few_of([*CHANGES], 2))
def test_a_changed_statement_renames_what_it_makes(package, name):
    """And nothing else."""
    before = keys(package)
    path = package / name
    path.write_text(path.read_text(encoding="utf-8") + "\nANOTHER = 1\n", encoding="utf-8")
    after = keys(package)
    assert {k for k in before if after[k] != before[k]} == CHANGES[name]


SAMPLE = '''
"""Module."""
import math  # of numbers


class A: ...


def f(x, *, y=1.0, **more) -> "A":
    """Function."""
    values = [x, 0x10, 1e300, b"\\xff", "\\u00fc\\n", ..., None, True]
    text = f"{x!r:>{y:g}} {x=} {{}}" "and" f"{values[0]:{x}}"
    return [lambda z, /: z @ x for z in values if z is not more] or text
'''


def digest(tmp_path, text):
    """Of a file with a text."""
    path = tmp_path / f"sample_{abs(hash(text))}.py"
    path.write_text(text, encoding="utf-8")
    return sealed.digest_of_code(path)


def test_all_versions_of_python_have_the_same_digest(tmp_path):
    """Film tables come with the package for all of them. Another form needs another number in
    LEDGER.
    """
    assert digest(tmp_path, SAMPLE).startswith("8c6e05234459530664a8")


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ('"""Module."""', "", True),
        ('"""Function."""', "'''Of x.'''", True),
        ("  # of numbers", "", True),
        ("(x, *, y", "(\n        x,  # m\n        *, y", True),
        ("[x, 0x10,", "[x, 16,", True),
        ('"and" f"', '"or" f"', False),
        ("1.0", "1", False),
        ("    return", "    if x:\n        return", False),
        ("values[0]", "values[1]", False),
    ],
)
def test_the_digest_is_that_of_the_code(tmp_path, old, new, same):
    """The digest changes with code, and with nothing else."""
    assert SAMPLE.count(old) == 1
    assert (digest(tmp_path, SAMPLE.replace(old, new)) == digest(tmp_path, SAMPLE)) == same


def test_a_file_is_parsed_once(tmp_path, monkeypatch):
    """The store has its digest until its size or time changes."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path / "store"))
    path = tmp_path / "sample.py"
    path.write_text(SAMPLE)
    of_code = sealed.digest_of_code.__wrapped__
    first = of_code(path)
    with monkeypatch.context() as patch:
        patch.setattr(sealed.ast, "parse", None)
        assert of_code(path) == first
    path.write_text(SAMPLE.replace("0x10", "0x11"))
    os.utime(path, ns=(0, 0))
    assert of_code(path) != first
    (tmp_path / "store" / sealed.LEDGER).write_bytes(b"damaged")
    monkeypatch.setattr(sealed.LOG, "warning", lambda *message: None)
    assert of_code(path) != first


def test_sources_are_parsed_by_one_function():
    """In Python 3.11 threads that parse at once can fail; only this one takes turns."""
    package = Path(cl.__file__).parent
    parsing = {p.name for p in package.rglob("*.py") if "ast.parse(" in p.read_text()}
    assert parsing == {"sealed.py"}
