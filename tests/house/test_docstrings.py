"""Docstrings of public names: laws with equation, units and source, everything else with a
sentence.
"""

import ast
import doctest
import inspect
import re
from pathlib import Path

import pytest

import clearance as cl
from clearance.identify import fit, models, records
from clearance.laws.law import Family, Law
from clearance.results import result
from tests.benchmarks.words import statements

ROOT = Path(__file__).parents[2]
PUBLIC = {name: getattr(cl, name) for name in sorted({*cl.__all__, *cl._LAZY})}
LAWS = {name: law for name, law in PUBLIC.items() if isinstance(law, Law)}
FUNCTIONS = {name: f for name, f in PUBLIC.items() if inspect.isfunction(f)}
CLASSES = {name: c for name, c in PUBLIC.items() if inspect.isclass(c)}
CLASSES |= {
    c.__name__: c for c in (result.Record, models.LuGre, models.Curve, fit.Fit, records.Trial)
}


def lacking(objects, has):
    """Names of the objects that a check does not hold for; there are objects at all."""
    assert objects
    return [name for name, one in objects.items() if not has(one)]


@pytest.mark.parametrize(
    "pattern",
    [
        pytest.param(r"[=:].*[-+*/^()]", id="equation"),
        pytest.param(r"\[[^\]]+\]", id="units in brackets"),
        pytest.param(r"Source|\(\d{4}\)| \d{4}", id="source"),
        pytest.param(r"[Vv]alid", id="validity"),
    ],
)
def test_laws_state_equation_units_and_source(pattern):
    """Every law states its equation, units, validity and source."""
    assert lacking(LAWS, lambda law: re.search(pattern, law.__doc__)) == []


def test_users9_laws_name_each_of_their_parameters():
    """A parameter that a law takes stands in its docstring, and so does the force of a contact."""
    assert lacking(LAWS, lambda law: {*law.inputs} <= {*re.findall(r"\w+", law.__doc__)}) == []
    contacts = {n: law for n, law in LAWS.items() if law.family is cl.contact}
    assert lacking(contacts, lambda law: re.search(r"\bF = |\bf = |Force", law.__doc__)) == []


def test_functions_have_a_docstring():
    """Public functions have docstrings."""
    assert lacking(FUNCTIONS, inspect.getdoc) == []


def test_functions_that_check_say_what_they_raise():
    """The docstring of a public function names what its own body raises."""
    checking = {
        n: f
        for n, f in FUNCTIONS.items()
        if n not in ("cP", "degree") and "raise " in inspect.getsource(f)
    }
    assert lacking(checking, lambda f: "aises" in inspect.getdoc(f)) == []


def test_classes_and_their_public_methods_have_docstrings():
    """So do public classes and their methods."""
    assert lacking(CLASSES, inspect.getdoc) == []
    methods = {
        f"{c.__name__}.{name}": getattr(c, name)
        for c in CLASSES.values()
        for name, member in inspect.getmembers(
            c, lambda m: inspect.isfunction(m) or isinstance(m, property)
        )
        if not name.startswith("_")
    }
    assert lacking(methods, inspect.getdoc) == []


def test_families_are_described():
    """So do the families of laws."""
    assert all(inspect.getdoc(f) for f in PUBLIC.values() if isinstance(f, Family))


#: words of a question that no docstring begins with
QUESTIONS = re.compile(r"(What|Whether|Where|How|Which|Who|Why|When)\b")
FOLDERS = ("clearance", "cases", "postprocess", "paper_figures", "tests")


def documented(path):
    """Names and docstrings of a file."""
    module = ast.parse(path.read_text())
    for node in (module, *statements(module)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
            yield getattr(node, "name", "the module"), ast.get_docstring(node) or ""


def test_no_docstring_begins_with_a_question():
    """Docstrings are sentences or phrases that name a thing."""
    paths = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
    assert len(paths) > 200
    questions = [(p.name, n) for p in paths for n, d in documented(p) if QUESTIONS.match(d)]
    assert questions == []


EXAMPLES = {name: thing for name, thing in PUBLIC.items() if ">>>" in (thing.__doc__ or "")}


#: examples that take seconds
LONG = {"statistics": [pytest.mark.slow], "wear": [pytest.mark.slow]}


@pytest.mark.parametrize("name", [pytest.param(n, marks=LONG.get(n, ())) for n in sorted(EXAMPLES)])
def test_users8_examples_run(name, tmp_path, monkeypatch):
    """The example of a docstring has the printed results."""
    monkeypatch.chdir(tmp_path)
    example = doctest.DocTestParser().get_doctest(EXAMPLES[name].__doc__, {"cl": cl}, name, name, 0)
    runner = doctest.DocTestRunner()
    printed: list[str] = []
    runner.run(example, out=printed.append)
    assert runner.failures == 0, "".join(printed)


def test_users8_the_most_used_names_have_examples():
    """Twenty names at least, among them those that a first session uses."""
    used = {"simulate", "load_case", "open_result", "sweep", "grid", "Scene", "Body", "Drive"}
    assert len(EXAMPLES) >= 20
    assert used <= EXAMPLES.keys()
