"""Messages for plausible slips: units, names, laws and scene files."""

import math
import random

import pytest

import clearance as cl
from clearance.scene.catalogue import find_case
from tests.random_scenes import draw


def body(**values):
    return cl.Body("crank", **{"mass": 1.0, "inertia": 0.01, "points": {"A": (0.1, 0.0)}} | values)


def joint(**values):
    numbers = {
        "radius": 0.01,
        "clearance": 1e-4,
        "length": 0.02,
        "contact": cl.hertz(stiffness=1e9),
    }
    return cl.ClearanceRevolute(cl.ground, body()["A"], name="J", **numbers | values)


def oiled(**values):
    numbers = {"contact": None, "film": cl.films.short(), "lubricant": cl.Lubricant(**values)}
    return joint(**numbers)


def slide(**values):
    return cl.Drive(cl.Prismatic(cl.ground, body(), name="guide"), **values)


def doubts(*parts):
    """Warnings of elements and of the bodies that they hold."""
    bodies = {b.name: b for p in parts for b in p.bodies() if b is not cl.ground}
    texts = [t for part in (*bodies.values(), *parts) for t in part.doubts()]
    return [t for t in texts if "usual is" in t]


#: what holds the number; its field, its unit, the unit that it was given in, usual numbers in that
SLIPS = [
    (lambda **n: oiled(**n), "viscosity", "Pa s", "cP", (12.0, 3000.0)),
    (lambda **n: joint(**n, clearance=1e-5), "radius", "m", "mm", (6.0, 2000.0)),
    (lambda **n: joint(**n, radius=4.9), "clearance", "m", "mm", (0.04, 4.0)),
    (lambda **n: joint(**n), "length", "m", "mm", (6.0, 2000.0)),
    (lambda **n: joint(**n), "roughness", "m", "um", (0.2, 5.0)),
    (lambda **n: cl.Drive(body(), **n), "speed", "rad/s", "rpm", (1001.0, 9500.0)),
    (lambda **n: cl.Drive(body(), torque=1.0, **n), "nominal", "rad/s", "rpm", (1001.0, 9500.0)),
    (lambda **n: slide(**n), "speed", "m/s", "mm/s", (101.0, 9e4)),
    (lambda **n: cl.Drive(body(**n), speed=1.0), "mass", "kg", "g", (1.1e6, 9e8)),
    (
        lambda **n: joint(material=cl.Material("bronze", poisson=0.3, density=8800.0, **n)),
        "young",
        "Pa",
        "GPa",
        (50.0, 400.0),
    ),
]
NAMES = [f"{field} in {other}" for _, field, _, other, _ in SLIPS]


@pytest.mark.parametrize(("element", "field", "unit", "other", "bounds"), SLIPS, ids=NAMES)
def test_users16_a_number_in_another_unit_is_doubted(element, field, unit, other, bounds):
    """Field, value, unit, and the unit meant, at a hundred numbers; none for the right number."""
    rng = random.Random(field)
    for _ in range(100):
        value = math.exp(rng.uniform(*map(math.log, bounds)))
        texts = doubts(element(**{field: value}))
        wanted = f"{field} is {value:g} {unit}, usual is "
        assert any(wanted in t and t.endswith(f"; {value:g} {other}?") for t in texts), texts
        assert doubts(element(**{field: f"{value!r} {other}"})) == []


@pytest.mark.parametrize(("element", "field"), [slip[:2] for slip in SLIPS], ids=NAMES)
def test_users16_a_text_has_its_unit(element, field):
    """As in scene files; another kind of unit is refused with the field."""
    with pytest.raises(ValueError, match=f"{field}: '3 K' is in K, expected"):
        element(**{field: "3 K"})
    with pytest.raises(ValueError, match=f"{field}: 'much' is not a number with"):
        element(**{field: "much"})


def test_texts_of_vectors_and_of_parameters():
    """Texts with units are the numbers that they name."""
    rng = random.Random(0)
    for _ in range(100):
        x, speed = rng.uniform(1.0, 999.0), rng.uniform(1.0, 999.0)
        rod = body(points={"A": (f"{x!r} mm", 0.0)}, com=["0.1 cm", f"{x!r} um"])
        assert rod.points["A"] == (cl.mm(x), 0.0)
        assert rod.com == (0.001, cl.um(x))
        scene = cl.load_case("slider_crank", speed=f"{speed!r} rpm")
        assert scene.parameters["speed"] == cl.rpm(speed)
    with pytest.raises(ValueError, match="speed: '3 kg' is in kg"):
        cl.load_case("slider_crank", speed="3 kg")


def test_far_points_are_doubted():
    """A point 150 m away is answered with the likely unit."""
    assert doubts(cl.Drive(body(points={"A": (150.0, 0.0)}), speed=1.0)) == [
        "body crank: point 'A' is 150 m, usual is up to 100; 150 mm?"
    ]


