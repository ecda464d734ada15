"""Reports: complete HTML that needs nothing else, states what the file states, and what it cannot
show.
"""

import dataclasses
import hashlib
import json
import math
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import h5py
import numpy as np
import pytest
from clearance.postprocess import figures, pages, scenes, sweep_report
from clearance.postprocess.report import report

import clearance as cl
from clearance.commands.report import default
from clearance.laws.joint_friction import breakaway_linear, joint_stribeck
from clearance.metrics.metrics import metrics, startup
from tests.postprocess.records import plain
from tests.postprocess.test_efforts import cart

VOID = {"meta", "img", "wbr"}
OWN = '''
import clearance as cl

def scene(*, speed: float = 30.0, mode: str = "<a>") -> cl.Scene:
    """A crank that some speeds are too much for.

    speed: crank speed [rad/s]
    mode: a text [-]
    """
    if speed > 35.0:
        raise ValueError(f"speed: {speed:g} > 35 & more")
    return cl.load_case("slider_crank", speed=speed, model="dry")
'''


class Reader(HTMLParser):
    """Content of a page.

    Every element must be closed in its place, ids must be single, resources in the page.
    """

    def __init__(self, path):
        super().__init__()
        self.open, self.texts, self.rows, self.cells = [], [], [], []
        self.links, self.sources, self.ids, self.uses, self.captions = [], [], [], [], []
        self.headings, self.boxes, self.missing, self.pictures = [], [], [], []
        self.folder, self.raw = Path(path).parent, Path(path).read_text(encoding="utf-8")
        self.feed(self.raw)
        self.close()
        assert self.raw.startswith("<!DOCTYPE html>")
        assert not self.open, f"not closed: {self.open}"
        assert len(self.ids) == len(set(self.ids)), "an id stands twice"
        assert set(self.uses) <= set(self.ids), "something refers to what is not there"
        assert all(s.startswith("data:") for s in self.sources), "a resource is outside the page"
        assert "://" not in self.raw
        assert all(self.captions), "a picture says nothing"

    @property
    def text(self):
        return "".join(self.texts)

    def row(self, *wanted):
        """The one row with cells of these words."""
        page = [r for r in self.rows if set(wanted) <= set(r)]
        assert len(page) == 1, (wanted, page)
        return page[0]

    def handle_starttag(self, tag, attrs):
        self.handle_startendtag(tag, attrs)
        if tag not in VOID:
            self.open.append((tag, dict(attrs).get("class") or ""))
        if tag == "tr":
            self.cells = []
        elif tag in ("td", "th"):
            self.cells.append("")

    def handle_startendtag(self, tag, attrs):
        page = {name: value or "" for name, value in attrs}
        self.ids += [page["id"]] if "id" in page else []
        link = page.get("href", "")
        if link.startswith("#"):
            self.uses.append(link[1:])
        elif link:
            (self.links if tag == "a" else self.sources).append(unquote(link))
        self.uses += [u for v in page.values() for u in re.findall(r"url\(#([^)]+)\)", v)]
        self.sources += [page["src"]] if "src" in page else []
        if tag in ("svg", "img"):
            self.pictures.append(tag)
            self.captions.append(page.get("alt" if tag == "img" else "aria-label"))

    def handle_endtag(self, tag):
        assert tag == self.open[-1][0], f"{tag} ends while {self.open[-1][0]} is open"
        self.open.pop()
        if tag == "tr":
            self.rows.append(tuple(self.cells))

    def handle_data(self, data):
        tags, data = [tag for tag, _ in self.open], plain(data)
        if {"style", "script", "svg"} & set(tags):
            return
        self.texts.append(data)
        if {"td", "th"} & set(tags):
            self.cells[-1] += data
        kinds = {kind for _, kind in self.open}
        self.headings += [data] if "h2" in tags else []
        self.missing += [data] if "missing" in kinds else []
        self.boxes += [(kind, data) for kind in kinds if kind.startswith("box")]


def read(source, tmp_path) -> Reader:
    """The page of a run or a sweep."""
    return Reader(report(source, tmp_path / "report.html"))


