"""A life of wear: the replay of a load path, sums of wear in runs, stages and jumps; rows of an
independent code.
"""

import contextlib
import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.laws import FilmJoint
from clearance.laws.outline import NODES, Outline, deepest, touching, worn
from clearance.run.wear_sum import Sums
from clearance.wearing.life import Driver, Plan
from clearance.wearing.load_path import MANY, LoadPath, Worn, smoothed
from clearance.wearing.replay import rest
from tests.seeds import few_of

FILE = Path(__file__).with_name("wear_rows.csv")
ROWS = {row["id"]: float(row["value"]) for row in csv.DictReader(FILE.read_text().splitlines())}
RADIUS, CLEARANCE, LENGTH, COEFFICIENT, FORCE, MODULUS = 0.01, 1e-4, 0.02, 1e-13, 1000.0, 1e12
WAY = 2.0 * math.pi * RADIUS  # slid in a turn
UNWORN = Outline(None, worn().parameters).numbers


def standing(parts=1, bearing=COEFFICIENT, journal=0.0):
    """Load path of a turn under a load at rest in the bearing, the journal turning once."""
    angle = 2.0 * math.pi * (np.arange(parts) + 0.5) / parts
    over = [np.full(parts, k * WAY / parts) for k in (bearing, journal)]
    return np.column_stack(
        [np.full(parts, -FORCE), np.zeros(parts), angle, *over, np.full(parts, CLEARANCE)]
    )


def turning(parts=180):
    """Load path of case E, whose load turns around a steady one; both surfaces wear."""
    angle = 2.0 * math.pi * (np.arange(parts) + 0.5) / parts
    over = np.full(parts, COEFFICIENT * WAY / parts)
    force = -400.0 * np.cos(angle), 600.0 - 400.0 * np.sin(angle)
    return np.column_stack([*force, angle, over, over, np.full(parts, CLEARANCE)])


def replayed(path, turns, modulus=MODULUS):
    """Outlines after so many turns, and the error that the replay states."""
    path_of_turn = LoadPath(path, modulus, RADIUS * LENGTH)
    begin = Worn.of(UNWORN, path, path[:, 4].any())
    end, done, error = path_of_turn.over(begin, turns, 1e-3)
    assert done == turns
    return end, error


