"""Scene files: what they build, their error messages, and what result files hold of a scene."""

import json
import math
import random
import sys

import numpy as np
import pytest

import clearance as cl
from clearance.scene import templates
from clearance.scene.catalogue import case_names, find_case, library
from clearance.scene.toml_scene import FUNCTIONS, formula, scene_file
from clearance.scene.write_python import python_of
from clearance.scene.write_toml import toml_of
from tests import mechanisms as m
from tests.pages import block
from tests.random_scenes import ALIKE, draw
from tests.seeds import few_of
from tests.typed import python

FEEDER = """
name = "six_bar_feeder"
gravity = [0, "-9.81 m/s2"]

[parameters]
speed = { value = "300 rpm", text = "crank speed" }
clearance = "0.1 mm"
viscosity = "5 cP"

[body]
crank = { mass = "94.2 g", inertia = 3.140e-5, points = { A = ["-20 mm", 0], B = ["20 mm", 0] } }
rod2 = {mass = 0.2826, inertia = 7.724e-4, points = {B = ["-80 mm", 0], C = [0.08, 0]}, angle = 0.6}
rod4 = { mass = 0.2669, inertia = 6.517e-4, points = { E = ["-75 mm", 0], F = ["75 mm", 0] } }
slider = { mass = "500 g", inertia = 1e-4, points = { F = [0, 0] } }

[body.rocker]
mass = 0.3140
inertia = "1.057e-3 kg m2"
angle = 1.6
points = { D = ["-90 mm", 0], C = ["30 mm", 0], E = ["90 mm", 0] }

[lubricant]
oil = { viscosity = "$viscosity" }

[joint]
A = { kind = "Revolute", a = [0, 0], b = "crank.A" }
B.kind = "ClearanceRevolute"
B.a = "crank.B"
B.b = "rod2.B"
B.radius = "10 mm"
B.clearance = "$clearance"
B.length = "20 mm"
B.roughness = "0.8 um"
B.lubricant = "oil"
B.contact = { law = "winkler", restitution = 0.9 }
B.friction = { law = "coulomb", coefficient = "$viscosity * 20" }
B.film = "table"
B.transition = { law = "fuzzy", dry = 0.4, mixed = 1, full = 3 }
C = { kind = "Revolute", a = "rod2.C", b = "rocker.C" }
D = { kind = "Revolute", a = ["170 mm", "-90 mm"], b = "rocker.D" }
E = { kind = "Revolute", a = "rocker.E", b = "rod4.E" }
F = { kind = "Revolute", a = "rod4.F", b = "slider.F" }
guide = { kind = "Prismatic", a = [0, "80 mm"], b = "slider.F" }

[drive]
crank = { target = "crank", speed = "$speed", start = "0 deg" }
"""


def case_of(folder, text):
    """The case of a scene file with this text."""
    path = folder / "machine.toml"
    path.write_text(text)
    return find_case(path)


def test_a_scene_file_is_the_scene_of_the_case(tmp_path):
    """The feeder with all kinds of values: its description is that of the Python case, number by
    number.
    """
    case = case_of(tmp_path, FEEDER)
    values = {"speed": cl.rpm(200), "viscosity": 0.004, "clearance": 2e-4}
    expected = cl.load_case(
        "six_bar_feeder", model="mixed", transition="fuzzy", friction_coefficient=0.08, **values
    )
    assert case.scene(**values).to_json() == expected.to_json()
    assert case.parameters["speed"].units == "rad/s"
    assert case.parameters["speed"].text == "crank speed"


