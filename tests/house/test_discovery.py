"""Names, signatures and types, as editors and interactive sessions see them."""

import ast
import importlib.util
import inspect
import random
import re
import subprocess
import sys
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path

import pytest

import clearance as cl
from clearance.laws.law import Law, OfJoint
from clearance.values import checks
from clearance.values.accessors import stated
from tests.typed import python

INIT = Path(cl.__file__)
STUB = INIT.with_suffix(".pyi")
LAWS = [n for n in cl.__all__ if isinstance(getattr(cl, n), Law)]
NAMES = ["stiffness", "damping", "depth", "width", "höhe", "n", "speed", "_hidden"]
#: of scenes, whose arguments a user gives
PARTS = ["Body", *(kind for kind in cl.elements.__all__ if is_dataclass(getattr(cl, kind)))]


def test_users5_dir_lists_every_public_name():
    """In a fresh process, nothing imported on first use: at most 77 names, the verbs among them,
    and all laws in their own modules.
    """
    code = (
        "import clearance as cl; names, laws = set(dir(cl)), set(dir(cl.laws)); "
        "films = {f'{n}_film' for n in dir(cl.films)}; "
        "aside = {'worn', *cl._ASIDE}; assert len(names) <= 77; "
        "assert names | laws | films | aside >= set(cl.__all__); "
        "assert names >= {*cl._LAZY, 'films', 'laws', 'Revolute'} - laws - films - aside; "
        "assert not [n for n in cl.__all__ if n not in cl._LAZY and not hasattr(cl, n)]; "
        "assert 'simulation' not in names; import sys; assert 'numba' not in sys.modules"
    )
    python("-c", code)


def test_users5_editors_and_python_have_the_same_lazy_names():
    """Names for type checkers are those that Python imports lazily: it reads all of each stub."""
    imports = [n for n in ast.parse(STUB.read_text()).body if isinstance(n, ast.ImportFrom)]
    named = {a.asname: (node.module, a.name) for node in imports for a in node.names}
    groups = [node.module for node in imports for a in node.names if a.name == "*"]
    assert groups == ["clearance.laws", "clearance.elements"]
    modules = {n: ".".join(named.pop(n)) for n in cl._MODULES}
    assert modules == cl._MODULES
    named.pop(None)  # those of the groups
    assert named == cl._LAZY
    for stub in INIT.parent.rglob("*.pyi"):
        aliases = re.findall(r" as \w+", stub.read_text())
        assert len(stated(str(stub))) == len(aliases) - 3 * (stub == STUB)
    assert (INIT.parent / "py.typed").exists()


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("mypy") is None, reason="mypy is not installed")
def test_type_checkers_know_what_a_run_has(tmp_path):
    """mypy has types of results and scenes, and refuses wrong names."""
    script = tmp_path / "script.py"
    script.write_text(
        "import clearance as cl\n"
        "run = cl.simulate(cl.load_case('six_bar_feeder'), turns=1)\n"
        "reveal_type(run)\nreveal_type(cl.Scene.from_json('{}'))\nrun.nothing\ncl.rpm('3')\n"
    )
    command = [sys.executable, "-m", "mypy", "--config-file=", "--follow-imports=silent", script]
    done = subprocess.run(command, cwd=INIT.parent.parent, capture_output=True, text=True)
    notes = re.findall(r"script\.py:(\d+): (?:note|error): (.*)", done.stdout)
    assert [(int(line), text.split("[")[0].strip()) for line, text in notes] == [
        (3, 'Revealed type is "clearance.results.result.Result"'),
        (4, 'Revealed type is "clearance.scene.scene.Scene"'),
        (5, '"Result" has no attribute "nothing"'),
        (6, 'Argument 1 to "rpm" has incompatible type "str"; expected "float"'),
    ]


@pytest.mark.parametrize("name", LAWS)
def test_users6_signatures_of_laws_are_what_they_take(name):
    """Keywords in the law's order; those without a default are the ones that it needs."""
    law = getattr(cl, name)
    signature = inspect.signature(law)
    assert list(signature.parameters) == law.inputs
    needed = [n for n, p in signature.parameters.items() if p.default is p.empty]
    assert needed == law.needed
    if needed:
        with pytest.raises(TypeError, match=f"missing {', '.join(needed)}"):
            law()


def test_signatures_of_any_law():
    """200 functions, drawn at random: what their signatures accept, the laws do, and nothing
    else.
    """
    draw = random.Random(5)
    for _ in range(200):
        names = draw.sample(NAMES, 4)
        count = draw.randint(0, 4)
        defaults = {n: draw.uniform(0.1, 9.0) for n in names[draw.randint(0, count) : count]}
        of_joint = {n for n in names[:count] if draw.random() < 0.3}
        arguments = [f"{n}={defaults[n]!r}" if n in defaults else n for n in names[:count]]
        scope: dict = {}
        exec(f"def mine({', '.join(['sliding_speed', 'normal_force', *arguments])}): 0", scope)
        check = OfJoint(checks.positive, lambda joint, values: 1.0)
        law = cl.friction(**dict.fromkeys(of_joint, check))(scope["mine"])
        signature = inspect.signature(law)
        for _ in range(5):
            passed = {n: draw.uniform(0.1, 9.0) for n in draw.sample(names, draw.randint(0, 4))}
            try:
                bound = signature.bind(**passed)
            except TypeError:
                with pytest.raises(TypeError):
                    law(**passed)
                continue
            bound.apply_defaults()
            assert law(**passed).values == bound.arguments == law(**bound.arguments).values


@pytest.mark.parametrize("name", PARTS)
def test_users6_required_fields_have_no_default(name):
    """A field whose None is refused is required; each missing one is named."""
    part = getattr(cl, name)
    parameters = inspect.signature(part).parameters
    needed = [n for n, p in parameters.items() if p.default is p.empty]
    assert needed == [f.name for f in fields(part) if f.default is f.default_factory is MISSING]
    draw = random.Random(name)
    for _ in range(10):
        present = draw.sample(needed, draw.randint(0, len(needed) - 1))
        missing = ", ".join(n for n in needed if n not in present)
        label = f"{name} J" if "name" in present else name
        with pytest.raises(TypeError, match=f"^{label} needs {missing}$"):
            part(**dict.fromkeys(present, "J"))


def test_a_missing_clearance_is_named():
    """A joint without its clearance is refused by name."""
    body = cl.Body("rod", 1.0, 1e-3)
    with pytest.raises(TypeError, match="^ClearanceRevolute C needs clearance$"):
        cl.ClearanceRevolute(cl.ground, body, name="C", radius=0.01)
    with pytest.raises(TypeError, match="clearance must be a number, got None"):
        cl.ClearanceRevolute(cl.ground, body, name="C", radius=0.01, clearance=None)


@pytest.mark.parametrize("before", cl._MOVED)
def test_paths_of_before_are_still_there(before):
    """Modules that moved, by the paths that were documented."""
    assert importlib.import_module(before) is importlib.import_module(cl._MOVED[before])


def test_folders_show_what_was_documented_of_their_modules():
    """Documented names of older paths still lead to their classes."""
    from clearance.results import PressureFields, Record, open_result

    assert open_result is cl.open_result
    assert {c.__module__ for c in (PressureFields, Record)} == {"clearance.results.record"}
    with pytest.raises(AttributeError, match=r"did you mean open_result\?"):
        importlib.import_module("clearance.results").open_resul  # noqa: B018