def test_a_run_warns():
    """Once, though two joints have the oil."""
    oil = cl.Lubricant(viscosity=50)
    film = {"radius": 0.01, "clearance": 1e-4, "length": 0.01, "film": cl.films.short()}
    first = body()
    second = cl.Body("rod", mass=1.0, inertia=0.01, points={"B": (0.1, 0.0)})
    one = cl.ClearanceRevolute(cl.ground, first["A"], lubricant=oil, **film)
    two = cl.ClearanceRevolute(first, second["B"], lubricant=oil, **film)
    with pytest.warns(cl.RunWarning, match="viscosity is 50 Pa s") as issued:
        cl.simulate(cl.Scene(one, two), until=1e-4)
    assert str(issued[0].message).count("; 50 cP?") == 1


def test_no_case_and_no_random_scene_is_doubted():
    """But those whose oil has more than 10 Pa s, which no oil has."""
    names = [
        "double_pendulum",
        "five_axis_chain",
        "four_bar",
        "four_bar_clearances",
        "guide_slider",
    ]
    names += ["mobile_manipulator", "six_bar_feeder", "slider_crank", "three_loop_chain", "wear_a"]
    scenes = [*map(cl.load_case, names), *(draw(seed).scene for seed in range(100))]
    for scene in scenes:
        for part in (*scene.bodies, *scene.elements):
            oil = getattr(part, "lubricant", None)
            usual = [t for t in part.doubts() if "usual is" in t]
            assert len(usual) == (oil is not None and oil.viscosity > 10.0), usual


@cl.contact
def bare(penetration, penetration_rate, impact_speed, k, n):
    """A power of a negative number outside contact."""
    return k * penetration**n


@cl.contact
def holed(penetration, penetration_rate, impact_speed, k):
    """No value once the journal enters."""
    return k * (-penetration) ** 0.5 if penetration > 0.0 else 0.0


def swept(**options):
    return cl.sweep("slider_crank", cl.grid(**options.pop("points")), "nowhere", **options)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: cl.Prismatic(cl.ground, body(), axis=(0, 0)), "axis must not be zero"),
        (lambda: joint(clearance=0.06), r"J: clearance 0\.06 m must be smaller .*; 0\.06 mm\?"),
        (lambda: cl.ClearanceRevolute(cl.ground, body()["A"], radius=0.1), "needs clearance"),
        (lambda: cl.hunt_crossley(2.5, restitution=0.5), r"its parameters: stiffness=2\.5"),
        (lambda: cl.hertzian, r"did you mean hertz\?"),
        (lambda: cl.laws.coulom, r"did you mean coulomb\?"),
        (lambda: cl.elements.Drives, r"did you mean Drive\?"),
        (lambda: cl.films.shot, r"did you mean short\?"),
        (lambda: body()["a"], r"did you mean A\?"),
        (lambda: cl.Body.bar("p", {"A": 0, "B": 1}, 0.1, material="bronz"), r"mean bronze\?"),
        (lambda: cl.Body.bar("p", {"A": 0, "B": 1}, 0.1, material=7800), "must be a Material"),
        (lambda: body(inertia="3 kg mm^2s"), r"unknown unit 'kgmm2s'"),
        (lambda: cl.fit("four_bar", [[0.0, 1.0]] * 9, {"speed": "1:2"}, "x"), "a CSV file"),
        (lambda: cl.fit("four_bar", "a.csv", ["speed"], "x"), "bounds by name"),
        (lambda: cl.fit("four_bar", "a.csv", {"speed": 3.0}, "x"), "needs two bounds"),
        (lambda: cl.optimize("four_bar", ["speed"], minimize="loss_mean"), "bounds by name"),
        (lambda: swept(points={"spead": [1.0]}), r"'spead' \(did you mean speed\?\)"),
        (lambda: swept(points={"speed": [1.0]}, turn=3), r"'turn' \(did you mean turns\?\)"),
        (lambda: swept(points={"clearance": [1e-4]}, spead=3), r"speed\?\): parameters stand in"),
        (
            lambda: cl.simulate(cl.Scene(joint(contact=holed(k=1e9))), until=1.0),
            "the law holed has no value there",
        ),
    ],
)
def test_users22_messages_say_what_is_meant(call, words):
    """Each slip has a message with the remedy."""
    with pytest.raises(Exception, match=words):
        call()


def test_signs_of_powers_in_units():
    """With and without the sign of the power, random numbers: to the bit."""
    rng = random.Random(4)
    for _ in range(20):
        number = rng.uniform(1e-3, 1e3)
        one, other = (body(inertia=f"{number} {u}").inertia for u in ("kg mm^2", "kg mm2"))
        assert one == other == body(inertia=f"{number} kg*mm²").inertia