WRONG = [
    (
        "B.clearance =",
        "B.clearence =",
        "joint.B.clearence: unknown field 'clearence' of ClearanceRevolute",
    ),
    (
        "restitution = 0.9",
        "restitution = 1.9",
        "joint.B.contact.restitution: winkler: restitution must lie",
    ),
    (
        'clearance = "0.1 mm"',
        'clearance = "0.1 mmm"',
        "parameters.clearance.value: unknown unit 'mmm'",
    ),
    ('"10 mm"', '"10 kg"', "joint.B.radius: '10 kg' is in kg, expected m"),
    ('"$speed"', '"$sped"', "drive.crank.speed: unknown parameter $sped (did you mean speed?)"),
    (
        '"$clearance"',
        '"-$clearance"',
        "joint.B.clearance: clearance must be positive, got -0.0001, from",
    ),
    ('"rod2.B"', '"rod3.B"', "joint.B.b: unknown body 'rod3' (did you mean rod4?)"),
    ('"rod2.B"', '"rod2.X"', "joint.B.b: body rod2 has no point 'X'"),
    ('"winkler"', '"winklr"', "joint.B.contact.law: unknown law 'winklr' (did you mean winkler?)"),
    ('B.film = "table"', 'B.film = "hertz"', "joint.B.film.law: unknown law 'hertz'"),
    (
        'B.film = "table"',
        'B.film = "table_flm"',
        "joint.B.film.law: unknown law 'table_flm' (did you mean table_film?)",
    ),
    ('"oil"', '"oli"', "joint.B.lubricant: unknown lubricant 'oli' (did you mean oil?)"),
    (
        'oil = { viscosity = "$viscosity" }',
        "oil = 0.04",
        "lubricant.oil: expected a table, got 0.04",
    ),
    (
        'oil = { viscosity = "$viscosity" }',
        'oil = "ISO VG 47"',
        "lubricant.oil: no grade 'ISO VG 47' (did you mean ISO VG 46?)",
    ),
    ("[drive]", "[drve]", "drve: unknown section (did you mean drive?)"),
    ('"Prismatic"', '"Prism"', "joint.guide.kind: kind must be one of"),
    ("mass = 0.3140", "mass = -0.3140", "body.rocker.mass: mass must be positive"),
    (
        'target = "crank"',
        'target = "crnk"',
        "drive.crank.target: nothing of that name: 'crnk' (did you mean crank?)",
    ),
    (
        "restitution = 0.9",
        'restitution = "0.8 mm"',
        "joint.B.contact.restitution: '0.8 mm' is in m, expected a plain number",
    ),
    (
        "restitution = 0.9",
        'grazing_speed = "1 rpm"',
        "joint.B.contact.grazing_speed: '1 rpm' is in rad/s, expected m/s",
    ),
    (
        '"0.8 um"',
        '"$speed"',
        "joint.B.roughness: '31.41592653589793 rad/s' is in rad/s, expected m, from \"$speed\"",
    ),
    ('-9.81 m/s2"', '-9.81 m"', "gravity: '-9.81 m' is in m, expected m/s2"),
    ("[joint]", "[joint", "Expected ']'"),
    ('gravity = [0, "-9.81 m/s2"]', "gravity = 9.81", "gravity: gravity must be a pair of numbers"),
    ('"$speed"', "300rpm", "Unclosed inline table"),
    ('target = "crank"', "target = crank", "Invalid value"),
    ('target = "crank", speed', 'target = "crank" speed', "Unclosed inline table"),
]


@pytest.mark.parametrize(
    ("right", "wrong", "message"), WRONG, ids=[w[2].partition(": ")[0] for w in WRONG]
)
def test_errors_name_file_line_and_field(tmp_path, right, wrong, message):
    """The line is that of the change."""
    text = FEEDER.replace(right, wrong, 1)
    pairs = enumerate(zip(text.splitlines(), FEEDER.splitlines(), strict=True), 1)
    line = next(i for i, (one, other) in pairs if one != other)
    with pytest.raises(ValueError, match=r"machine\.toml") as error:
        case_of(tmp_path, text).scene()
    assert f"machine.toml:{line}: {message}" in str(error.value)


@pytest.mark.parametrize("text", ["", 'name = "x"\n[body]\na = { mass = 1, inertia = 1 }\n'])
def test_a_file_without_elements_is_refused_by_name(tmp_path, text):
    """An empty file is refused by its name."""
    with pytest.raises(ValueError, match=r"machine\.toml: no joint, load or drive is there"):
        case_of(tmp_path, text).scene()


def test_a_parameter_that_nothing_reads_is_named(tmp_path, caplog):
    """A parameter without effect is warned of."""
    case_of(tmp_path, FEEDER)
    assert caplog.text == ""
    case_of(tmp_path, FEEDER.replace("[parameters]", "[parameters]\nload = 1"))
    assert "nothing in the file reads load" in caplog.text


