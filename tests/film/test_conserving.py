"""The film with memory against exact cavitation cases, and what it must keep: oil and symmetry.

Published bearings: test_published.py.
"""

import math
from functools import partial

import numpy as np
import pytest

from clearance.film import oil_balance
from clearance.film.bearing import Groove
from clearance.film.conserving import MemoryFilm
from clearance.film.control_volumes import (
    COND,
    DRAG,
    FIXED,
    FULL,
    GAP,
    SHEAR,
    VOLUME,
    Mesh,
    State,
    System,
    thicken,
)
from clearance.film.piezo import oil_of
from tests.differences import slopes
from tests.film import states
from tests.seeds import few_of

LINE = (Groove(angle=math.pi),)  # on the widest gap of a journal displaced along +x
POCKET = (Groove(angle=0.5, width=0.3, length=0.6, pressure=3e3),)
FOWELL = {"source": "pocket slider of Fowell et al. 2007, scalar equation", "kind": "exact"}
PLATES = {"source": "squeezed plates with memory, equation of the front", "kind": "exact"}
SHORT = {"source": "Sommerfeld's full film in a short bearing", "kind": "exact"}

bearing = partial(states.bearing, viscosity=0.1)


def film(mesh=(48, 4), liner=0.0, conserving=True, slenderness=1.0, **more):
    """The film of a bearing with these options."""
    return MemoryFilm(bearing(slenderness, **more), mesh, liner, conserving)


class Strip:
    """A plain strip of cells with given pressure at both ends, on the film's own Newton step."""

    def __init__(self, cells, ends, drag, hold):
        n = cells + 2
        column = np.arange(n)
        self.face, self.cell = np.zeros((n, 1, DRAG + 1)), np.zeros((n, 1, SHEAR + 4))
        self.kind = np.full((n, 1), FULL)
        self.kind[[0, -1]] = FIXED
        self.p, self.content = np.full((n, 1), ends), np.ones((n, 1))
        order = np.where(2 * column < n, 2 * column, 2 * (n - column) - 1)
        unused = np.zeros((n, 4))
        self.mesh = Mesh(
            unused,
            order,
            unused,
            *(np.ones(n), np.ones(n), np.ones(1), np.array([0.5])),  # a cell
            weight=1.0,
            mean=np.ones(n),
            soft=0.0,
            oil=oil_of(0.0, 1.0, 1.0, False),
            lowest=0.0,
            carried=1.0,
            filled=False,
        )
        self.flow = oil_balance.Flow(drag, hold, hold)
        zeros = np.zeros((n, 1))
        self.past = oil_balance.Past(np.ones((n, 1)), *np.zeros((2, n, 1)), zeros, zeros, False)
        self.system = System(
            self.face,
            self.cell,
            np.zeros((n, 2, 5)),
            np.zeros((n, 2)),
            np.zeros((n, 5)),
            np.zeros((n, 1)),
        )
        self.system.least[[0, -1], 0] = ends

    def solve(self):
        for _ in range(100):
            state = State(self.kind, self.p, self.content)
            film = self.past, self.flow, 0.0, self.mesh, self.system
            thicken((0.0, 0.0), state, self.mesh, self.system)
            switched, _ = oil_balance.step((0.0, 0.0), state, *film, 0.0)
            if switched == 0:
                return
        raise AssertionError("a strip did not settle")

    @property
    def full(self):
        return self.kind[1:-1, 0] == FULL


