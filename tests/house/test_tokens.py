"""The count of tokens: what counts, and the table of the script."""

import re

import pytest

from tests.benchmarks import tokens

PLAIN = "def long(a, b):\n    return a + b\n\n\nclass A:\n    def f(self): return 1\n"
DRESSED = '''"""Title."""

# a remark
def long(
    a, b
):
    """Sum."""

    return a + b  # of both


class A:
    """Doc."""
    def f(self): return 1
'''


def test_comments_docstrings_and_layout_do_not_count():
    """`def long(a, b):` has 8 tokens, its return 4; `class A:` has 3, the line of `f` 8."""
    count = tokens.counted(PLAIN, "one.py")
    assert count == tokens.counted(DRESSED, "one.py")
    assert count == tokens.Count(8 + 4 + 3 + 8, 12, "one.py: long")


def test_a_docstring_beside_its_function_takes_nothing_else_along():
    """Only docstrings are left out, not what shares their line."""
    assert tokens.counted('def f(): "doc"\n', "").tokens == 5
    assert tokens.counted('x = """no docstring"""\n', "").tokens == 3


def rows(text):
    """Cells of a table by their first one."""
    lines = [re.split(r" ?\| ?", line)[1:-1] for line in text.splitlines()[2:]]
    return {cells[0]: cells[1:] for cells in lines}


def test_the_table_of_folders_and_files_beside_another_checkout(tmp_path, capsys):
    """A folder is the sum of its files; another checkout without one of them shows the
    difference.
    """
    (tmp_path / "clearance" / "elements").mkdir(parents=True)
    text = (tokens.ROOT / "clearance/elements/weld.py").read_text()
    (tmp_path / "clearance/elements/weld.py").write_text(text)
    tokens.main(["clearance/elements", "--files", "--before", str(tmp_path)])
    table = rows(capsys.readouterr().out)
    files = {name: int(cells[0]) for name, cells in table.items() if name.endswith(".py")}
    assert int(table["clearance/elements"][0]) == int(table["all"][0]) == sum(files.values())
    assert table["clearance/elements/weld.py"][1:3] == [
        str(files["clearance/elements/weld.py"]),
        "+0",
    ]
    assert int(table["all"][2]) == sum(files.values()) - files["clearance/elements/weld.py"]
    assert int(table["clearance/elements"][4]) > 100


def test_the_core_is_all_there():
    """Each path has files, and no file stands below two of them."""
    files = [list(tokens.sources(tokens.ROOT, path)) for path in tokens.CORE]
    assert all(files)
    assert len(set().union(*files)) == sum(map(len, files))


def test_a_path_without_python_files_is_refused(capsys):
    """A path without code is named."""
    with pytest.raises(SystemExit, match="2"):
        tokens.main(["clearance/nothing"])
    assert "clearance/nothing: no Python file there" in capsys.readouterr().err