def test_a_missing_field_and_a_body_without_joint(tmp_path):
    """The first names the table of the element, the second its own line."""
    with pytest.raises(ValueError, match="joint.B: ClearanceRevolute needs radius"):
        case_of(tmp_path, FEEDER.replace('B.radius = "10 mm"\n', "")).scene()
    text = FEEDER.replace("[lubricant]", "[body.idle]\nmass = 1\ninertia = 1\n[lubricant]")
    with pytest.raises(ValueError, match="body.idle: no joint and no load holds this body"):
        case_of(tmp_path, text).scene()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("$a / 2 + 1 mm", 0.026),
        ("2 * pi / $a", 40.0 * math.pi),
        ("-($a - 10 mm)**2", -0.0016),
        ("sqrt(hypot(3, 4) * 5) * sin(90 deg)", 5.0),
        ("2*pi*$n", 6.0 * math.pi),
        ("10 mm/2", 0.005),
        ("min($a, 40 mm)", 0.04),
        ("$word", "dry"),
    ],
)
def test_formulas(text, value):
    """To rounding."""
    actual = formula(text, {"a": 0.05, "n": 3.0, "word": "dry"})
    assert actual == (value if isinstance(value, str) else pytest.approx(value, rel=1e-15))


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9**9",
        "$a.real",
        "$a()",
        "__import__('os')",
        "$word * 2",
        "1 foo + $a",
        "$a / 0",
        "max($a",
        "$2*pi/a",
        "$a*pi/n",
    ],
)
def test_what_is_no_formula(text):
    """A text that is no formula is refused."""
    with pytest.raises(ValueError, match="formula|division|out of range"):
        formula(text, {"a": 0.05, "word": "dry"})


def test_a_formula_that_cannot_be_read_says_what_may_stand_there():
    """A parameter without its sign, or a sign without a parameter: all functions are named."""
    for text in ("$2*pi/a", "$a*pi/n", "$ a", "$a ^ 2"):
        with pytest.raises(ValueError, match=r"parameters with a \$ each") as refused:
            formula(text, {"a": 0.05, "n": 3.0})
        assert all(name in str(refused.value) for name in ("pi", *FUNCTIONS))


SHAPES = """
[parameters]
wide = "{wide} mm"
throw = "{throw} mm"
[material.own]
young = "3 GPa"
poisson = 0.4
density = {density}
[body]
crank = {{ section = ["{high} mm", "$wide"], points = {{ A = 0, B = "$throw" }}, material = "own" }}
[body.rod]
section = "$wide / 2"
points = {{ B = "-60 mm", C = 0.06 }}
length = "$throw + 80 mm"
material = "bronze"
angle = "2 deg"
[body.slider]
outline = [[0, 0], ["$wide", 0], ["$wide", "{high} mm"], [0, "{high} mm"]]
thickness = "{high} mm"
holes = [["$wide / 2", "{high} mm", "$wide / 10"]]
points = {{ C = ["1 mm", 0] }}
[joint]
A = {{ kind = "Revolute", a = "ground", b = "crank.A" }}
B = {{ kind = "Revolute", a = "crank.B", b = "rod.B" }}
C = {{ kind = "Revolute", a = "rod.C", b = "slider.C" }}
guide = {{ kind = "Prismatic", a = "ground", b = "slider.C" }}
[drive]
crank = {{ target = "crank", speed = "300 rpm" }}
"""


@pytest.mark.parametrize("seed", range(4))
def test_bars_and_plates_of_a_file_are_those_of_python(seed, tmp_path):
    """Random sections, outlines and densities, by parameters: bit for bit, and as the file that is
    written of the scene has their masses.
    """
    wide, throw, high, density = np.random.default_rng(seed).uniform(
        [5.0, 20.0, 2.0, 500.0], [40.0, 60.0, 30.0, 9e3]
    )
    text = SHAPES.format(wide=wide, throw=throw, high=high, density=density)
    scene = case_of(tmp_path, text).scene()
    wide, throw, high = (cl.units.quantity(f"{n} mm") for n in (wide, throw, high))
    plastic = cl.Material("own", 3e9, 0.4, density)
    corners = [(0.0, 0.0), (wide, 0.0), (wide, high), (0.0, high)]
    expected = [
        cl.Body.bar("crank", {"A": 0.0, "B": throw}, (high, wide), material=plastic),
        cl.Body.bar(
            "rod",
            {"B": -0.06, "C": 0.06},
            wide / 2.0,
            length=throw + 0.08,
            material="bronze",
            angle=math.radians(2.0),
        ),
        cl.Body.plate(
            "slider",
            corners,
            high,
            holes=[(wide / 2.0, high, wide / 10.0)],
            points={"C": (1e-3, 0.0)},
        ),
    ]
    again = case_of(tmp_path, toml_of(scene)).scene()
    for body, written, wanted in zip(scene.bodies, again.bodies, expected, strict=True):
        for name in ("name", "mass", "inertia", "com", "points"):
            assert getattr(body, name) == getattr(written, name) == getattr(wanted, name)
        assert body.angle == pytest.approx(wanted.angle, rel=1e-15)