class TestReplay:
    def test_load_at_rest(self):
        """Case B, an elastic layer: depths within the error stated, volume within 1e-3."""
        for turns, depth in ((10, "W15"), (1000, "W21")):
            end, error = replayed(standing(), turns)
            assert abs(end.bearing[0] - ROWS[depth]) < error
        assert end.volumes[0] == pytest.approx(ROWS["W25"], rel=1e-3)

    @pytest.mark.parametrize("seed", few_of(range(8), 3))
    def test_soft_layers(self, seed):
        """Forces that press the journal a hundredth to fifty clearances into its layer: the
        foundation carries them where it rests, to 1e-8.
        """
        rng = np.random.default_rng(seed)
        angles, depth = 2.0 * math.pi * rng.random(12), CLEARANCE * 10.0 ** rng.uniform(-2, 1.7, 12)
        force = np.pi * MODULUS * RADIUS * LENGTH * depth
        path = np.zeros((12, 6))
        path[:, 0], path[:, 1] = force * np.cos(angles), force * np.sin(angles)
        path[:, 3], path[:, 5] = 1e-26, CLEARANCE
        end = LoadPath(path, MODULUS, RADIUS * LENGTH).step(Worn.of(UNWORN, path, False), 1.0)
        for (fx, fy), (x, y) in zip(path[:, :2], end.position, strict=True):
            carried = touching(x, y, 0.0, FilmJoint(0.0, CLEARANCE, 0.0, 0.0, 0.0), UNWORN, 0.0)
            off = MODULUS * RADIUS * LENGTH * np.array(carried[:2]) - (fx, fy)
            assert np.hypot(*off) < 1e-8 * np.hypot(fx, fy)

    def test_journal(self):
        """Case C: a journal that turns under a load wears evenly."""
        end, _ = replayed(standing(180, 0.0, COEFFICIENT), 100)
        assert end.journal.mean() == pytest.approx(ROWS["W27"], rel=1e-3)
        assert np.ptp(end.journal) < 1e-2 * end.journal.mean()
        assert not end.bearing.any()

    def test_many_turns_of_both(self):
        """Case G, 100 turns of case E: within 2e-3 (the row jumps by 10), and unworn above."""
        end, _ = replayed(turning(), 100)
        assert end.bearing[180] == 0.0
        actual = end.bearing[270], end.journal[90]
        assert actual == pytest.approx((ROWS["W42"], ROWS["W46"]), rel=2e-3)

    def test_rest_on_a_ridge(self):
        """A journal above a ridge that only the deepest point sees: Newton carries its force
        (1e-9).
        """
        flanks = [50, 155, 230, 274, 289, 272, 226, 149, 42.5, 0, 0, 246, 914, 1551, 2157, 2732]
        depths = np.zeros(NODES)
        depths[151:167] = 1e-9 * np.array(flanks)
        joint, start = FilmJoint(0.0, CLEARANCE, 0.0, 0.0, 0.0), (-9.4870e-05, 3.1606e-05)
        data = Outline(None, worn(bearing=depths).parameters).numbers
        assert deepest(*start, 0.0, joint, data, 0.0)[0] > 0.0
        assert touching(*start, 0.0, joint, data, 0.0)[2] == 0.0
        x, y, _ = rest((1649.0, -549.0, 0.0), start, joint, data, None, 0.0, 1e10)
        force = 1e10 * np.array(touching(x, y, 0.0, joint, data, 0.0)[:2])
        assert force == pytest.approx([1649.0, -549.0], abs=1e-9 * 1739.0)

    def test_hop(self, monkeypatch):
        """A journal hops between two scars until their ridge is gone: few steps, and the depth is
        that of single turns within the error stated.
        """
        theta = np.deg2rad(np.arange(NODES) - 180.0)
        depths = 20e-6 * np.maximum(1.0 - np.abs(np.abs(theta) - 0.4) / 0.4, 0.0)
        data = Outline(None, worn(bearing=np.roll(depths, 180)).parameters).numbers
        path, angle = standing(40), 0.15 * np.sin(2.0 * math.pi * np.arange(40) / 40)
        path[:, 0], path[:, 1] = -FORCE * np.cos(angle), -FORCE * np.sin(angle)
        replay = LoadPath(path, 100.0 * MODULUS, RADIUS * LENGTH)
        begin, steps, both = Worn.of(data, path, False), [], LoadPath.both
        monkeypatch.setattr(LoadPath, "both", lambda *a: steps.append(a) or both(*a))
        end, done, error = replay.over(begin, 300.0, 1e-3)
        assert done == 300.0
        assert len(steps) < 4 * MANY
        turns = [begin]
        for _ in range(300):
            turns.append(replay.step(turns[-1], 1.0))
        apart = [np.ptp(np.arctan2(*w.position.T[::-1])) for w in (turns[1], end)]
        assert apart[0] > 0.7 > 0.05 > apart[1]
        assert np.abs(smoothed(end.bearing - turns[-1].bearing)).max() < error
        assert error < 1e-2 * end.bearing.max()

    def test_volume_is_that_of_the_load(self):
        """Depths sum to k N s at each part, whatever the nodes see of the pressure (rounding)."""
        end, _ = replayed(standing(7), 1.0)
        summed = end.bearing.sum() * RADIUS * LENGTH * math.radians(1.0)
        assert summed == pytest.approx(end.volumes[0], rel=1e-9)


def rotor(e=1.0923687270e-4, **fields):
    """Case B as a mechanism: a journal at rest under 1000 N that turns once a second."""
    body = cl.Body("rotor", 0.5, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground,
        body,
        name="B",
        radius=RADIUS,
        clearance=CLEARANCE,
        length=LENGTH,
        eccentricity=(e, 0.0),
        contact=cl.winkler(layer_modulus=MODULUS, restitution=0.5),
        **{"wear": cl.archard(coefficient=COEFFICIENT)} | fields,
    )
    load = cl.Force(body.at(0, 0), x=FORCE, name="load")
    return cl.Scene(
        joint, load, cl.Drive(body, speed=2.0 * math.pi, name="d"), gravity=(0, 0), name="rotor"
    )


