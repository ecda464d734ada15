"""Contact statistics from events and from samples, where on the bearing, and runs without
contacts.
"""

import numpy as np
import pytest
from clearance.postprocess.contacts import contact_table, contacts, contacts_of

import clearance as cl
from tests.postprocess.records import Formula, joint

COLUMNS = {
    "contacts",
    "open_contacts",
    "contacts_per_second",
    "contacts_per_turn",
    "share_in_contact",
    "mean_impact_speed",
    "largest_impact_speed",
    "mean_peak_force",
    "largest_peak_force",
    "median_duration",
    "longest_duration",
    "contact_angle",
    "angle_concentration",
    "sampled",
}


@pytest.fixture(scope="module")
def dry():
    return cl.simulate(cl.load_case("slider_crank", model="dry"), turns=4.0)


def record_of(time, channels=(), **options):
    return Formula(time, dict(channels) | {"joints/C/gap": 0.0 * np.asarray(time)}, **options)


def with_events(**changed):
    events = {
        "time": [0.5, 1.0, 2.9],
        "duration": [0.1, 0.3, 0.1],
        "impact_speed": [1.0, 2.0, 3.0],
        "peak_force": [10.0, 30.0, 20.0],
        "joint": ["C", "C", "C"],
        "kind": ["contact", "contact", "open_contact"],
    }
    return record_of(np.linspace(0.0, 3.0, 301), joints=[joint()], events=events | changed)


def test_numbers_from_events():
    """Counts, shares, means and largest values by hand."""
    (name, table), *rest = contact_table(with_events()).items()
    assert (name, rest, set(table)) == ("C", [], COLUMNS)
    assert all(isinstance(v, int | float) for v in table.values())
    expected = {
        "contacts": 3,
        "open_contacts": 1,
        "contacts_per_second": 1.0,
        "contacts_per_turn": 1.0,
        "sampled": 0,
        "share_in_contact": 0.5 / 3.0,
        "mean_impact_speed": 2.0,
        "largest_impact_speed": 3.0,
        "mean_peak_force": 20.0,
        "largest_peak_force": 30.0,
        "median_duration": 0.2,
        "longest_duration": 0.3,
    }
    assert {k: table[k] for k in expected} == pytest.approx(expected, rel=1e-12)
    assert np.isnan(table["contact_angle"])  # the eccentricity was not stored


def test_other_joints_do_not_count():
    """Events of another joint are left out."""
    record = with_events(joint=["C", "other", "C"])
    assert contact_table(record)["C"]["contacts"] == 2


def test_settled_turns_are_left_out():
    """The contact from 1.0 to 1.3 began before turn 1.1, but 0.2 of it and the last 0.1 are among
    1.9 turns.
    """
    actual = contacts_of(with_events(), "C", settle=1.1)
    assert actual.time.tolist() == [2.9]
    assert actual.share == pytest.approx(0.3 / 1.9, rel=1e-9)


def test_settling_beyond_the_run_is_refused():
    """The message has the turn."""
    with pytest.raises(ValueError, match="has no sample after turn 3.5"):
        contacts_of(with_events(), "C", settle=3.5)


@pytest.mark.parametrize("bearing", ["ground", "rod"])
def test_where_on_the_bearing(bearing):
    """The journal runs round once a turn; the bearing, where it turns, at a quarter of that.

    Chords of 1.2 degrees.
    """
    time = np.linspace(0.0, 3.0, 901)
    channels = {
        "joints/C/eccentricity_x": lambda t: 1e-3 * np.cos(2.0 * np.pi * t),
        "joints/C/eccentricity_y": lambda t: 1e-3 * np.sin(2.0 * np.pi * t),
        "bodies/rod/theta": lambda t: 0.5 * np.pi * t,
    }
    starts = np.array([0.1, 0.6543, 1.7])
    events = {
        "time": starts,
        "duration": 0.01 + 0 * starts,
        "impact_speed": starts,
        "peak_force": starts,
    }
    events |= {"joint": ["C"] * 3, "kind": ["contact"] * 3}
    record = Formula(time, channels, joints=[joint(bearing=bearing)], events=events)
    turned = 0.5 * np.pi * starts if bearing == "rod" else 0.0
    for frame, angle in (
        ("world", 2.0 * np.pi * starts),
        ("bearing", 2.0 * np.pi * starts - turned),
    ):
        actual = contacts_of(record, "C", frame=frame).angle
        # (0.01 rad)^3 of the chord
        np.testing.assert_allclose(np.exp(1j * actual), np.exp(1j * angle), atol=1e-6)
        assert (np.abs(actual) <= np.pi).all()
    with pytest.raises(ValueError, match="frame must be bearing or world, got 'moon'"):
        contacts_of(record, "C", frame="moon")