@pytest.mark.parametrize(
    ("right", "wrong", "message"),
    [
        ('section = "$wide / 2"', 'section = "2 kg"', "rod.section: section: '2 kg' is in kg"),
        ('angle = "2 deg"', "mass = 1", "rod.mass: unknown field 'mass' of a bar; it has name, "),
        ('length = "$throw + 80 mm"', 'lenght = "1 m"', "(did you mean length?)"),
        ('points = {{ B = "-60 mm", C = 0.06 }}', "", "rod: Body.bar() missing"),
        ('"bronze"', '"bronz"', "rod.material: unknown material 'bronz' (did you mean bronze?)"),
        ('thickness = "{high} mm"', "", "slider: Body.plate() missing"),
        (', "$wide / 10"]', "]", "a hole is (x, y, radius) [m], got"),
    ],
)
def test_messages_of_bars_and_plates(right, wrong, message, tmp_path):
    """File, line and field, as of other bodies."""
    text = SHAPES.replace(right, wrong).format(wide=10, throw=50, high=5, density=1e3)
    with pytest.raises(ValueError, match=r"machine\.toml:\d+: body\.") as refused:
        case_of(tmp_path, text).scene()
    assert message in str(refused.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[body]\nmass = 1\n", r":2: body.mass: expected a table, got 1; \[body.NAME\] begins"),
        ("[body]\nb = 3\n", r":2: body.b: expected a table, got 3"),
        ("[drive]\nspeed = 3\n", r":2: drive.speed: expected a table, got 3; \[drive.NAME\]"),
        ("[[drive]]\nspeed = 3\n", r":1: drive: expected a table, got \[.*\]; \[drive.NAME\]"),
        ("[body]\nb = {mass = 1}\nb.mass = 3\n", ":3: b.mass stands there twice"),
        ('[body]\nb = { mass = "1 kg",\n inertia = 1 }\n', r":2: .*\{ \} is one line, with"),
        ("[body]\nb.mass = 1 kg\n", ":2: .*stand in quotes"),
    ],
)
def test_slips_of_tables_and_of_the_syntax(text, message, tmp_path):
    """Elements without a name, and values without quotes: the line and the remedy."""
    with pytest.raises(ValueError, match=rf"machine\.toml{message}"):
        case_of(tmp_path, text).scene()


@pytest.mark.parametrize("name", ["table", "fast", "conserving", "short", "long", "sommerfeld"])
def test_films_have_both_names_of_python(tmp_path, name):
    """Those of `cl.films` and those of `cl`, such as table and table_film."""
    film = getattr(cl.films, name)
    other = getattr(film, "name", None) or film.__name__
    assert other != name
    scenes = []
    for law in (name, other):
        (folder := tmp_path / law).mkdir()
        scenes.append(case_of(folder, FEEDER.replace('"table"', f'"{law}"')).scene())
    first, second = (next(j for j in s.joints if j.name == "B").film for s in scenes)
    assert first == second