class Slider:
    """Inclined slider, 10 mm, gap 1.05 to 1 um, pocket of 1 um from 2 to 5 mm, 1 m/s, 0.01 Pa s,
    1e5 Pa at the ends.

    Fowell et al. (2007). Exact: the flow q and the point of reformation follow from one scalar
    equation.
    """

    DRAG, AMBIENT, FLOW, REFORM = 6e-2, 1e5, 5.229635024e-7, 0.003611262656
    POINTS = (
        (0.5e-3, 173381.65),
        (1.5e-3, 124326.75),
        (4.5e-3, 6273640.2),
        (5.5e-3, 9188701.8),
        (9.5e-3, 1435347.3),
    )

    @staticmethod
    def integral(power, start, end, depth):
        """Of the gap to -power."""
        slope = -5e-6
        first, last = (1.05e-6 + slope * x + depth for x in (start, end))
        return (first ** (1 - power) - last ** (1 - power)) / (slope * (power - 1))

    @classmethod
    def solved(cls, cells):
        face = np.linspace(0.0, 1e-2, cells + 1)
        middle = 0.5 * (face[1:] + face[:-1])
        depth = np.where((middle > 2e-3) & (middle < 5e-3), 1e-6, 0.0)
        strip = Strip(cells, cls.AMBIENT, cls.DRAG, 0.0)
        second, third = (
            np.append(cls.integral(m, face[:-1], middle, depth), 0.0)
            + np.append(0.0, cls.integral(m, middle, face[1:], depth))
            for m in (2, 3)
        )
        strip.face[:-1, 0, COND], strip.face[:-1, 0, GAP] = 1.0 / third, second / third
        strip.solve()
        flow = (cls.DRAG * second[0] / third[0] + (strip.p[0, 0] - strip.p[1, 0]) / third[0]) / 0.12
        return flow, face[1 + np.flatnonzero(~strip.full)[-1]], middle, strip.p[1:-1, 0]


class TestPocketSlider:
    """Halving the cells halves the error (reformation inside a cell): flow 1.44e-4, 7.2e-5, 3.6e-5
    at 100, 200, 400.
    """

    @pytest.mark.parametrize("cells", few_of([200, 400], 1))
    def test_flow_and_reformation(self, cells, validated):
        """Flow 1e-4; reformation within a cell; pressure in proportion to the cells."""
        flow, reform, middle, p = Slider.solved(cells)
        validated("flow", flow, Slider.FLOW, 1e-4, unit="m2/s", **FOWELL)
        label = f"place of reformation, {cells} cells"
        validated(label, reform, Slider.REFORM, 1e-2 / cells, unit="m", relative=False, **FOWELL)
        for x, exact in Slider.POINTS:  # 2.3e-3 of the peak measured at 200 cells
            actual, options = np.interp(x, middle, p), FOWELL | {"unit": "Pa", "relative": False}
            validated(f"pressure, {cells} cells", actual, exact, 0.6 / cells * 9.8e6, **options)

    def test_order(self):
        """First order: the reformation stands at a cell's edge."""
        errors = [abs(Slider.solved(cells)[0] / Slider.FLOW - 1.0) for cells in (100, 200, 400)]
        assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
        assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.05)


class TestSqueezedPlates:
    """Gap 0.375 + 0.125 cos(4 pi t) over x in [0, 1], p = 0.025 at both ends, d_x(h^3 p_x) = 2
    d_t(f h).

    Length of the full strip at each end, from the front's own differential equation, and the time
    the cavity closes.
    """

    FRONT = {
        0.26: 0.0448074587,
        0.28: 0.027371812,
        0.31: 0.023062592,
        0.35: 0.0236826257,
        0.40: 0.0267806128,
        0.45: 0.0320101397,
        0.50: 0.0390871271,
        0.55: 0.0484938433,
        0.60: 0.0627768757,
        0.65: 0.0907918006,
        0.68: 0.127415398,
        0.70: 0.176937698,
        0.71: 0.220584622,
        0.72: 0.293636932,
        0.73: 0.440231106,
    }
    CLOSED = 0.732389878

    @staticmethod
    def gap(t):
        return 0.375 + 0.125 * math.cos(4.0 * math.pi * t)

    def fronts(self, cells, steps):
        """Full length after each step, on the left half of the plates (no flow through their
        middle).
        """
        width, strip = 0.5 / cells, Strip(cells, 0.025, 0.0, 2.0 * steps)
        actual, was = np.empty(steps), self.gap(0.0)
        old, growth = strip.past.content, strip.past.growth
        for step in range(steps):
            old[:], before = strip.content, was
            was = self.gap((step + 1) / steps)
            growth[:] = (was - before) * width
            strip.face[:-2, 0, COND] = was**3 / width
            strip.face[0, 0, COND] *= 2.0
            strip.cell[1:-1, 0, VOLUME] = was * width
            strip.solve()
            actual[step] = strip.full.sum() * width
        return actual

    def errors(self, cells, steps):
        actual = self.fronts(cells, steps)
        return np.array([actual[round(t * steps) - 1] - exact for t, exact in self.FRONT.items()])

    def test_front(self, validated):
        """Within two cells (the front is a cell's edge), and the rms falls with them: 2.7e-3 to
        1.2e-3 measured.
        """
        coarse, fine = self.errors(100, 400), self.errors(200, 800)
        for cells, error in ((100, coarse), (200, fine)):
            label = f"error of the front, {cells} cells"
            validated(label, error, 0.0, 1.0 / cells, relative=False, **PLATES)
        assert np.sqrt(np.mean(fine**2)) < 0.7 * np.sqrt(np.mean(coarse**2))

    def test_closing(self, validated):
        """The cavity is gone within one step of the exact time."""
        actual = self.fronts(100, 400)
        gone = np.flatnonzero(actual[:300] < 0.5 - 1e-12)[-1] + 2  # the gap opens again at 0.75
        label, close = "time the cavity closes, 400 steps", {"relative": False, **PLATES}
        validated(label, gone / 400, self.CLOSED, 1 / 400, **close)