def test_angle_statistics():
    """Two contacts at one place have its angle, and concentration one."""
    time = np.linspace(0.0, 1.0, 101)
    channels = {"joints/C/eccentricity_x": 0 * time - 1e-3, "joints/C/eccentricity_y": 0 * time}
    events = {n: [0.2, 0.6] for n in ("time", "duration", "impact_speed", "peak_force")}
    record = Formula(
        time,
        channels,
        joints=[joint()],
        events=events | {"joint": ["C"] * 2, "kind": ["contact"] * 2},
    )
    table = contact_table(record)["C"]
    assert abs(table["contact_angle"]) == pytest.approx(np.pi)
    assert table["angle_concentration"] == pytest.approx(1.0)


def test_contacts_found_in_samples():
    """Two stretches of force, the second cut off by the end; each sample stands for a hundredth of
    the time.
    """
    time = np.linspace(0.0, 1.0, 101)
    force = np.zeros(101)
    force[20:30], force[90:] = 5.0, np.arange(11.0) + 1.0
    record = Formula(
        time, {"joints/C/contact_force": force}, joints=[joint(transition={"law": "x:fuzzy"})]
    )
    actual = contacts_of(record, "C")
    assert actual.sampled
    np.testing.assert_allclose(actual.time, [0.195, 0.895], atol=1e-12)
    np.testing.assert_allclose(actual.duration, [0.1, 0.105], atol=1e-12)
    assert (actual.peak_force.tolist(), actual.open.tolist()) == ([5.0, 11.0], [False, True])
    assert np.isnan(actual.impact_speed).all()
    table = contact_table(record)["C"]
    assert (table["sampled"], table["contacts"], table["median_duration"]) == (
        1,
        2,
        pytest.approx(0.1),
    )
    assert table["share_in_contact"] == pytest.approx(0.205)
    assert np.isnan(table["mean_impact_speed"])


def test_a_run_agrees_with_its_events_and_samples(dry):
    """Every event is counted; the share of time in contact agrees with the samples' to 1 % of the
    time.

    A contact's ends fall between samples: 45 contacts in 1600 samples err by the root of 90 sixths
    of a sample, 0.3 %.
    """
    table = contact_table(dry)["C"]
    assert table["contacts"] == len(dry.events["time"]) > 10
    assert table["largest_impact_speed"] == dry.events["impact_speed"].max()
    assert table["share_in_contact"] == pytest.approx(
        np.mean(dry.joint("C").contact_force > 0.0), abs=0.01
    )


def test_angles_of_a_run_agree_with_finer_sampling(dry):
    """Sampling changes no event; angles of 400 and 8000 samples a turn differ by 0.3 degrees at
    worst, measured.
    """
    fine = cl.simulate(cl.load_case("slider_crank", model="dry"), turns=1.0, samples_per_turn=8000)
    a, b = contacts_of(dry, "C"), contacts_of(fine, "C")
    same = len(b.time) - 1
    np.testing.assert_allclose(a.time[:same], b.time[:same], rtol=1e-12)
    assert np.abs(np.angle(np.exp(1j * (a.angle[:same] - b.angle[:same])))).max() < np.radians(1.0)