def test_a_law_in_a_file_beside_and_other_elements(tmp_path):
    """A law of one's own, a joint as target, a thermal node, a switch by a word."""
    (tmp_path / "my_laws.py").write_text(
        "from clearance.laws import contact\n\n\n@contact\n"
        "def liner(penetration, penetration_rate, impact_speed, stiffness):\n"
        '    """k d [N]."""\n    return max(stiffness * penetration, 0.0)\n'
    )
    scene = case_of(
        tmp_path,
        """
        [parameters]
        rubbing = { value = "none", text = "friction law" }
        [body]
        arm = { mass = "1 kg", inertia = 0.01, points = { A = ["-0.1 m", 0], E = ["0.1 m", 0] } }
        tip = { mass = "100 g", inertia = 1e-5 }
        [joint]
        A = { kind = "Revolute", a = "ground", b = "arm.A" }
        [joint.E]
        kind = "ClearanceRevolute"
        a = "arm.E"
        b = "tip"
        radius = 0.01
        clearance = 1e-4
        friction = "$rubbing"
        contact = { law = "my_laws.py:liner", stiffness = "1 kN/m" }
        [drive.motor]
        target = "joint.A"
        torque = { law = "motor_line", stall = "2 N m", no_load = "300 rpm" }
        nominal = "300 rpm"
        [node]
        housing = { capacity = "100 J/K", conductance = "2 W/K" }
        """,
    )
    built = scene.scene()
    assert built.clearance_joints[0].contact.values == {"stiffness": 1000.0}
    assert built.clearance_joints[0].friction is None
    assert built.drives[0].target is built.joints[0]
    assert built.drives[0].torque.values == {"stall": 2.0, "no_load": cl.rpm(300)}
    assert built.loads[1].capacity == 100.0
    assert cl.Scene.from_json(built.to_json()).to_json() == built.to_json()


# --- scenes as JSON
CASES = [
    *((name, {}) for name in case_names()),
    *(
        ("six_bar_feeder", {"model": "mixed", "film": film})
        for film in ("table", "fem", "conserving")
    ),
    ("slider_crank", {"model": "mixed", "joints": "C,guide", "drive": "pi", "contact": "hertz"}),
]


@pytest.mark.parametrize(
    ("name", "values"), CASES, ids=[f"{n}-{i}" for i, (n, _) in enumerate(CASES)]
)
def test_scenes_of_cases_from_json(name, values):
    """The scene and what its joints determine, also after a change that laws follow."""
    scene = cl.load_case(name, **values)
    again = cl.Scene.from_json(scene.to_json())
    assert again.to_json() == scene.to_json()
    if name == "six_bar_feeder":
        change = {"joints/B/clearance": 2e-4}
        assert again.replaced(change).to_json() == scene.replaced(change).to_json()


CONTACTS = [law for law in vars(cl.laws).values() if isinstance(law, cl.Law)]
CONTACTS = {law.name: law for law in CONTACTS if law.family.name == "contact"}


@pytest.mark.parametrize("law", CONTACTS.values(), ids=CONTACTS)
def test_given_numbers_of_contacts_come_back(law):
    """At random; also a stiffness beside an exponent for which a joint determines none."""
    rng = np.random.default_rng(len(law.name))
    for _ in range(20):
        values = {n: 10.0 ** rng.uniform(-3.0, 9.0) for n in law.inputs}
        ranges = {"exponent": (1.0, 2.5), "restitution": (0.01, 1.0)}
        values |= {n: rng.uniform(*ends) for n, ends in ranges.items() if n in values}
        size = {"radius": 0.1, "clearance": 1e-3, "length": 0.1}
        contact = law(**values)
        joint = cl.ClearanceRevolute(cl.ground, cl.Body("b", 1.0, 1.0), contact=contact, **size)
        (again,) = cl.Scene.from_json(cl.Scene(joint).to_json()).joints
        assert again.contact.values == joint.contact.values


def test_elastic_films_come_back(tmp_path):
    """Scene files of 20 random films on a layer, with and without numbers that the joint gives."""
    rng = random.Random(3)
    numbers = {
        "liner": lambda: 10.0 ** rng.uniform(-12.0, -11.0),
        "pressure_viscosity": lambda: rng.uniform(1e-9, 2e-8),
        "roelands": lambda: True,
        "follows": lambda: rng.random(),
        "drag": lambda: "wet",
    }
    for _ in range(20):
        film = cl.elastic_film(**{n: f() for n, f in numbers.items() if rng.random() < 0.4})
        joint = cl.ClearanceRevolute(
            cl.ground,
            cl.Body("b", 1.0, 1.0),
            **{"radius": 0.01, "clearance": 1e-4, "length": rng.uniform(0.01, 0.04)},
            film=film,
            lubricant=cl.Lubricant(0.01),
            material=cl.Material.named("PTFE"),
            layer=rng.uniform(2e-3, 5e-3),
        )
        text = (scene := cl.Scene(joint)).to_json()
        assert case_of(tmp_path, toml_of(scene)).scene().to_json() == text


