"""Docstrings of public names: laws with equation, units and source, everything else with a sentence."""

import inspect
import re

import pytest

import clearance as cl
from clearance import results
from clearance.identify import fit, models, records
from clearance.laws.law import Family, Law

PUBLIC = {name: getattr(cl, name) for name in sorted({*cl.__all__, *cl._LAZY})}
LAWS = {name: law for name, law in PUBLIC.items() if isinstance(law, Law)}
CLASSES = {name: c for name, c in PUBLIC.items() if inspect.isclass(c)}
CLASSES |= {c.__name__: c for c in (results.Record, models.LuGre, models.Curve, fit.Fit, records.Trial)}


@pytest.mark.parametrize("name", LAWS)
def test_laws_state_equation_units_and_source(name):
    text = LAWS[name].__doc__
    assert re.search(r"[=:].*[-+*/^()]", text), "an equation"
    assert re.search(r"\[[^\]]+\]", text), "units in brackets"
    assert re.search(r"Source|\(\d{4}\)| \d{4}", text), "a source"


@pytest.mark.parametrize("name", [n for n, o in PUBLIC.items() if inspect.isfunction(o)])
def test_functions_have_a_docstring(name):
    assert inspect.getdoc(PUBLIC[name])


@pytest.mark.parametrize("name", [n for n, o in PUBLIC.items() if inspect.isfunction(o) and n not in ("cP", "degree")])
def test_functions_that_check_say_what_they_raise(name):
    """The docstring of a public function names what its own body raises."""
    source = inspect.getsource(PUBLIC[name])
    assert "raise " not in source or "aises" in inspect.getdoc(PUBLIC[name])


@pytest.mark.parametrize("name", CLASSES)
def test_classes_and_their_public_methods_have_docstrings(name):
    members = inspect.getmembers(CLASSES[name], lambda m: inspect.isfunction(m) or isinstance(m, property))
    found = [n for n, m in members if not n.startswith("_") and not inspect.getdoc(getattr(CLASSES[name], n))]
    assert inspect.getdoc(CLASSES[name])
    assert found == []


def test_families_are_described():
    assert all(inspect.getdoc(f) for f in PUBLIC.values() if isinstance(f, Family))