class TestSteady:
    """A line of oil at the widest gap and cavitation at ambient: the film of the classic charts."""

    def test_order(self):
        """Against the grids' 3.57187 (eps 0.8): second order, 4.1e-3 at 48x4, 9.2e-4 at 96x8,
        7e-5 at 256x24.
        """
        rotation = ((r["slenderness"], r["eps"], r) for r in states.rows("rotation"))
        (wanted,) = (row["So_on_grids"] for *at, row in rotation if at == [1.0, 0.8])
        errors = []
        for mesh in ((48, 4), (96, 8), (256, 24)):
            ours = film(mesh, clearance=1e-5, grooves=LINE)
            load = math.hypot(*ours.steady(0.8, 0.0, 100.0)[:2])
            errors.append(abs(load / (200.0 * ours.bearing.force_scale * wanted) - 1.0))
        assert errors[0] > 3.0 * errors[1]
        assert errors[1] > 5.0 * errors[2]

    def test_memory_arrives_there(self):
        """Held in one place, the film of accepted steps ends as the steady one."""
        ours = film(grooves=LINE)
        for _ in range(60):
            ours.commit(0.7, 0.0, 0.0, 0.0, 20.0, 0.1)
        held = ours.trial(0.7, 0.0, 0.0, 0.0, 20.0, 0.1)[:, 0]
        np.testing.assert_allclose(held, ours.steady(0.7, 0.0, 20.0), rtol=1e-6)

    def test_without_a_groove(self):
        """A film that remembers nothing has a steady state without a groove."""
        assert np.isfinite(film(conserving=False).steady(0.5, 0.0, 1.0)).all()


def path(t, seed=0):
    """A smooth orbit (ex, ey, vx, vy) between eccentricities 0.1 and 0.9."""
    size, angle = 0.5 + 0.4 * math.sin(7.0 * t + seed), 3.0 * math.sin(2.0 * t + 2 * seed) + 2.0 * t
    rate, turn = 2.8 * math.cos(7.0 * t + seed), 6.0 * math.cos(2.0 * t + 2 * seed) + 2.0
    c, s = math.cos(angle), math.sin(angle)
    return size * c, size * s, rate * c - size * turn * s, rate * s + size * turn * c


def travelled(ours, steps=30, seed=0):
    """The film after a run, and its last state."""
    for step in range(steps + 1):
        ours.commit(*path(0.01 * step, seed), 20.0, 0.01 if step else 0.0)
    return ours, path(0.01 * steps, seed)