def test_laws_of_a_case_file_come_back_in_another_process(tmp_path):
    """The text of the file is in the document; a law without it is refused."""
    text = (
        cl.load_case("three_loop_chain")
        .to_json()
        .replace("clearance_case_three_loop", "clearance_case_other")
    )
    (tmp_path / "scene.json").write_text(text)
    code = (
        "import pathlib, clearance as cl\n"
        "text = pathlib.Path('scene.json').read_text()\n"
        "scene = cl.Scene.from_json(text)\n"
        "assert scene.to_json() == text\n"
        "print(scene.drives[0].motion(0.5))\n"
    )
    assert float(python("-c", code, cwd=tmp_path).stdout) == cl.load_case(
        "three_loop_chain"
    ).drives[0].motion(0.5)
    document = json.loads(text)
    del document["sources"]
    with pytest.raises(ValueError, match="no text of clearance_case_other"):
        cl.Scene.from_json(json.dumps(document))


# --- new
@pytest.mark.parametrize("name", few_of(templates.NAMES, 2))
def test_a_new_scene_file_runs_as_written(name, tmp_path, monkeypatch, typed):
    """A tenth of a turn, with a parameter given; the same name is not written twice."""
    monkeypatch.chdir(tmp_path)
    typed("new", name)
    words = "-p speed=100rpm --turns 0.1 --no-error -o run.h5"
    assert "given        speed = 10.472 rad/s (100 rpm)" in typed("run", f"{name}.toml", words).out
    with cl.open_result("run.h5") as run:
        assert run.status == "complete"
        assert json.loads(run.file.attrs["parameters"]) == {"speed": cl.rpm(100)}
    assert "is there already" in typed.line("new", name)


@pytest.mark.parametrize("name", templates.NAMES)
def test_a_new_python_case_is_the_same_scene(name, tmp_path, monkeypatch, typed):
    """Number by number, also with parameters given; names, units and texts of parameters as
    well.
    """
    monkeypatch.chdir(tmp_path)
    typed("new", name, "--python")

    file, python = find_case(templates.path_of(name)), find_case(f"./{name}.py")
    values = {"speed": 12.0, "clearance": 1.5e-4}
    assert python.scene(**values).to_json() == file.scene(**values).to_json()
    assert python.parameters == file.parameters
    assert python.summary == file.summary


@pytest.mark.parametrize("first", few_of(range(0, 60, 10), 2))
def test_ranges4_random_scenes_are_the_same_as_files_and_as_python(first, tmp_path):
    """Every element and reference, number by number; laws and elements of users have no names
    there.
    """
    compared = 0
    for seed in range(first, first + 10):
        scene = draw(ALIKE * seed).scene
        laws = [
            v.law.function for e in scene.elements for v in vars(e).values() if hasattr(v, "law")
        ]
        if any(one.__module__.startswith("tests") for one in (*laws, *map(type, scene.elements))):
            continue
        _written(tmp_path / f"s{seed}.toml", toml_of(scene))
        scenes = [scene_file(tmp_path / f"s{seed}.toml").scene()]
        python = _written(tmp_path / f"p{seed}.py", python_of(tmp_path / f"s{seed}.toml"))
        scenes.append(find_case(str(python)).scene())
        assert scenes[0].to_json() == scenes[1].to_json()
        compared += 1
    assert compared > 2


def _written(path, text):
    path.write_text(text)
    return path


def test_a_scene_file_of_your_own_as_python(tmp_path, monkeypatch, typed):
    """The feeder; a law of a module is imported, a law that a parameter names is refused."""
    monkeypatch.chdir(tmp_path)
    case = case_of(tmp_path, FEEDER)
    typed("new machine.toml --python -o feeder.py")
    assert find_case("./feeder.py").scene().to_json() == case.scene().to_json()
    (tmp_path / "machine.toml").write_text(
        FEEDER.replace('"winkler"', '"clearance.laws.contact:winkler"')
    )
    typed("new machine.toml --python -o imported.py")
    assert "from clearance.laws.contact import winkler\n" in (tmp_path / "imported.py").read_text()
    assert find_case("./imported.py").scene().to_json() == case.scene().to_json()
    (tmp_path / "machine.toml").write_text(
        FEEDER.replace('"winkler"', '"$law"').replace(
            "[parameters]", '[parameters]\nlaw = "winkler"'
        )
    )
    assert "joint.B.contact: law '$law' is no name" in typed.line("new machine.toml --python")
    assert "did you mean four_bar?" in typed.line("new four_bra")