class TestNarrowArcs:
    """Arcs on a hard foundation, which lie between two nodes: all the wear of their load stays."""

    HARD = 1e17  # an arc of 0.1 degrees under a tenth of a newton

    def test_replay(self):
        """Volume of the depths as that of the load, within 1e-3; at the two nodes beside it."""
        angle, force = math.radians(200.4), 0.1
        row = [-force * math.cos(angle), -force * math.sin(angle), 0.3, 1e-22, 1e-22, CLEARANCE]
        path = np.array([row])
        end = LoadPath(path, self.HARD, RADIUS * LENGTH).step(Worn.of(UNWORN, path, True), 1.0)
        area = RADIUS * LENGTH * math.radians(1.0)
        assert end.volumes == pytest.approx([1e-22 * force] * 2, rel=1e-3)
        for depths in (end.bearing, end.journal):
            assert area * depths.sum() == pytest.approx(1e-22 * force, rel=1e-3)
        assert np.flatnonzero(end.bearing).tolist() == [200, 201]
        assert end.bearing[201] / end.bearing[200] == pytest.approx(0.4 / 0.6, rel=1e-2)

    def test_sums(self):
        """The same row of a run: the depths carry the load to rounding. Their place is that of a
        parabola, within 1e-4.
        """
        joint = cl.ClearanceRevolute(
            cl.ground.at(0.0, 0.0),
            cl.Body("rotor", 1.0, 1e-4, points={"O": (0.0, 0.0)})["O"],
            name="B",
            radius=RADIUS,
            clearance=CLEARANCE,
            length=LENGTH,
            contact=cl.winkler(layer_modulus=self.HARD, restitution=0.5),
            wear=cl.archard(coefficient=COEFFICIENT),
        )
        sums, angle, load = Sums(joint), math.radians(200.4), 0.1
        e = CLEARANCE + 1e-12
        row = e * math.cos(angle), e * math.sin(angle), 0.3, CLEARANCE, self.HARD, 0.5, 0.0, 0.0
        sums.add(np.array([[1.0, 1.0]]), np.array([[(*row, load)] * 3]))
        depths = sums.depths["bearing"]
        assert sums.area * depths.sum() == pytest.approx(COEFFICIENT * 0.5 * load, rel=1e-12)
        assert np.flatnonzero(depths).tolist() == [200, 201]
        assert depths[201] / depths[200] == pytest.approx(0.4 / 0.6, rel=1e-4)


class TestSums:
    def test_bins_and_volume(self):
        """Bins over Lobatto's points miss the integrated volume by less than 1e-3 before they are
        scaled to it.
        """
        scene = cl.load_case(
            "slider_crank", model="dry", wear=1e-13, wear_journal=1e-14, speed=cl.rpm(1000)
        )
        result = cl.simulate(scene, turns=0.5)
        facts, joint = result.facts("joints/C/wear"), result.joint("C")
        assert 0.0 < facts["bins_error"] < 1e-3
        size = next(j for j in scene.joints if j.name == "C")
        area = size.radius * size.length * math.radians(1.0)
        for surface in ("bearing", "journal"):
            volume = getattr(joint, f"wear_volume_{surface}")[-1]
            assert area * facts[f"worn_{surface}"].sum() == pytest.approx(volume, rel=1e-12)

    def test_work_of_friction(self):
        """An elastic contact that rubs has taken out mu int N |v| dt where it is free again: within
        1e-3.
        """
        mu = 0.1
        scene = cl.load_case(
            "slider_crank", model="dry", wear=1e-13, restitution=1.0, speed=cl.rpm(1000)
        )
        friction = cl.coulomb_tanh(coefficient=mu, transition_speed=1e-5)
        scene = scene.rebuilt(
            element=lambda e: replace(e, friction=friction) if e.name == "C" else e
        )
        result = cl.simulate(scene, until=0.02)
        joint = result.joint("C")
        assert joint.gap[-1] > 0.0
        assert result.facts("joints/C/wear")["rubbing"] > 0.0
        volume = joint.wear_volume_bearing[-1]
        assert joint.dissipated[-1] == pytest.approx(mu * volume / 1e-13, rel=1e-3)

    def test_own_law(self):
        """A law that is not linear in the pressure is summed over the arc; of a linear one it gives
        the same.
        """
        depths = []
        for law in (cl.archard(coefficient=COEFFICIENT), hardly_bent(coefficient=COEFFICIENT)):
            result = cl.simulate(rotor(wear=law), turns=0.25)
            depths.append(result.facts("joints/B/wear")["worn_bearing"])
        assert "wear_volume_bearing" not in result.joint("B")
        assert depths[0] == pytest.approx(depths[1], rel=2e-3, abs=1e-3 * depths[0].max())


