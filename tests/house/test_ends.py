"""Shape of the package, by small packages whose numbers can be counted by hand, and of this one."""

import pytest

from tests.benchmarks import ends


@pytest.fixture
def small(tmp_path):
    """Makes a package from the texts of its files."""

    def make(files):
        for name, text in files.items():
            path = tmp_path / "clearance" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    return make


def test_circles_by_imports_and_by_texts(small):
    """Two folders that import each other, and two that name each other in texts; the third names
    one that does not name it.
    """
    root = small(
        {
            "__init__.py": "",
            "a/x.py": "from clearance.b import y",
            "b/y.py": "import clearance.a.x",
            "c/z.py": "WAY = 'clearance.d.w:Thing'",
            "d/w.py": "from importlib import import_module\nimport_module('clearance.c.z')",
            "e/v.py": "from clearance.a import x",
            "flat.py": "",
        }
    )
    assert ends.circles(root) == 2
    assert ends.flat(root) == 1
    assert ends.folders(root) == {"a", "b", "c", "d", "e"}


def test_arguments_and_names(small):
    """A function of eight arguments; one that binds an empty name; a name that two files have."""
    root = small(
        {
            "a/x.py": "def f(a, b, c, d, e, f, g, *, h):\n    return a",
            "b/x.py": "class Run:\n    def go(self):\n        place = 1\n        return place\n",
        }
    )
    functions = {f.name: f for f in ends.functions(root)}
    assert {n: ends.arguments(f) for n, f in functions.items()} == {"f": 8, "go": 1}
    assert [n for n, f in functions.items() if ends.EMPTY & ends.bound(f)] == ["go"]
    assert ends.of_one_name(root) == 1


def test_no_circle_in_this_package():
    """Data flows one way between the folders, imports by a text counted."""
    assert ends.circles(ends.ROOT) == 0