def test_an_unknown_metric_names_the_closest_one():
    """By either spelling, with a letter more or less anywhere in the name."""
    metrics = cl.simulate(cl.load_case("four_bar", model="ideal"), turns=1, error=None).metrics()
    rng = random.Random(7)
    for name in ("joint_A_force_max", "joints/A/force_max", "drives/crank/torque_rms"):
        for _ in range(5):
            at = rng.randrange(len(name) - 4, len(name))
            with pytest.raises(KeyError, match=r"did you mean (joint_A_force|drive_crank_torque)_"):
                metrics[name[:at] + rng.choice(["", "y"]) + name[at + 1 :]]


def test_a_result_is_not_saved_as_a_directory(tmp_path):
    """Of memory and of a file: the name, and nothing of a temporary one."""
    run = cl.simulate(cl.load_case("four_bar", model="ideal"), turns=0.1, error=None)
    stored = cl.open_result(run.save(tmp_path / "run.h5"))
    for result in (run, stored):
        with pytest.raises(ValueError, match=r"is a directory; give the name of a file") as refused:
            result.save(tmp_path)
        assert "partial" not in str(refused.value)
    stored.close()


def test_a_power_outside_contact_names_the_law():
    """Any exponent that is not an integer."""
    rng = random.Random(1)
    for _ in range(100):
        with pytest.raises(ValueError, match=r"contact bare: no value .* max\(penetration, 0"):
            bare(k=10 ** rng.uniform(3.0, 11.0), n=rng.randrange(1, 4) + rng.uniform(0.05, 0.95))


FILE = """\
[body.rod]
mass = 1.0
inertia = 0.1
points = { A = [0.1, 0.0] }
[drive.turning]
target = "rod"
torque = 0.0
nominal = 10.0
[joint.R]
kind = "ClearanceRevolute"
a = "ground"
b = "rod.A"
radius = 0.01
clearance = 1e-4
length = 0.01
contact = { law = "hunt_crossley", stiffness = 1e9, restitution = 0.9 }
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("clearance = 1e-4", "clearance = 0.06", r":14: joint\.R\.clearance: .*; 0\.06 mm\?"),
        ("length = 0.01", "radius = 0.02", ":15: radius stands there twice"),
        ("length = 0.01", "[joint.R]", r":15: \[joint\.R\] stands there twice"),
        (", restitution = 0.9", "", r":16: joint\.R\.contact: .*missing restitution"),
        ("stiffness = 1e9,", "stiffness = 1e9, los = 2,", r"joint\.R\.contact\.los: .*unknown los"),
        ("stiffness = 1e9,", "stifness = 1e9,", r"contact\.stifness: .*mean stiffness"),
        ("clearance = 1e-4", "", r":9: joint\.R: ClearanceRevolute needs clearance"),
    ],
)
def test_users22_messages_of_a_scene_file(old, new, words, tmp_path):
    """File, line and field; blank lines above move the line."""
    rng = random.Random(old + new)
    path = tmp_path / "my.toml"
    for blank in [0, *(rng.randrange(1, 40) for _ in range(5))]:
        path.write_text(blank * "\n" + FILE.replace(old, new))
        with pytest.raises(ValueError, match="my.toml") as refused:
            find_case(str(path)).scene()
        text, line = str(refused.value), words.partition(":")[2].partition(":")[0]
        if line.isdigit():
            moved = words.replace(f":{line}:", f":{int(line) + blank}:", 1)
            refused.match(moved)
        else:
            refused.match(words)
        assert "\n" not in text


@pytest.mark.parametrize("suffix", [".toml", ".py"])
def test_users23_a_life_without_wear_proposes_what_the_author_can_write(suffix, tmp_path):
    """A law of a scene file, taken literally; one of Python."""
    path = tmp_path / f"my{suffix}"
    text = FILE.replace('{ law = "hunt_crossley", stiffness = 1e9, restitution = 0.9 }', "WINKLER")
    text = text.replace("WINKLER", '{ law = "winkler" }')
    python = "import clearance as cl\ndef scene():\n    return cl.load_case('four_bar')\n"
    path.write_text(text if suffix == ".toml" else python)
    with pytest.raises(ValueError, match="give wear, such as") as refused:
        cl.wear(str(path), turns=10.0, directory=tmp_path / "life")
    advice = str(refused.value).partition("such as ")[2]
    if suffix == ".py":
        assert eval(advice.removeprefix("wear="), {"cl": cl}).law.name == "archard"
        return
    path.write_text(text + advice.removesuffix(" in its table") + "\n")
    assert find_case(str(path)).scene().clearance_joints[0].wear.law.name == "archard"