@cl.surface_wear
def hardly_bent(pressure, sliding_speed, coefficient):
    """Archard's law with a bend at no pressure worth the name [m/s]."""
    return coefficient * sliding_speed * max(pressure - 1.0, 0.0)


MINE = '''\
import clearance as cl
from tests.wearing.test_life import rotor


def scene(*, wear: float = 1e-13):
    """Rotor.

    wear: coefficient [m2/N]
    """
    return rotor(wear=cl.archard(coefficient=wear))
'''


def _end(request):
    """A function that raises a request to end."""

    def end(*_):
        raise request

    return end


OPTIONS = {"turns": 40.0, "jump_turns": 20.0, "settle": 0, "average": 1}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A life of 40 turns, in jumps of at most 20, whose first attempt is stopped at the second
    stage.
    """
    folder = tmp_path_factory.mktemp("life")

    def stop(done, words):
        if done > 0.0 and words.endswith("is done"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cl.wear(rotor(), directory=folder / "worn", progress=stop, **OPTIONS)
    assert len(cl.Life(folder / "worn").stages) == 2
    cl.wear(rotor(), directory=folder / "worn", **OPTIONS)
    return folder


class TestLife:
    def test_depth(self, folder):
        """Case B by dynamics and jumps: the replay's depth within the error that the life
        states.
        """
        life = cl.Life(folder / "worn")
        assert life.done
        assert life.turns == pytest.approx([0.0, 20.0, 40.0])
        assert "B_bearing_depth" in life._repr_html_()
        exact, _ = replayed(standing(), 40.0)
        assert life.depth("B")[-1].max() == pytest.approx(exact.bearing[0], abs=life.error[-1])
        assert life.error[-1] < 2e-2 * exact.bearing[0]
        assert life.volume("B")[-1] == pytest.approx(exact.volumes[0], rel=2e-3)

    def test_goes_on_as_if_never_stopped(self, folder, tmp_path):
        """The same numbers as a life that nobody stopped."""
        entire = cl.wear(rotor(), directory=tmp_path, **OPTIONS)
        assert np.array_equal(entire.depth("B"), cl.Life(folder / "worn").depth("B"))

    def test_stopped_at_each_stage(self, tmp_path):
        """Depths and errors that a jump has foretold are the same again, to the last bit."""
        options = OPTIONS | {"turns": 50.0, "jump_turns": 10.0}
        for stop in (2, 2, 2, 9):  # at the second stage of each attempt; the last one ends
            seen = iter(range(1, 1 + stop))

            def progress(done, words, seen=seen, stop=stop):
                if words.endswith("is done") and next(seen) == stop:
                    raise KeyboardInterrupt

            with contextlib.suppress(KeyboardInterrupt):
                cl.wear(rotor(), directory=tmp_path / "stopped", progress=progress, **options)
        entire = cl.wear(rotor(), directory=tmp_path / "entire", **options)
        stopped = cl.Life(tmp_path / "stopped")
        assert stopped.done
        assert len(stopped.stages) == 6
        assert np.array_equal(entire.depth("B"), stopped.depth("B"))
        assert np.array_equal(entire.error, stopped.error)

    def test_another_life(self, folder):
        """A directory belongs to one life; more turns go on with it, other numbers do not."""
        with pytest.raises(ValueError, match=r"holds another life \(other tolerance\)"):
            cl.wear(rotor(), directory=folder / "worn", tolerance=0.1, **OPTIONS)

    def test_a_turn_that_swallows_a_scar(self, tmp_path):
        """A coefficient that wears a quarter of the clearance in a turn is refused."""
        scene = rotor(wear=cl.archard(coefficient=1e-9))
        reason = r"wears its bearing .* m deep, and share = 0.25 of the clearance is 2.5e-05 m"
        with pytest.raises(ValueError, match=reason):
            cl.wear(scene, directory=tmp_path, **OPTIONS)

    def test_linear(self, folder, tmp_path):
        """Explicit jumps agree while they are short, and are refused beyond their stability."""
        life = cl.wear(rotor(), directory=tmp_path / "short", jump="linear", **OPTIONS)
        assert life.volume("B")[-1] == pytest.approx(
            cl.Life(folder / "worn").volume("B")[-1], rel=2e-2
        )
        exact, _ = replayed(standing(), 40.0)
        assert life.error[-1] > abs(life.depth("B")[-1].max() - exact.bearing[0])
        options = OPTIONS | {"jump_turns": 4000.0, "turns": 1e4}
        with pytest.raises(
            ValueError, match=r"jump_turns=4000 of linear jumps: beyond 318 turns they are unstable"
        ):
            cl.wear(rotor(), directory=tmp_path / "long", jump="linear", **options)

    def test_picture(self, folder, tmp_path, undrawn):
        """Six panels and the bars of their colours."""
        from clearance.postprocess.lives import life as draw

        assert draw(folder / "worn", tmp_path / "life.png").exists()

    def test_curves_whose_sign_changes(self):
        """A gap that becomes a penetration is drawn over its largest magnitude, others over the
        first.
        """
        from clearance.postprocess.lives import _sized

        words, size = _sized(np.array([-1e-8, 4e-8]), "smallest gap", "m")
        assert size == 4e-8
        assert words == "smallest gap (below 0: solids), largest 0.04 µm"
        words, size = _sized(np.array([-1e-8, -4e-8]), "smallest gap", "m")
        assert size == -1e-8
        assert words == "deepest penetration, first 0.01 µm"

    def test_terminated(self, folder, tmp_path, typed):
        """A request to end is answered by the way to go on."""
        from clearance.run.interrupts import Terminated

        file = tmp_path / "mine.py"
        file.write_text(MINE)
        words = ["wear", file, "--turns 5 -o", tmp_path / "worn"]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("clearance.wearing.life.Driver.run", _end(Terminated))
            message = typed(*words, status=1).err
        assert "terminated; stages before it are stored; the same command goes on" in message

    def test_plot(self, folder, typed, undrawn):
        """`clearance plot` of a life: the six panels; other pictures are refused."""
        worn = folder / "worn"
        picture = typed("plot", worn, "--json").document["picture"]
        assert Path(picture) == worn / "life.png"
        assert Path(picture).exists()
        refused = {
            "orbit": "is a life, of which there is no orbit; there is life, animation",
            "--joint C": "joint C does not wear; B do",
            "--surface journal": "the journal of joint B does not wear; bearing does",
            "--metrics gap": "--metrics does not belong to the life of a life",
            "animation --frames 1": "an animation needs two frames",
        }
        for words, reason in refused.items():
            assert reason in typed.line("plot", worn, words)

    def test_animation(self, folder, tmp_path):
        """Frames at equal turns, the last one of the end of the life."""
        from PIL import Image

        path = cl.plot(folder / "worn", "animation", tmp_path / "life.gif", frames=4)
        with Image.open(path) as film:
            assert film.n_frames == 4

    def test_wear_over_the_drive(self, folder):
        """Wear over the angle of the drive sums to the volume of a turn (5e-3)."""
        from clearance.postprocess.lives import _over_angle

        life = cl.Life(folder / "worn")
        with cl.open_result(life.file(1)) as run:
            angle, rate = _over_angle(run, "B", "bearing")
            volume = run.joint("B").wear_volume_bearing
        assert len(angle) == pytest.approx(360, abs=1)
        assert 1e-18 * rate.mean() * 360.0 == pytest.approx(volume[-1] - volume[0], rel=5e-3)

    def test_closed_form(self, folder):
        """Rigid bodies under the first load path: the rows of case A, from a life with their
        load.
        """
        life = cl.Life(folder / "worn")
        life.stages = [{"turns": 100.0}, {"turns": 5000.0}]
        assert life.closed_form("B") == pytest.approx([ROWS["W02"], ROWS["W06"]], rel=1e-3)

    def test_the_closed_form_is_for_loads_that_stand_still(self, folder):
        """A load that turns once round the bearing is none of these."""
        life = cl.Life(folder / "worn")
        assert life.stands_still("B")
        path = life.load_path("B")
        angle = 2.0 * math.pi * np.arange(len(path)) / len(path)
        path[:, 0], path[:, 1] = np.cos(angle), np.sin(angle)
        assert not life.stands_still("B")

    def test_command(self, tmp_path, typed):
        """One document; a case file, a unit, and a table of stages."""
        file = tmp_path / "mine.py"
        file.write_text(MINE)
        words = "-p wear=1e-4mm3/Nm --turns 5 --settle 0 --average 1 --json"
        document = typed("wear", file, words, "-o", tmp_path / "worn").document
        assert document["status"] == "complete"
        assert document["stages"][-1]["B_bearing_depth"] > 0.0

    def test_refused(self, tmp_path):
        """Impossible lives are refused with numbers."""
        with pytest.raises(ValueError, match=r"share must lie in \(0, 1\] of the clearance, got 3"):
            Plan(1.0, 3.0, 0.05, 2, 2, "replay", None, 1e-6, "auto", 360)
        with pytest.raises(ValueError, match="no joint of slider_crank wears"):
            cl.wear("slider_crank", model="dry", turns=10, directory=tmp_path)
        reason = r"wear archard\(coefficient=0\) wears nothing"
        with pytest.raises(ValueError, match=reason):
            cl.wear(rotor(wear=cl.archard(coefficient=0.0)), turns=10, directory=tmp_path)
        deep = worn(bearing=[6e-3] + [0.0] * (NODES - 1))
        with pytest.raises(
            ValueError, match="outline: bearing is worn 0.006 m deep, through its wall of 0.005 m"
        ):
            rotor(outline=deep)


def counted(monkeypatch) -> list:
    """Numbers of the stages that lives run."""
    runs, run = [], Driver.run
    monkeypatch.setattr(Driver, "run", lambda self, k, *a: runs.append(k) or run(self, k, *a))
    return runs


class TestJoints:
    @pytest.mark.slow
    def test_rattles_in_its_scar(self, tmp_path, monkeypatch):
        """A narrow contact at 60 rpm: jumps never shrink to turns, stages are run twice at most,
        and the depth is that of ten times shorter jumps within the errors stated.
        """
        laws = {
            "contact": cl.winkler(layer_modulus=2e11, restitution=0.3),
            "wear": cl.archard(coefficient=1e-13),
        }
        scene = cl.load_case("slider_crank", model="dry", contact="winkler", speed=cl.rpm(60))
        scene = scene.rebuilt(element=lambda e: replace(e, **laws) if e.name == "C" else e)
        runs = counted(monkeypatch)
        options = {"settle": 1, "average": 1, "rtol": 1e-4}
        life = cl.wear(scene, turns=1.5e6, directory=tmp_path / "long", **options)
        assert life.done
        assert np.diff(life.turns).min() > 1e5
        assert len(life.stages) < 8
        assert len(runs) <= 2 * len(life.stages)
        depth, volume = life.depth("C")[-1].max(), life.volume("C")
        assert 0.0 < life.error[-1] < 0.5 * depth
        options |= {"jump_turns": 1e5, "tolerance": 10.0}
        short = cl.wear(scene, turns=1.5e6, directory=tmp_path / "short", **options)
        assert len(short.stages) == 16
        assert short.error[-1] < 0.1 * depth
        assert abs(depth - short.depth("C")[-1].max()) < life.error[-1] + short.error[-1]
        per_turn = life.metric("joint_C_wear_bearing_per_turn")
        between = 0.5 * (per_turn[1:] + per_turn[:-1])
        assert volume[-1] == pytest.approx(between @ np.diff(life.turns), rel=0.05)

    @pytest.mark.slow
    def test_feeder(self, tmp_path):
        """A dry joint of the feeder wears: depth, volume and stated error of a hundred thousand
        turns.
        """
        parameters = {"model": "dry", "joints": "B", "wear": 1e-15}
        plan = {"tolerance": 0.5, "share": 0.5, "settle": 0, "average": 1, "rtol": 1e-4}
        life = cl.wear("six_bar_feeder", turns=1e5, directory=tmp_path, **plan, **parameters)
        assert life.done
        volumes = life.metric("joint_B_wear_bearing_per_turn")
        assert life.volume("B")[-1] == pytest.approx(1e5 * volumes.mean(), rel=0.3)
        assert 0.0 < life.error[-1] < life.depth("B")[-1].max()


@pytest.mark.slow
class TestWearA:
    def test_one_turn(self):
        """Row H: the second turn of the unworn joint wears as a quasi-static load path has it,
        within 1e-3.
        """
        result = cl.simulate(cl.load_case("wear_a"), turns=2)
        volume = result.joint("B").wear_volume_bearing
        middle = len(volume) // 2
        assert volume[-1] - volume[middle] == pytest.approx(ROWS["W56"], rel=1e-3)

    def test_every_turn_run(self, tmp_path):
        """30 turns at a hundred times the wear, and 60 at fifty, all run: where their depths lead
        to, jumps are within the error stated.

        The outline of a run turn stays as it is until its end, an error of first order in the wear.
        The load path of the first turn alone is farther off: the load falls as the scar grows.
        """
        every = {"jump": "linear", "jump_turns": 1.0, "settle": 0, "average": 1}
        every |= {"share": 1.0, "tolerance": 10.0}
        lives = []
        for turns, more in ((30, {}), (30, every), (60, every)):
            folder, wear = tmp_path / f"{turns}{len(more)}", 3000.0 / turns * 5.05e-13
            lives.append(cl.wear("wear_a", turns=turns, directory=folder, wear=wear, **more))
        jumps, coarse, fine = (life.depth("B")[-1].max() for life in lives)
        assert [len(life.stages) for life in lives[1:]] == [31, 61]
        assert abs(jumps - (2.0 * fine - coarse)) < lives[0].error[-1] < 1e-3 * jumps

    def test_thousand_turns(self, tmp_path):
        """Depth after 1000 turns in four stages: the row within 1e-3, which both codes resolve.
        Short jumps lead to it within the error stated.
        """
        life = cl.wear("wear_a", turns=1000, directory=tmp_path / "long", settle=1, average=1)
        depth = life.depth("B")[-1].max()
        assert depth == pytest.approx(ROWS["W57"], rel=1e-3)
        assert len(life.stages) == 4
        assert life.closed_form("B")[-1] == pytest.approx(ROWS["W59"], rel=1e-3)
        plan = {"share": 0.05, "tolerance": 0.01}
        short = cl.wear("wear_a", turns=1000, directory=tmp_path / "short", **plan)
        assert abs(depth - short.depth("B")[-1].max()) < life.error[-1]


def test_a_run_prints_the_volumes_that_wear(tmp_path, typed):
    """The number of its last row."""
    path = tmp_path / "run.h5"
    ended = typed("run wear_a --until 0.2 --no-error -o", path)
    with cl.open_result(path) as run:
        volume = 1e9 * run.joint("B").wear_volume_bearing[-1]
    assert f"bearing worn by {volume:.4g} mm3" in ended.out