class TestMemory:
    @pytest.mark.parametrize("liner", [0.0, 1e-9])
    @pytest.mark.parametrize("ambient", [None, 5e3, 1e5])
    @pytest.mark.parametrize("grooves", [(), POCKET])
    def test_oil_is_kept(self, grooves, ambient, liner):
        """1e-10 of the oil in the gap at every step (1e-15 measured), content in [0, 1], P > lowest
        only if full.
        """
        ours = film(liner=liner, grooves=grooves, ambient=ambient)
        lowest = -(ambient or 0.0)
        cavitated = 0
        for step in range(120):
            t = 0.01 * step
            ours.commit(*path(t, 1), 20.0 * math.sin(3.0 * t), 0.01 if step else 0.0)
            assert ours.mass_defect <= 1e-10
            assert ours.content.min() >= 0.0
            assert ours.content.max() <= 1.0
            above = ours.pressure - lowest
            assert above.min() >= -1e-9 * above.max()
            assert np.abs(above * (1.0 - ours.content)).max() <= 1e-9 * above.max()
            cavitated += (ours.content < 1.0).sum()
        assert cavitated > 0 or ambient == 1e5  # which a liner's film hardly falls below

    def test_trial_leaves_it_alone(self):
        """Trials change neither content nor pressure, nor the steps that follow."""
        (one, state), (other, _) = (travelled(film(grooves=POCKET)) for _ in range(2))
        before = one.content.copy(), one.pressure.copy()
        for factor in (0.5, 1.0, -1.0):
            one.trial(*(factor * value for value in state), 10.0, 0.02)
        np.testing.assert_array_equal((one.content, one.pressure), before)
        for ours in (one, other):
            ours.commit(*path(0.31), 20.0, 0.01)
        np.testing.assert_allclose(one.content, other.content, atol=1e-12)

    @pytest.mark.parametrize("liner", [0.0, 1e-9])
    def test_trial_foretells_commit(self, liner):
        """On a straight path the trial is the accepted step, whose force is summed here from its
        pressure.
        """
        ours, (x, y, _, _) = travelled(film(liner=liner, grooves=POCKET, ambient=2e3))
        move = (x + 0.01, y - 0.02, 1.0, -2.0, 20.0, 0.01)
        foretold = ours.trial(*move)
        ours.commit(*move)
        of = ours.bearing
        area = 2.0 * of.radius * (2.0 * math.pi / 48) * of.length * 0.5 / 4
        along = -area * ours.pressure.sum(axis=1)
        force = along @ np.cos(ours.theta), along @ np.sin(ours.theta)
        np.testing.assert_allclose(foretold[:2, 0], force, rtol=1e-9)

    def test_reset(self):
        """A film that was reset answers as a new one."""
        (ours, _), fresh = travelled(film()), film()
        ours.reset()
        state = (0.5, 0.1, 1.0, 0.0, 10.0, 0.01)
        np.testing.assert_allclose(ours.trial(*state), fresh.trial(*state), rtol=1e-9, atol=1e-12)

    def test_cavity_is_remembered(self):
        """A gap that opened and closes again answers less than a full one: the cavity fills
        first.
        """
        ours, fresh = film(), film()
        for step in range(21):
            ours.commit(0.8 - 0.07 * step, 0.0, -7.0, 0.0, 0.0, 0.01 if step else 0.0)
        remembering, full = (
            abs(f.trial(-0.55, 0.0, 7.0, 0.0, 0.0, 0.01)[0, 0]) for f in (ours, fresh)
        )
        assert remembering < 0.7 * full


@pytest.mark.parametrize(
    ("liner", "conserving", "ambient", "grooves"),
    [
        (0.0, True, 2e3, POCKET),
        (0.0, True, None, ()),
        (1e-9, True, 2e3, POCKET),
        (1e-9, False, 2e3, POCKET),
        (0.0, False, None, LINE),
    ],
)
@pytest.mark.parametrize("elapsed", [1e-3, 1e-2])
def test_derivatives(liner, conserving, ambient, grooves, elapsed):
    """1e-5; central differences over 1e-6 of the state, which switches no cell here."""
    ours = film((48, 4), liner, conserving, grooves=grooves, ambient=ambient)
    ours, (x, y, _, _) = travelled(ours)
    state = np.array([x + 0.01, y - 0.02, 3.0, -2.0, 20.0])
    steps = 1e-6 * np.maximum(1.0, np.abs(state))
    actual = ours.trial(*state, elapsed)[:, 1:].copy()
    expected = slopes(lambda *at: ours.trial(*at, elapsed)[:, 0], state, steps)
    scale = np.abs(expected) + 1e-3 * np.linalg.norm(expected, axis=1, keepdims=True)
    assert np.all(np.abs(actual - expected) <= 1e-5 * scale)