# --- scenes as scene files
WRITTEN = [
    *((name, {}) for name in ("double_pendulum", "four_bar", "guide_slider", "wear_a")),
    *(
        ("six_bar_feeder", {"model": "mixed", "film": film})
        for film in ("short", "fem", "conserving")
    ),
    ("six_bar_feeder", {"model": "mixed", "transition": "fuzzy", "friction": "stribeck"}),
    ("slider_crank", {"model": "mixed", "joints": "C,guide", "drive": "pi", "contact": "hertz"}),
]


@pytest.mark.parametrize(
    ("name", "values"), WRITTEN, ids=[f"{n}-{i}" for i, (n, _) in enumerate(WRITTEN)]
)
def test_a_case_as_a_scene_file(name, values, tmp_path, typed):
    """Written and read back: the same scene, number by number."""
    path = tmp_path / "case.toml"
    words = [word for n, v in values.items() for word in ("-p", f"{n}={v}")]
    typed("new", f"{library()}/{name}.py", *words, "-o", path)
    assert find_case(path).scene().to_json() == cl.load_case(name, **values).to_json()


@pytest.mark.parametrize("make", m.ALL.values(), ids=m.ALL)
def test_a_mechanism_as_a_document_and_as_a_scene_file(make, tmp_path):
    """Each mechanism comes back from both."""
    text = (scene := make()).to_json()
    assert cl.Scene.from_json(text).to_json() == text
    assert case_of(tmp_path, toml_of(scene)).scene().to_json() == text


def test_an_unknown_mechanism_names_all_of_them(tmp_path, monkeypatch, typed):
    """Those of the command itself, and those of cases."""
    monkeypatch.chdir(tmp_path)
    message = typed.line("new togle")
    assert "did you mean toggle?" in message
    assert "six_bar_feeder" in message


OWN = '''"""Laws of a user."""

import clearance as cl


@cl.contact
def liner(penetration, penetration_rate, impact_speed, stiffness):
    """A liner [N]."""
    return stiffness * max(penetration, 0.0)


@cl.spring
def blade(elongation, rate, level):
    """Viscous friction of a blade [N m]."""
    return level * rate
'''


def test_laws_of_a_file_as_toml_and_as_python(tmp_path, monkeypatch, typed):
    """A scene file names them by their file, and a Python case imports them; forces are the same.

    A result runs no laws that it has. A case that cannot import them is refused.
    """
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_laws.py").write_text(OWN)
    mine = '"my_laws.py:liner", stiffness = 1e8'
    blade = (
        '\n[spring]\nS = { kind = "TorsionSpring", a = "ground", b = "crank", moment = BLADE }\n'
    )
    text = FEEDER.replace('"winkler", restitution = 0.9', mine) + blade.replace(
        "BLADE", '{ law = "my_laws.py:blade", level = 0.3 }'
    )
    (tmp_path / "machine.toml").write_text(text)
    typed("new machine.toml --python -o machine.py")
    typed("new machine.py -o again.toml")
    (tmp_path / "sub").mkdir()
    typed("new machine.py -o sub/far.toml")
    for name in ("machine.toml", "machine.py", "again.toml", "sub/far.toml"):
        scene = cl.load_case(name)
        (joint,), (spring,) = scene.clearance_joints, (e for e in scene.loads if e.name == "S")
        assert (joint.contact(2e-6, 0.0, 1.0), spring.moment(0.0, 2.0)) == (200.0, 0.6)
    assert "give -o there" in typed.line("new machine.toml --python -o sub/machine.py")
    typed("run machine.toml --turns 0.05 --no-error -o run.h5")
    assert "laws of my_laws.py in a result are not run" in typed.line("new run.h5 -o result.toml")