def ran(case, tmp_path, *, span=1.0, parameters=None, **options) -> tuple:
    """A run of a case over some turns, and its page."""
    scene = cl.load_case(case, **parameters or {})
    run = cl.simulate(scene, **{"turns" if scene.turn else "until": span}, **options)
    return run, read(run, tmp_path)


def measured(value, units) -> tuple:
    """Number and unit as pages have them."""
    return tuple(map(plain, pages.measured(value, units)))


def words(scene) -> str:
    """The description and the tables of a scene, a bar in place of tags."""
    return plain(re.sub(r"(<[^>]*>)+", "|", scenes.described(scene) + scenes.tables(scene)))


@pytest.fixture(scope="module")
def feeder(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "feeder.h5"
    cl.simulate(cl.load_case("six_bar_feeder", joints="B,C"), turns=5.0, path=path)
    return path


@pytest.fixture(scope="module")
def page(feeder, tmp_path_factory):
    return Reader(report(feeder, tmp_path_factory.mktemp("page") / "feeder.html"))


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Two of six points fail; texts and reasons hold what HTML must not."""
    folder = tmp_path_factory.mktemp("a & b")
    (folder / "own.py").write_text(OWN)
    points = cl.grid(speed=[20.0, 30.0, 40.0], mode=['<b> & "c"', "plain"])
    return cl.sweep(
        folder / "own.py", points, folder / "map <1>", turns=2.0, samples_per_turn=50, workers=1
    )


@pytest.fixture(scope="module")
def swept_page(swept, tmp_path_factory):
    return Reader(report(swept, tmp_path_factory.mktemp("page") / "sub" / "sweep.html"))


# --- pieces of a page
@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (1.234567, "1.2346"),
        (-0.00012345678, "−0.00012346"),
        (1.5e-7, "1.5 × 10⁻⁷"),
        (123456.0, "123456"),
        (-1234567.0, "−1.2346 × 10⁶"),
        (math.nan, "–"),
        (math.inf, "∞"),
        (-math.inf, "−∞"),
        (12345678, "12345678"),
        (-0.0, "0"),
        (np.int64(-7), "−7"),
        (99999.6, "1 × 10⁵"),
    ],
)
def test_numbers(value, shown):
    """Five digits, powers of ten as people write them, a dash for none."""
    assert plain(pages.number(value)) == shown


@pytest.mark.parametrize(
    ("value", "units", "shown"),
    [
        (1e-4, "m", "0.1 mm"),
        (6.4e-6, "m", "6.4 µm"),
        (0.0, "m", "0 m"),
        (31.41592653589793, "rad/s", "300 rpm"),
        (0.5, "1", "0.5"),
        (2.5, "furlong", "2.5 furlong"),
        (math.pi, "rad", "180°"),
        (3.14e-5, "kg m2", "31.4 kg mm²"),
        (207e9, "Pa", "207 GPa"),
        (0.05, "Pa s", "50 mPa s"),
        (2e-9, "s", "2 ns"),
        (math.nan, "N", "– N"),
    ],
)
def test_quantities(value, units, shown):
    """Units have the prefix that suits the value; speeds are in rpm, angles in degrees."""
    assert plain(pages.quantity(value, units)) == shown


def test_everything_is_escaped_on_its_way_in():
    """Texts, attributes and cells hold no markup."""
    text = pages.element("p", '<b> & "', pages.element("i", "x"), title='"<')
    assert text == '<p title="&quot;&lt;">&lt;b&gt; &amp; &quot;<i>x</i></p>'
    assert pages.table(["<"], [["<", True, None]], says="<").count("&lt;") == 3


def picture(tmp_path, points, samples=0):
    """A page with one picture of a line of random points, drawn as the page sees fit."""

    def draw(path):
        figure = figures.sheet(3.0, 2.0)
        figure.add_subplot().plot(*np.random.default_rng(1).random((2, points)), lw=0.5)
        return figures.save(figure, path, dpi=50)

    document = pages.Page("a picture")
    document.section(
        "one",
        document.picture(draw, "random <points>", samples),
        document.picture(draw, "again", samples),
    )
    return Reader(document.save(tmp_path / "picture.html"))


def test_large_pictures_are_png_where_that_is_smaller(tmp_path, monkeypatch):
    """A few points are drawn as lines, and only once; many and long ones as pixels."""
    drawn, once = [], figures.drawn_once
    monkeypatch.setattr(figures, "drawn_once", lambda *a: drawn.append(a[-1]) or once(*a))
    assert picture(tmp_path, 10).pictures == ["svg", "svg"]
    assert drawn == ["svg", "svg"]
    assert picture(tmp_path, 20000).pictures == ["img", "img"]
    page = picture(tmp_path, 10, samples=pages.LONG)
    assert page.pictures == ["img", "img"]
    assert page.captions == ["random <points>", "again"]
    assert all(s.startswith("data:image/png;base64,iVBORw0KGgo") for s in page.sources)


def test_svg_becomes_part_of_the_page():
    """Identifiers are those of the page, and metadata, comments and styles are gone."""
    svg = """<?xml version="1.0"?><svg xmlns:xlink="http://x" width="9pt" viewBox="0 0 9 9">\
<!-- <p> --><metadata>m</metadata><defs><style type="text/css">*{a: b}</style></defs>\
<g id="unused"><path id="m1"/><use xlink:href="#m1" style="fill: url(#c2)"/></g>\
<clipPath id="c2"/></svg>"""
    expected = """<svg role="img" aria-label="&quot;a&quot;" width="9pt" viewBox="0 0 9 9">\
<defs></defs><g><path id="p3-0"/><use href="#p3-0" style="fill: url(#p3-1)"/></g>\
<clipPath id="p3-1"/></svg>"""
    assert pages.inline(svg, "p3", '"a"') == expected


def test_a_picture_that_cannot_be_drawn_is_a_sentence():
    """The reason stands in its place."""

    def draw(path):
        raise ValueError("channel <x> was not stored")

    text = pages.Page("none").picture(draw, "Something")
    reason = "Something: not shown, for channel &lt;x&gt; was not stored."
    assert text == f'<p class="missing">{reason}</p>'


# --- runs
def test_the_numbers_of_a_run(page, feeder):
    """All metrics, solver statistics and digests are those of the file."""
    run = cl.open_result(feeder)
    for name, metric in metrics(run).items():
        assert page.row(metric.text, name)[1:3] == measured(metric.value, metric.units)
    assert page.row("steps")[1] == f"{run.solver['steps']}, {run.solver['rejected']} rejected"
    assert page.row("method")[1] == f"{run.solver['method']} ({run.solver['method_reason']})"
    residual = plain(pages.number(run.solver["energy_residual_share"]))
    assert residual in page.row("energy residual")[1]
    first = startup(run)["joint_C_force_max"]
    shown = page.row("largest force in joint C", "joint_C_force_max")[4]
    assert shown == " ".join(measured(first.value, first.units))
    kernel = hashlib.sha256(run.attributes["kernel"].encode()).hexdigest()
    assert page.row("kernel")[1] == f"sha256 {kernel}"
    assert page.row("version of numba")[1] == run.attributes["version_numba"]
    assert ("box good", "complete") in page.boxes


def test_what_a_run_report_shows(page):
    """The sections, their pictures, and the joint's options."""
    assert page.headings == [
        "Mechanism",
        "Integration",
        "Summary",
        "Overview",
        "Joint B",
        "Joint C",
        "Is it rigid? Is the film?",
        "Motion in phase space",
        "Spectrum",
        "Provenance",
    ]
    assert len(page.pictures) == 7  # sketch, overview, two journals, portraits, section, spectrum
    assert not page.missing
    assert "driven at constant speed, 300 rpm (31.416 rad/s)" in page.text
    assert page.row("crank", "31.4")[:3] == ("crank", "0.0942", "31.4")
    assert page.row("radius") == ("radius", "10 mm", "10 mm")
    assert page.row("film")[1].startswith("table: cavitation reynolds")


def test_the_size_of_a_feeder_report(page):
    """Two joints and five turns with 400 samples each, as commands keep them."""
    assert len(page.raw.encode()) < 2e6


def partial(tmp_path, max_steps):
    """A dry run that ended at its step limit, and its page."""
    with pytest.raises(cl.SimulationError, match="the step limit is reached") as stop:
        cl.simulate(cl.load_case("slider_crank", model="dry"), turns=2.0, max_steps=max_steps)
    return stop.value.result, read(stop.value.result, tmp_path)


@pytest.mark.usefixtures("undrawn")
def test_a_partial_run(tmp_path):
    """The box has the reason; what was computed is shown."""
    run, page = partial(tmp_path, 300)
    assert ("box bad", "partial") in page.boxes
    assert ("box bad", f": {run.status.removeprefix('partial: ')}") in page.boxes
    assert page.row("contacts")[1] == str(len(run.events["time"]))
    assert any("A Poincaré section is drawn from 5 turns on" in m for m in page.missing)


def test_a_run_that_ended_at_once(tmp_path):
    """Sentences stand in place of numbers and pictures."""
    _, page = partial(tmp_path, 1)
    assert not page.pictures
    assert "The run ended before there was anything to sum up." in page.missing
    assert sum("fewer than two samples" in m for m in page.missing) == 4


def test_a_run_that_has_not_ended(feeder, tmp_path):
    """It is refused with its status."""
    shutil.copy(feeder, tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "a") as file:
        file.attrs["status"] = "partial: still running"
        del file.attrs["status_crc32"]
        for name in list(file["solver"].attrs):
            del file["solver"].attrs[name]
    reason = "run.h5 has no summary, for its run has not ended .partial: still running"
    with pytest.raises(ValueError, match=reason):
        report(tmp_path / "run.h5", tmp_path / "r.html")


@pytest.mark.usefixtures("undrawn")
def test_what_was_not_kept_is_said(tmp_path):
    """Extremes without their channels, and sentences that name what is missing."""
    stored = ["bodies/slider/ax", "joints/B/gap"]
    run, page = ran("six_bar_feeder", tmp_path, span=2.0, channels=stored)
    low, high = (pages.number(v) for v in run.extremes("bodies/slider/ax"))
    assert page.row("bodies/slider/ax")[1:] == ("m/s²", low, high)
    message, absent = " ".join(page.missing), "these channels were not stored"
    assert "no channel 'bodies/slider/x'" in message
    assert f"{absent}: bodies/slider/ay, bodies/slider/theta, joints/A/force_x" in message
    assert f"{absent}: joints/B/eccentricity_x, joints/B/eccentricity_y" in message
    assert len(page.pictures) == 2  # what was stored, and its spectrum


@pytest.mark.usefixtures("undrawn")
def test_no_channels_at_all(tmp_path):
    """A run without ledger and without channels of bodies."""
    _, page = ran("six_bar_feeder", tmp_path, channels=["energy/kinetic"], energy=False)
    assert page.row("energy residual")[1] == "no energy ledger was stored or integrated"
    assert "its channels ax and ay were not stored" in " ".join(page.missing)


@pytest.mark.usefixtures("undrawn")
def test_ideal_joints(tmp_path):
    """They have no section of their own."""
    _, page = ran("six_bar_feeder", tmp_path, parameters={"model": "ideal"})
    assert not [h for h in page.headings if h.startswith("Joint")]
    assert page.row("absolute tolerances")[1] != "–"


@pytest.mark.usefixtures("undrawn")
def test_no_drive(tmp_path):
    """The report has a sentence about that, and no section."""
    _, page = ran("double_pendulum", tmp_path, span=0.5)
    assert "2 bodies, 2 hinges (A, B); nothing drives it. Gravity is (0, −9.81) m/s²." in page.text
    assert page.missing == ["No drive turns at constant speed: there is no Poincaré section."]


@pytest.mark.usefixtures("undrawn")
def test_dry_and_mixed_contacts(tmp_path):
    """Peak forces and laws of a dry joint; warnings and dry share of a mixed one."""
    dry, page = ran("slider_crank", tmp_path, parameters={"model": "dry"}, samples_per_turn=100)
    shown = plain(pages.number(dry.events["peak_force"].max()))
    assert page.row("largest peak force")[1] == f"{shown} N"
    law = "lankarani_nikravesh: stiffness 6.6102 × 10¹⁰ N/m^1.5, restitution 0.9"
    assert page.row("contact")[1].startswith(law)
    thin = {"model": "mixed", "viscosity": 0.002, "speed": cl.rpm(600), "elastic": "false"}
    mixed, page = ran("six_bar_feeder", tmp_path, parameters=thin, samples_per_turn=100)
    assert mixed.warnings
    assert all(("box doubt", w) in page.boxes for w in mixed.warnings)
    share = pages.number(mixed.facts("joints/B")["share_dry"])
    assert page.row("share of the time in dry contact")[1] == share
    assert any("film thickness ratio, states" in s for s in page.captions)


@pytest.mark.usefixtures("undrawn")
def test_names_and_warnings_are_escaped(tmp_path):
    """Names of files, points and warnings hold no markup."""
    path = tmp_path / "<i>a & 'b'.h5"
    cl.simulate(cl.load_case("double_pendulum"), until=0.2, path=path)
    with h5py.File(path, "a") as file:
        file.attrs.create("warnings", ["<script>alert(1)</script>"], dtype=h5py.string_dtype())
        file.attrs["scene"] = file.attrs["scene"].replace('"points": {"top"', '"points": {"<b>&"')
        del file.attrs["scene_crc32"], file.attrs["warnings_crc32"]
    page = read(path, tmp_path)
    assert ("box doubt", "<script>alert(1)</script>") in page.boxes
    assert page.row("file")[1] == path.name
    assert page.row("upper", "<b>& (−250, 0); end (250, 0)")
    assert "cl.open_result(\"<i>a & 'b'.h5\")" in page.text


def test_parts_of_a_scene_in_words():
    """Springs, forces, drives and joints with their numbers in units."""

    @cl.signal
    def push(time, amplitude):
        return amplitude * time

    block = cl.Body(
        "block",
        mass=2.0,
        inertia=0.01,
        points={"p": (0.05, 0.0), "q": (-0.05, 0.0)},
        velocity=(0.1, 0.0),
    )
    bar = cl.Body("bar", mass=1.0, inertia=0.01, points={"a": (0.0, 0.0), "b": (0.3, 0.0)})
    law = cl.kelvin_voigt(stiffness=1e7, damping=5.0)
    dry = cl.ClearanceRevolute(
        block["q"], bar["a"], name="pivot", radius=0.01, clearance=1e-4, contact=law
    )
    rail = cl.Prismatic(cl.ground.at(0, 0), block["p"], axis=(0.0, 1.0), name="rail")
    loads = (
        cl.SpringDamper(
            cl.ground.at(-0.3, 0), block["q"], stiffness=1e3, damping=3.0, free_length=0.2, name="s"
        ),
        cl.TorsionSpring(block, bar, stiffness=2.0, name="t"),
        cl.Force(bar["b"], x=push(amplitude=2.0), name="f"),
        cl.Drive(rail, speed=0.05, start=0.1),
    )
    scene = cl.simulate(cl.Scene(rail, dry, *loads, name="parts"), until=1e-3, samples=3).scene
    text = words(scene)
    for message in (
        "joint rail is driven at constant speed, 50 mm/s, from 100 mm",
        "spring and damper s, torsion spring t, force f",
        "|kelvin_voigt: stiffness 1 × 10⁷ N/m, damping 5 N s/m|",
        "|ground (−300, 0) to block q (−50, 0)|",
        "|stiffness 1000 N/m, damping 3 N s/m, free length 200 mm|",
        "|stiffness 2 N m/rad, damping 0 N m s/rad, free angle 0°|",
        "|x push: amplitude 2, y 0 N|",
        "|axis (0, 1) of ground|",
        "velocity 0.1 m/s, 0 m/s",
    ):
        assert message in text


def test_scenes_out_of_the_plane_and_joints_that_rub_in_words():
    """Rates and coefficients of a law have the units of the joint that it stands in."""

    @cl.signal
    def swing(time, amplitude):
        return amplitude * time

    levels = {"breakaway": 25.0, "coulomb": 20.0, "viscous": 2.0, "decay": 10.0, "threshold": 1e-4}
    stribeck = joint_stribeck(
        static=0.3, kinetic=0.1, stribeck_rate=0.2, load_viscous=0.05, transition_rate=1e-3
    )
    arm = cl.Body(
        "arm",
        1.0,
        0.02,
        points={"far": (0.4, 0.0, 0.03)},
        com=(0.2, 0.0, 0.01),
        products=(1e-3, 0.0),
    )
    box, tip = cl.Body("box", 1.0, 0.02), cl.Body("tip", 1.0, 0.02)
    hinge = cl.Revolute(
        cl.ground.at(0.0, 0.1, 0.02),
        arm,
        name="O",
        friction=stribeck,
        pin_radius=0.01,
        friction_arm=0.02,
        bending_arm=0.05,
    )
    combined = breakaway_linear(**levels)
    pin = cl.Revolute(arm["far"], box, name="P", friction=combined, self_aligning=True)
    slide = cl.Prismatic(box, tip, name="S", friction=combined, overlap=0.06)
    more = cl.Prismatic(
        cl.ground, cl.Body("more", 1.0, 0.02), name="T", friction=combined, overlap=0.06
    )
    drives = [
        cl.Drive(j, motion=swing(amplitude=0.1), name=j.name) for j in (hinge, pin, slide, more)
    ]
    force = cl.Force(arm["far"], x=1.0, z=-2.0, name="push")
    parts = cl.Scene(
        hinge, pin, slide, more, *drives, force, gravity=(0.0, 0.0, -9.81), name="parts"
    )
    text = words(json.loads(parts.to_json()))
    for message in (
        "Friction acts in O, P, S, T. Gravity is (0, 0, −9.81) m/s².",
        "|products xz, yz [kg m²]|",
        "|arm|1|0.02|(0.001, 0)|(200, 0, 10)|far (400, 0, 30)|",
        "|box|1|0.02|(0, 0)|",
        "|ground (0, 100, 20)|",
        "|x 1 N, y 0 N, z −2 N|",
        "|self-aligning|",
        "|hinge O|hinge P|slides S, T|",
        "|joint_stribeck: static 0.3, kinetic 0.1, stribeck rate 0.2 rad/s, exponent 2, viscous 0 "
        "N m s/rad, "
        "load viscous 0.05 s/rad, transition rate 0.001 rad/s|",
        "|breakaway_linear: breakaway 25 N m, coulomb 20 N m, viscous 2 N m s/rad, decay 10 s/rad, "
        "threshold 0.0001 rad/s|",
        "|breakaway_linear: breakaway 25 N, coulomb 20 N, viscous 2 N s/m, decay 10 s/m, threshold "
        "0.0001 m/s|",
        "|pin radius|10 mm|",
        "|overlap|60 mm|",
        "|friction arm|20 mm|",
        "|bending arm|50 mm|",
        "|self-aligning|no|yes|no|",
    ):
        assert message in text
    flat = words(json.loads(cl.load_case("double_pendulum").to_json()))
    assert not re.search("products|Friction", flat)


def test_friction_laws_of_ones_own_have_no_units():
    """Numbers of an unknown law stand alone."""
    law = {"law": "mine:rubbing", "viscous": 2.0}
    joint = {"type": "Revolute", "name": "A", "friction": law}
    text = re.sub(r"(<[^>]*>)+", "|", scenes.frictions([joint]))
    assert "|rubbing: viscous 2|" in text


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("inverse", [False, True])
def test_joints_that_rub(inverse, tmp_path):
    """Efforts and friction have a section, of inverse dynamics too."""
    compute = cl.inverse_dynamics if inverse else cl.simulate
    run = compute(cart(), until=2.0, samples=101, path=tmp_path / "run.h5")
    page = read(run, tmp_path)
    how = "Computation" if inverse else "Integration"
    assert page.headings[1:5] == [how, "Summary", "Overview", "Efforts and joint friction"]
    assert page.missing == ["A Poincaré section is drawn from 5 turns on; this run has 1.2732."]
    for start in (
        "Driving torques and forces, dashed without joint friction",
        "Friction of hinges and slides",
    ):
        assert any(s.startswith(start) for s in page.captions)
    assert ("method", run.solver["method"]) in page.rows or not inverse


# --- sweeps
def test_a_sweep_with_failed_points(swept_page):
    """Its table has the reasons; parameters stand as they were swept."""
    page = swept_page
    assert ("box bad", ": 4 done, 2 failed") in page.boxes
    assert "Points that are not done" in page.headings
    bad = page.row("4", 'speed 381.97 rpm, mode <b> & "c"', "failed")
    assert "speed: 40 > 35 & more" in bad[3]
    assert page.row("speed", "by even steps")[1:4] == (
        "3",
        "190.99 rpm, 286.48 rpm, 381.97 rpm",
        "20, 30, 40 rad/s",
    )
    assert page.row("mode", "listed")[2] == '<b> & "c", plain'
    assert len(page.pictures) == 3  # maps, curves, cost
    points = [r for r in page.rows if len(r) > 6 and r[0].isdigit()]
    assert [r[3] for r in points] == ["done"] * 4 + ["failed"] * 2
    assert points[4][4:-2] == ("–",) * len(points[4][4:-2])


def test_extremes_of_a_sweep(swept, swept_page):
    """Least and largest value of each metric, and where it is."""
    for name in (
        "slider_acceleration_peak_mean",
        "joint_C_force_peak_mean",
        "joint_C_penetration_peak_mean",
    ):
        values = np.where(swept.done, swept.metrics[name], np.nan)
        unit, factor = pages.scaled(swept.known[name][0], np.nanmin(values), np.nanmax(values))
        row = next(r for r in swept_page.rows if r[0].endswith(name))
        least, most = (pages.number(v * factor) for v in (np.nanmin(values), np.nanmax(values)))
        assert row[:5] == (f"{swept.known[name][1]} {name}", unit, least, row[3], most)
        speed = plain(pages.quantity(swept.columns["speed"][np.nanargmax(values)], "rad/s"))
        assert f"speed {speed}" in row[5]


def test_links_lead_to_the_runs(swept, swept_page):
    """Links are relative to the page, one a done point."""
    targets = [(swept_page.folder / link).resolve() for link in swept_page.links]
    assert targets == [swept.path(i).resolve() for i in range(4)]
    assert all(t.exists() for t in targets)


@pytest.mark.usefixtures("undrawn")
def test_a_run_of_a_sweep_shows_what_the_sweep_kept(swept, tmp_path):
    """Metrics are those of the sweep, not computed again."""
    page = read(swept.path(2), tmp_path)
    assert "As the sweep that this run belongs to has stored them." in page.text
    value = swept.metrics["slider_position_deviation_peak_mean"][2]
    assert page.row("slider_position_deviation_peak_mean")[1] == measured(value, "m")[0]


@pytest.mark.usefixtures("undrawn")
def test_metrics_of_ones_own_are_named(swept, tmp_path):
    """A sweep's report states the files of own metrics."""
    sweep, metric = cl.open_sweep(swept.folder), (("/own/mine.py:travel", "0123456789abcdef"),)
    sweep.definition = dataclasses.replace(sweep.definition, own=metric)
    page = read(sweep, tmp_path)
    assert page.row("metrics of one's own")[1] == "/own/mine.py:travel"


@pytest.mark.usefixtures("undrawn")
def test_many_points_are_cut_short(swept, tmp_path, monkeypatch):
    """The table has the first points and names the file of all."""
    monkeypatch.setattr(sweep_report, "MOST", 5)
    monkeypatch.setattr(sweep_report, "FIRST", 3)
    page = read(swept, tmp_path)
    assert len([r for r in page.rows if len(r) > 6 and r[0].isdigit()]) == 3
    rest = "The first 3 of 6 points; all of them, with all metrics, are in map <1>/sweep.h5."
    assert rest in page.text


@pytest.mark.usefixtures("undrawn")
def test_a_sweep_without_index_and_one_without_anything_done(swept, tmp_path):
    """The journal is enough; without it all points are missing."""
    shutil.copytree(swept.folder, tmp_path / "map")
    (tmp_path / "map" / "sweep.h5").write_bytes(b"rubbish")
    assert ("box bad", ": 4 done, 2 failed") in read(tmp_path / "map", tmp_path).boxes
    for name in ("sweep.h5", "journal.jsonl"):
        (tmp_path / "map" / name).unlink()
    shutil.rmtree(tmp_path / "map" / "runs")
    page = read(tmp_path / "map", tmp_path)
    assert ("box bad", ": 0 done, 6 missing") in page.boxes
    assert {"No point has a metric yet.", "No point has been run."} <= set(page.missing)


@pytest.mark.usefixtures("undrawn")
def test_samples_and_lists_that_go_together(tmp_path):
    """Drawn and paired parameters are described as such."""
    options = {
        "turns": 1.0,
        "samples_per_turn": 50,
        "channels": [],
        "workers": 1,
        "fixed": {"model": "dry"},
    }
    drawn = cl.sampled(3, speed=(20.0, 30.0))
    page = read(cl.sweep("slider_crank", drawn, tmp_path / "s", **options), tmp_path)
    assert ("box good", ": 3 done") in page.boxes
    assert "slider_crank: sweep over 3 samples of speed" in page.text
    assert page.row("speed", "drawn")[1] == "3"
    assert page.row("model") == ("model", "dry")
    assert page.row("channels in run files")[1] == "none: summaries only"
    assert not page.links
    paired = cl.zipped(speed=[20.0, 25.0, 45.0], clearance=[1e-4, 2e-4, 3e-4])
    page = read(cl.sweep("slider_crank", paired, tmp_path / "z", **options), tmp_path)
    row = page.row("clearance", "by even steps, together with speed")
    assert row[3] == "0.0001, 0.0002, 0.0003 m"
    assert "slider_crank: sweep over speed with clearance (3)" in page.text


# --- files and the command
def test_wrong_input(feeder, tmp_path):
    """Bad names and absent files are refused, and nothing is written."""
    for source, path, error, message in (
        (feeder, "report.h5", ValueError, "report.h5: its name must end in .html"),
        (feeder, "report", ValueError, "report: its name must end in .html"),
        (tmp_path / "none.h5", "r.html", FileNotFoundError, "no result file"),
        (tmp_path, "r.html", FileNotFoundError, "it has no sweep.json"),
    ):
        with pytest.raises(error, match=message):
            report(source, tmp_path / path)
    assert not list(tmp_path.iterdir())


def test_a_report_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    """No half-written page and no other file stays."""
    (tmp_path / "r.html").write_text("old")

    def full(*_):
        raise OSError("no space left")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="no space left"):
        pages.Page("new").save(tmp_path / "r.html")
    assert [p.name for p in tmp_path.iterdir()] == ["r.html"]
    assert (tmp_path / "r.html").read_text() == "old"


def test_the_command(tmp_path, typed):
    """The same file gives the same page, beside it by default."""
    run = tmp_path / "run.h5"
    scene = cl.load_case("six_bar_feeder", joints="B,C")
    cl.simulate(scene, turns=1, path=run, error=None, channels=["drives/*"])
    assert typed("report", run).out.startswith(f"wrote {tmp_path / 'run.html'} (")
    # the same file, the same report
    other = report(run, tmp_path / "other.html")
    assert (tmp_path / "run.html").read_bytes() == other.read_bytes()


@pytest.mark.usefixtures("undrawn")
def test_the_command_with_a_sweep(swept, tmp_path, typed):
    """Folders are made; a document states the size; an absent sweep is refused."""
    out = tmp_path / "deep" / "sweep.html"
    document = typed("report", swept.folder, "-o", out, "--json").document
    assert document == {"status": "complete", "report": str(out), "bytes": out.stat().st_size}
    assert "no file or directory" in typed.line("report", tmp_path / "nothing")


def test_where_a_report_goes_by_itself(tmp_path):
    """Beside a run, or inside the folder of a sweep."""
    assert default(tmp_path) == tmp_path / "report.html"
    assert default(tmp_path / "a.b.h5") == tmp_path / "a.b.html"