class TestLimits:
    FLOODED = 1e9  # Pa: never cavitates here

    @pytest.mark.parametrize("eps", [0.2, 0.6])
    def test_short_full_film(self, eps, validated):
        """Sommerfeld's full film in a short bearing, L/D 0.02, where the finite length counts
        1e-3.
        """
        ours = film((192, 4), slenderness=0.02, ambient=self.FLOODED)
        scale = ours.bearing.force_scale / ours.bearing.axial * math.pi
        turned = ours.trial(eps, 0.0, 0.0, 0.0, 20.0, 0.01)[:, 0]
        squeezed = ours.trial(eps, 0.0, 3.0, 0.0, 0.0, 0.01)[:, 0]
        rest = 1.0 - eps**2
        wanted = scale * 10.0 * eps / rest**1.5
        validated("force of rotation", turned[1], wanted, 3e-3, unit="N", **SHORT)
        assert abs(turned[0]) < 1e-9 * turned[1]
        wanted = -scale * 3.0 * (1.0 + 2.0 * eps**2) / rest**2.5
        validated("force of squeeze", squeezed[0], wanted, 3e-3, unit="N", **SHORT)
        validated("shear integral", turned[2], 2.0 * math.pi / math.sqrt(rest), 1e-6, **SHORT)

    def test_turning_frame(self):
        """A full film feels only omega_J + omega_B - 2 gamma': a journal that turns, or a bearing
        under it that does.

        2e-3 is the grid's error (second order): the gap's advection and its storage are different
        sums.
        """
        ours = film((96, 8), ambient=self.FLOODED)
        journal, both = (
            ours.trial(0.6, 0.2, *motion, 0.01)[:2, 0]
            for motion in ((0.0, 0.0, 20.0), (10.0 * 0.2, -10.0 * 0.6, 0.0))
        )
        np.testing.assert_allclose(journal, both, rtol=2e-3)

    @pytest.mark.parametrize("liner", [0.0, 1e-9])
    def test_mirror(self, liner):
        """A mirrored path gives the mirrored force, and the same shear and flow."""
        answers = []
        for sign in (1.0, -1.0):
            ours = film(liner=liner, grooves=(Groove(),), ambient=2e3)
            for step in range(21):
                x, y, vx, vy = path(0.01 * min(step, 19))
                state = x, sign * y, vx, sign * vy, sign * 20.0
                if step < 20:
                    ours.commit(*state, 0.01 if step else 0.0)
            answers.append(ours.trial(*state, 0.005)[:, 0] * [1.0, sign, 1.0, 1.0])
        np.testing.assert_allclose(*answers, rtol=1e-8)

    def test_turned_bearing(self):
        """A bearing with its groove turned by one radian answers the turned state with the turned
        force.
        """
        motion, turn = np.array([0.5 + 0.3j, 2.0 - 1.0j]), np.exp(1j)
        plain, turned = (
            film(grooves=(Groove(angle=0.3 + a),)).trial(*(by * motion).view(float), 20.0, 0.01)
            for a, by in ((0.0, 1.0 + 0.0j), (1.0, turn))
        )
        plain, turned = plain[:, 0], turned[:, 0]
        assert complex(*turned[:2]) == pytest.approx(turn * complex(*plain[:2]), rel=1e-9)
        np.testing.assert_allclose(turned[2:], plain[2:], rtol=1e-9)

    @pytest.mark.parametrize("ambient", [None, 5e3])
    def test_no_time(self, ambient):
        """elapsed -> 0 is a limit, reached linearly."""
        ours, state = travelled(film(ambient=ambient))
        at_once = ours.trial(*state, 20.0, 0.0)[:, 0].copy()
        assert np.isfinite(at_once).all()
        for elapsed in (1e-12, 1e-9, 1e-6):
            soon = ours.trial(*state, 20.0, elapsed)[:, 0]
            np.testing.assert_allclose(soon, at_once, rtol=1e-8 + 30.0 * elapsed)

    @pytest.mark.parametrize("mesh", [(48, 4), (96, 8)])
    @pytest.mark.parametrize("rate", [3.0, -3.0])
    @pytest.mark.parametrize("liner", [0.0, 1e-11, 1e-9])
    def test_at_and_beyond_the_wall(self, mesh, rate, liner):
        """Finite, and the closing film on a rigid bearing pushes harder the nearer it is."""
        ours, _ = travelled(film(mesh, liner))
        near = (0.9, 0.99, 1.0 - 1e-4, 1.0 - 1e-6, 1.0 - 1e-9, 1.0)
        actual = [
            ours.trial(eps, 0.0, rate, 0.0, 20.0, 1e-3).copy() for eps in (*near, 1.1, 2.0, 10.0)
        ]
        assert np.isfinite(actual).all()
        if rate > 0.0 and liner == 0.0:
            assert (np.diff([0.0, *(a[0, 0] for a in actual[: len(near)])]) < 0.0).all()

    def test_not_finite_answers_nan(self):
        """A trial at nan answers nan, and the next one is a film again."""
        ours, state = travelled(film())
        assert np.isnan(ours.trial(math.nan, 0.0, 0.0, 0.0, 1.0, 0.01)).all()
        assert np.isfinite(ours.trial(*state, 20.0, 0.01)).all()