def test_a_law_and_an_element_without_a_file_are_refused():
    """A law of a text, and an element of a user: by name, with the way out."""
    names = {"cl": cl}
    exec(OWN, names)
    crank = cl.Body("crank", 1.0, 1e-3)
    spring = cl.TorsionSpring(cl.ground, crank, moment=names["blade"](level=1.0), name="S")
    pivot = cl.Revolute(cl.ground, crank, name="A")
    with pytest.raises(ValueError, match="the law blade has no file: put it into one"):
        toml_of(cl.Scene(pivot, spring))

    class Mine(cl.Revolute):
        """A hinge of a user."""

    with pytest.raises(ValueError, match="M: a scene file has no Mine; keep the Python case"):
        toml_of(cl.Scene(Mine(cl.ground, crank, name="M")))


def test_the_scene_file_of_the_guide(tmp_path):
    """It is a scene, with a length of its own."""
    case = case_of(tmp_path, block("[parameters]", "toml"))
    scene = case.scene(clearance=2e-4)
    assert scene.clearance_joints[0].length == pytest.approx(0.04, rel=1e-15)
    assert (case.name, case.until, scene.turn) == ("machine", 2.0, None)


def test_memberships_and_wear_of_the_guide(tmp_path):
    """The guide's lines of a mixed joint, in the place of the feeder's transition."""
    lines = [line for line in FEEDER.splitlines() if not line.startswith("B.transition")]
    at = lines.index('B.film = "table"')
    printed = ['B.film = "short"', block("fuzzy_table", "toml")]
    text = "\n".join([*lines[:at], *printed, *lines[at + 1 :]])
    text = text.replace('B.length = "20 mm"', 'B.length = "8 mm"')
    (joint,) = case_of(tmp_path, text).scene().clearance_joints
    points = [
        (0.4, 0.0, 0.0, 1.0),
        (0.8, 0.0, 0.7, 0.3),
        (1.2, 0.1, 0.9, 0.0),
        (3.0, 1.0, 0.0, 0.0),
    ]
    assert joint.transition == cl.fuzzy_table(points)
    assert joint.wear.parameters["coefficient"] == pytest.approx(1e-17, rel=1e-12)


def test_the_text_of_a_law_does_not_replace_a_module(monkeypatch):
    """A module of this name that is loaded stays; one that is not loaded is not put there."""
    document = json.loads(cl.load_case("three_loop_chain").to_json())
    (name,) = document["sources"]
    document["sources"][name]["text"] += "\n# another text\n"
    loaded = sys.modules[name]
    scene = cl.Scene.from_json(json.dumps(document))
    assert sys.modules[name] is loaded
    assert scene.drives[0].motion.law.function is not loaded.turning.function
    assert json.loads(scene.to_json()) == document
    monkeypatch.delitem(sys.modules, name)
    document["sources"][name]["text"] += "\n# a third\n"
    cl.Scene.from_json(json.dumps(document))
    assert name not in sys.modules


def test_the_oil_of_a_grade(tmp_path):
    """It is that of `cl.oil`, and a parameter may name another one."""
    text = FEEDER.replace('viscosity = "5 cP"', 'viscosity = "5 cP"\noil = "ISO-VG-46@60C"')
    case = case_of(tmp_path, text.replace('oil = { viscosity = "$viscosity" }', 'oil = "$oil"'))
    for extra, grade, temperature in (({}, "ISO VG 46", 60), ({"oil": "SAE 30@80C"}, "SAE 30", 80)):
        (joint,) = (j for j in case.scene(**extra).joints if j.name == "B")
        assert joint.lubricant == cl.oil(grade, temperature=temperature)


def test_a_material_of_the_file_goes_before_one_of_the_table(tmp_path):
    """Its own numbers count where the table has that name too, and unknown fields are named."""
    path = tmp_path / "own.toml"
    table = '[material]\nsteel = { young = "3 GPa", poisson = 0.4, density = 1400 }\n\n[lubricant]'
    text = FEEDER.replace("[lubricant]", table).replace(
        "B.film =", 'B.material = "steel"\nB.film ='
    )
    path.write_text(text)
    (joint,) = (j for j in cl.load_case(path).joints if j.name == "B")
    assert (joint.material.young, joint.material.name) == (3e9, "steel")
    path.write_text(text.replace("density = 1400", "density = 1400, nonsense = 3"))
    with pytest.raises(ValueError, match="nonsense"):
        cl.load_case(path)