def test_the_picture(dry, tmp_path, gallery):
    """Every contact is in each of its histograms."""
    path = contacts(dry, tmp_path / "c.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    speeds, forces, durations, turns, rose, _ = gallery.last.axes
    count = len(dry.events["time"])
    assert [speeds.get_xlabel(), durations.get_xlabel()] == ["impact speed [m/s]", "duration [ms]"]
    assert sum(bar.get_height() for bar in speeds.patches) == count
    assert len(forces.lines[0].get_xdata()) == count
    assert turns.patches[0].get_data().values.sum() == count
    assert sum(bar.get_height() for bar in rose.patches) == count
    assert f"joint C: {count} contacts, from the events" in gallery.texts()
    assert gallery.smallest_text() >= 8.0


def test_the_picture_of_a_mixed_run(tmp_path, gallery):
    """It states the limits of its samples."""
    scene = cl.load_case(
        "six_bar_feeder", model="mixed", transition="fuzzy", speed=cl.rpm(600), viscosity=0.002
    )
    run = cl.simulate(scene, turns=1.0)
    assert contact_table(run)["B"]["sampled"] == 1
    contacts(run, tmp_path / "c.png")
    texts = gallery.texts()
    assert "not known: contact sets in gradually" in texts
    assert any("found in the samples" in t for t in texts)


@pytest.mark.parametrize(
    ("case", "options", "text"),
    [
        ("six_bar_feeder", {"model": "lubricated"}, "no joint of this scene has a contact law"),
        ("four_bar", {"model": "ideal"}, "no joint of this scene has a contact law"),
        ("double_pendulum", {}, "no joint of this scene has a contact law"),
        (
            "six_bar_feeder",
            {"model": "mixed", "transition": "load_sharing", "joints": "B,C"},
            "no contact in joint B, C, load on asperities left out",
        ),
    ],
)
def test_runs_without_contacts_say_so(case, options, text, tmp_path, gallery):
    """The picture has the reason, the table zeros."""
    run = cl.simulate(cl.load_case(case, **options), until=0.02)
    contacts(run, tmp_path / "c.png")
    assert text in gallery.texts()
    assert all(table["contacts"] == 0 for table in contact_table(run).values())


@pytest.mark.slow
def test_several_joints(tmp_path, gallery):
    """Six panels a joint; one can be chosen; one without a contact is refused."""
    run = cl.simulate(cl.load_case("six_bar_feeder", model="dry", joints="B,C"), turns=1.0)
    contacts(run, tmp_path / "c.svg")
    assert len(gallery.last.axes) == 12
    contacts(run, tmp_path / "c.png", joints="C")
    assert len(gallery.last.axes) == 6
    with pytest.raises(ValueError, match="joint 'A' has no contact law in .*; with one: B, C"):
        contacts(run, tmp_path / "c.png", joints=["A"])


def test_lean_results():
    """Events are always stored; angles need the eccentricity; a mixed joint its contact force."""
    scene = cl.load_case("slider_crank", model="dry")
    lean = cl.simulate(scene, turns=0.5, channels=["bodies/slider/ax"])
    assert contact_table(lean)["C"]["contacts"] == len(lean.events["time"]) > 0
    assert np.isnan(contact_table(lean)["C"]["contact_angle"])
    mixed = Formula(
        [0.0, 1.0], {"bodies/slider/x": [0.0, 1.0]}, joints=[joint(transition={"law": "x:fuzzy"})]
    )
    with pytest.raises(
        ValueError,
        match="mixed joint C needs the channel joints/C/contact_force, which was not stored",
    ):
        contact_table(mixed)


@pytest.mark.parametrize("samples", [1, 301])
def test_the_picture_without_a_drive(samples, tmp_path, gallery):
    """Contacts are counted in a second, and what was not stored is named."""
    free = record_of(
        np.linspace(0.0, 3.0, samples), speed=None, joints=[joint()], events=with_events().events
    )
    assert np.isnan(contact_table(free)["C"]["contacts_per_turn"])
    contacts(free, tmp_path / "c.png")
    assert any(t.startswith("contacts in ") for t in gallery.texts())
    assert "eccentricity or bearing angle not stored" in gallery.texts()


def test_no_samples(tmp_path, gallery):
    """An empty run has no contact."""
    empty = Formula([], {}, joints=[joint()])
    assert contact_table(empty)["C"]["contacts"] == 0
    contacts(empty, tmp_path / "c.png")
    assert "no contact in joint C" in gallery.texts()