class TestLiner:
    def test_next_to_rigid(self):
        """A liner of next to no compliance is the rigid bearing."""
        rigid, soft = (travelled(film(liner=k, grooves=POCKET))[0] for k in (0.0, 1e-17))
        state = (*path(0.31), 20.0, 0.01)
        np.testing.assert_allclose(soft.trial(*state), rigid.trial(*state), rtol=1e-4, atol=1e-7)

    @pytest.mark.parametrize("conserving", [True, False])
    def test_load(self, conserving):
        """At L/D 0.5, eps 0.9 and 0.10 to 0.15 of the clearance at the peak, the load falls by 28
        to 50 %.
        """
        rigid, *loads = (
            math.hypot(
                *film(
                    (96, 8), liner, conserving, slenderness=0.5, clearance=1e-5, grooves=LINE
                ).steady(0.9, 0.0, 100.0)[:2]
            )
            for liner in (0.0, 1e-14, 1.2e-14, 2e-14)
        )
        falls = [1.0 - load / rigid for load in loads]
        assert falls == sorted(falls)
        assert 0.28 < falls[0] < falls[-1] < 0.5

    def test_pressure_outlasts_the_motion(self):
        """At once a liner answers with the pressure it holds, whatever the rate; later with that of
        the motion.
        """
        ours, (x, y, vx, vy) = travelled(film(liner=1e-9, grooves=POCKET))
        there, at_once, later = (
            ours.trial(x, y, way * vx, way * vy, 20.0, elapsed)[:2, 0].copy()
            for way, elapsed in ((1.0, 0.0), (-1.0, 0.0), (-1.0, 1e-2))
        )
        np.testing.assert_allclose(at_once, there, rtol=1e-6)
        assert np.abs(later - there).max() > 0.1 * np.abs(there).max()


@pytest.mark.parametrize(
    ("refused", "message"),
    [
        (partial(film, roughness=1e-6), "roughness"),
        (partial(film, conserving=False, cavitation="gumbel"), "gumbel"),
        (partial(film, liner=-1.0), "liner"),
        (partial(film, (8, 2)), "too coarse"),
        (partial(film().steady, 0.5, 0.0, 1.0), "needs a groove"),
        (partial(film().trial, 0.5, 0.0, 0.0, 0.0, 1.0, -0.1), "elapsed"),
        (partial(film().commit, math.nan, 0.0, 0.0, 0.0, 1.0, 0.1), "ex"),
    ],
)
def test_refusals(refused, message):
    """Options without support, no steady state, and time that runs backwards."""
    with pytest.raises(ValueError, match=message):
        refused()


def test_grooves_take_whole_cells():
    """A groove covers the columns and rows nearest to its extent; the grid begins on the first
    one's line.
    """
    grooves = Groove(angle=1.0), Groove(angle=3.0, width=0.4, length=0.5)
    ours = film((64, 8), grooves=grooves)
    fixed = ours._state[0] == FIXED
    assert ours.theta[0] == 1.0
    assert fixed[0].all()
    assert fixed[1:].sum() == 5 * 4
    assert np.abs(ours.theta[1:][fixed[1:, 0]] - 3.0).max() < 0.3
