"""The film with memory: oil is conserved through cavitation, and the bearing may have an elastic
liner.

The frame is that of the *bearing*, where cavitated oil stays where it is, with theta from the
bearing's own x axis. The journal's centre is at (ex, ey) c and moves at (vx, vy) c, and p = mu
(R/c)^2 P as in `clearance.film.bearing`:

    d_theta(H^3 d_theta P) + (R/L)^2 d_zeta(H^3 d_zeta P) = 6 spin d_theta(f H) + 12 d_t(f H)
    P >= lowest,  0 <= f <= 1,  (P - lowest) (1 - f) = 0
    H = 1 - ex cos(theta) - ey sin(theta) + h_B + h_J + kappa p / c

spin = omega_J - omega_B; f is the content, the share of the gap that holds oil. At the ends and in
the grooves the pressure is given and f = 1. The liner is a Winkler foundation: it yields in
proportion to the pressure above ambient (kappa in m/Pa). H is the gap of the unloaded bearing at
ambient pressure. So the journal may pass the wall: the film goes over into dry contact on the
liner. Its own rate stands in d_t(f H). Where it presses on the ends the solids bear there. Oil that
the pressure thickens takes its reduced pressure as P on the left side, see
`clearance.film.piezo`.

h_B(theta) and h_J(theta - a) are worn depths over c of bearing and journal, a the angle of the
journal against the bearing. The journal's turn on, d_t h_J = -spin h_J': with the drag of H they
count with +6 spin h_B' and -6 spin h_J'.

Finite volumes on a uniform grid over half the length. A cell has one unknown, P - lowest where it
is full and f where it is cavitated. A Newton step switches cells, and between switches the rigid
problem is linear. Every matrix met has a positive diagonal that dominates its column (an M matrix),
so a band LU needs no pivoting. The ring is folded, columns 0, n-1, 1, n-2, ..., which keeps the
band at twice the cells over the half length.

Sources: Jakobsson and Floberg (1957) and Olsson (1965), the condition. Elrod (1981), one unknown
per cell. Woloszynski, Podsiadlo and Stachowiak, Tribology Letters 58 (2015), Newton steps for it.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from clearance.film.bearing import (
    DOUBTFUL,
    RING,
    WET,
    Bearing,
    Groove,
    check_drag,
    check_mesh,
    coarseness,
    too_coarse,
)
from clearance.film.control_volumes import CAVITATED, FIXED, FULL, VOLUME, Mesh, State, System
from clearance.film.film_answer import Answer, respond
from clearance.film.oil_balance import LIMIT, Flow, Past, inflow, lift_off, settle, size_of, sweep
from clearance.film.summits import NONE, summits_of
from clearance.laws.law import BoundLaw
from clearance.values import checks
from clearance.values.algebra import each

# shortest time since the last moment, in units of the time in which the motion changes the film
INSTANT = 1e-9


class Moment(NamedTuple):
    """Motion of the journal some time after the last accepted moment.

    ex, ey: its centre over c; vx, vy: its rate [1/s] as seen from the turning bearing; spin
    [rad/s]; elapsed [s]; angle of a worn journal against the bearing. lift: of the gap all around,
    over c; lift_rate [1/s].
    """

    ex: float
    ey: float
    vx: float
    vy: float
    spin: float
    elapsed: float
    angle: float = 0.0
    lift: float = 0.0
    lift_rate: float = 0.0


def _over(depths: Sequence[float] | None, clearance: float) -> np.ndarray | None:
    """Worn depths over the clearance, the first once more behind the last; None where there is
    none.
    """
    if depths is None or not any(depths):
        return None
    return np.append(depths, depths[0]) / clearance


def _at(depths: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Depths at angles, straight between nodes."""
    node = angle / (2.0 * math.pi) * (depths.size - 1) % (depths.size - 1)
    return np.interp(node, np.arange(depths.size), depths)


class MemoryFilm:
    """One joint's film with memory: the content, and the liner's pressure, of the last accepted
    moment.

    bearing: its grooves are at angles from the bearing's own x axis; a conserving film does not
        read `cavitation`;
    mesh: cells around and over half the length; liner: compliance [m/Pa], 0 for a rigid bearing;
        conserving: False leaves the memory of the content out (P >= lowest where P and its slope
        vanish: Swift-Stieber); outline, journal: worn depths [m] of bearing and journal at equal
        angles of their bodies' frames, None where unworn; drag: "ring" where cavities drag as if
        full, "wet" where they do with their content; grading: of the cells, towards the
        first angle (0 to 1) and towards the ends, 0: equal ones; asperity: law of rough surfaces
        that touch, of a composite roughness [m], in a steady film. Its pressure is in the forces.

    asperity_load: normal load of the asperities in the last steady film [N].
    Fields of the last accepted moment: content (n, m) and pressure above ambient [Pa] (n, m). They
    stand at theta [rad] (n,) and axial, z from the middle [m] (m,). mass_defect: oil made or lost
    in the last commit, over the oil in the gap.
    iterations: linear systems of the last call. The grid begins at the first groove, so that its
        line is met. Other grooves take the nearest columns. A groove's width and length are rounded
        to full cells.

    Raises ValueError for asperities without a liner, for a mesh that is too coarse and for flow
    factors (bearing.roughness). A film that is not conserving raises it for another condition than
    "reynolds".
    """

    def __init__(
        self,
        bearing: Bearing,
        mesh: tuple[int, int] = (96, 8),
        liner: float = 0.0,
        conserving: bool = True,
        outline: Sequence[float] | None = None,
        journal: Sequence[float] | None = None,
        drag: str = WET,
        grading: tuple[float, float] = (0.0, 0.0),
        asperity: BoundLaw | None = None,
        roughness: float = 0.0,
    ):
        n, nz = check_mesh(mesh)
        if bearing.roughness > 0.0:
            raise ValueError(
                f"bearing: roughness {bearing.roughness!r} is not supported by the film with "
                f"memory: "
                "its flow factors are those of a film without"
            )
        if not conserving and bearing.cavitation in ("gumbel", "none"):
            raise ValueError(
                f"bearing: cavitation {bearing.cavitation!r} is not supported by the film with "
                f"memory: "
                "without conservation it must be 'reynolds'"
            )
        self.bearing = bearing
        self.conserving = bool(conserving)
        self.filled = check_drag("film with memory", drag) == RING
        self.liner = checks.non_negative("liner", liner)
        self.grading = grading
        self.summits = NONE if asperity is None else self._summits(asperity, roughness)
        self.iterations, self.mass_defect, self.asperity_load = 0, 0.0, 0.0
        self._lay(n, nz)
        self._outlines = [_over(depths, bearing.clearance) for depths in (outline, journal)]
        self._turn(0.0)
        self.reset()

    def _summits(self, asperity: BoundLaw, roughness: float) -> np.ndarray:
        """The table of the asperities, see film/summits.py."""
        checks.positive("roughness", roughness)
        if self.liner == 0.0:
            raise ValueError("film with memory: asperities press a liner in; give a liner")
        return summits_of(asperity, roughness, self.liner, self.bearing.clearance)

    def _lay(self, n: int, nz: int) -> None:
        """The grid and the memory that the kernels work in."""
        around, along = self.grading
        start = self.bearing.grooves[0].angle if self.bearing.grooves else 0.0

        def angle(turns):
            return start + 2.0 * math.pi * turns - around * each(math.sin, 2.0 * math.pi * turns)

        self.theta = angle(np.arange(n) / n)
        edges = angle((np.arange(n + 1) - 0.5) / n)
        self._midway = angle((np.arange(n) + 0.5) / n)
        faces = np.linspace(0.0, 0.5, nz + 1)
        if along > 0.0:
            faces = 0.5 * each(math.tanh, 2.0 * along * faces) / math.tanh(along)
        depth = np.diff(faces)
        middle = 0.5 * (faces[1:] + faces[:-1])
        # the flow out of the end is exact for the parabola of a short bearing (its cell means too)
        to_end = 0.5 * depth[-1] * (1.0 - 2.0 * depth[-1] / 3.0)
        self.axial = self.bearing.length * middle
        width = np.diff(edges)
        half = 0.5 * np.diff(edges)
        ring = np.column_stack(
            [f(at) for at in (self.theta, self._midway) for f in (np.cos, np.sin)]
        )
        column = np.arange(n)
        self._mesh = Mesh(
            ring,
            np.where(2 * column < n, 2 * column, 2 * (n - column) - 1),
            worn=np.zeros((n, 4)),
            width=width,
            step=np.diff(angle(np.arange(n + 1) / n)),
            depth=depth,
            apart=np.append(np.diff(middle), to_end),
            weight=self.bearing.axial,
            mean=np.sin(half) / half,
            soft=self.liner * self.bearing.pressure_scale / self.bearing.clearance,
            oil=self.bearing.oil,
            lowest=self.bearing.lowest,
            carried=float(self.conserving),
            filled=self.filled,
            summits=self.summits,
        )
        layers = nz if self._mesh.soft > 0.0 else 1
        self._system = System(
            np.zeros((n, layers, 11)),
            np.zeros((n, nz + 1 if layers == nz else 1, 13)),
            np.zeros((n, nz + 1, 5)),
            np.zeros((n, nz + 1)),
            np.zeros((n * nz, 4 * nz + 1)),
            np.zeros((n * nz, 1)),
        )
        self._right = np.zeros((n * nz, 5))
        self._base = np.zeros((n, nz))
        self._growth = np.zeros((n, nz))
        self._scales = np.array(self.bearing.scales)
        self._fixed = np.full((n, nz), math.nan)
        for groove in self.bearing.grooves:
            self._cut(groove)
        self._system.least[:, :nz] = np.nan_to_num(self._fixed)
        self._system.least[:, nz] = -self._mesh.lowest

    def _turn(self, angle: float, lift: float = 0.0) -> None:
        """Depths over c on the grid, the journal turned by an angle against the bearing; lift: what
        is added all around.
        """
        bearing, journal = self._outlines
        worn = self._mesh.worn
        if bearing is None and journal is None:
            worn[:, :3] = lift
            return
        face = self._midway
        worn[:] = 0.0
        for depths, shift in ((bearing, 0.0), (journal, angle)):
            if depths is not None:
                worn[:, 0] += _at(depths, self.theta - shift)
                worn[:, 1] += _at(depths, face - shift)
        if journal is not None:
            on_faces = _at(journal, face - angle)
            worn[:, 3] = on_faces - np.roll(on_faces, 1)
        ends = worn[:, 1] + np.roll(worn[:, 1], 1)
        worn[:, 2] = (ends + 4.0 * worn[:, 0]) / 6.0
        worn[:, :3] += lift

    def _sweep(self, now: Moment) -> None:
        """The rate of the rigid gap's volumes, see `sweep`, and that of the lift."""
        sweep((now.vx, now.vy), now.spin, self.content, self._mesh, self._base)
        self._base += 12.0 * self._mesh.width[:, None] * now.lift_rate * self.content

    def _cut(self, groove: Groove) -> None:
        """Fix P - lowest in the cells of a groove."""
        n, nz = self._fixed.shape
        width = 2.0 * math.pi / n
        middle = round((groove.angle - self.theta[0]) / width)
        beside = round(0.5 * groove.width / width)
        columns = np.arange(middle - beside, middle + beside + 1) % n
        layers = np.sum(self.axial <= 0.5 * groove.length * self.bearing.length)
        self._fixed[columns, : max(1, layers)] = (
            groove.pressure / self.bearing.pressure_scale - self._mesh.lowest
        )

    def reset(self) -> None:
        """Full of oil, at ambient pressure."""
        grooved = np.isfinite(self._fixed)
        kind = np.where(grooved, FIXED, FULL)
        p = np.where(grooved, self._fixed, -self._mesh.lowest)
        self._state = State(kind, p, np.ones(kind.shape))
        self.content = np.ones(kind.shape)
        self._held = p.copy()
        # the cells' volumes, not known before the first accepted moment
        self._stored = np.zeros(kind.shape)
        self._begun, self.thinnest = False, math.inf

    @property
    def pressure(self) -> np.ndarray:
        """Pressure above ambient [Pa] at the last accepted moment, (n, m)."""
        return (self._held + self._mesh.lowest) * self.bearing.pressure_scale

    @property
    def gap(self) -> np.ndarray:
        """Gap over c at the last answer or accepted moment, the mean of each cell, (n, m)."""
        kind = self._state.kind
        volume = self._system.cell[:, : kind.shape[1], VOLUME]  # without the layer of the ends
        return np.array(np.broadcast_to(volume, kind.shape)) / self._mesh.width[:, None]

    def _since(self, now: Moment) -> float:
        """elapsed, not below INSTANT of the time in which the motion changes the film.

        Raises ValueError for a negative one, and for asperities.
        """
        if self.summits.size > 0:
            raise ValueError("film with memory: asperities are of a steady film")
        if not now.elapsed >= 0.0:
            raise ValueError(f"elapsed must not be negative, got {now.elapsed!r}")
        return max(now.elapsed, INSTANT / max(math.hypot(now.vx, now.vy) + abs(now.spin), 1.0))

    def _restart(self) -> None:
        """Start the next solution from the last accepted moment."""
        kind, p, content = self._state
        free = kind != FIXED
        kind[free] = np.where(self.content[free] < 1.0, CAVITATED, FULL)
        p[:], content[:] = self._held, self.content

    def _settled(self, attempt, ex: float, ey: float, spin: float) -> None:
        """Make the attempt, and again from the last accepted moment where the last answer is no
        good start; with a liner also from an opened film.

        Raises RuntimeError if that does not settle the film either.
        """

        def opened():
            size = size_of(6.0 * spin, self._base, self._mesh)
            lift_off((ex, ey), size, self._state, self._mesh)

        for begin in (None, self._restart, *([opened] if self.liner > 0.0 else [])):
            if begin is not None:
                begin()
            if (count := attempt()) > 0:
                self.iterations = count
                return
        self.iterations = LIMIT + len(self.theta)
        raise RuntimeError(
            f"film with memory: the cavity's boundary did not settle within {self.iterations} "
            f"linear systems at ex = {ex!r}, ey = {ey!r}, spin = {spin!r} 1/s: a smaller step may "
            f"help"
        )

    def trial(self, *moment: float) -> np.ndarray:
        """The film's answer at a moment, see `Moment`; the memory stays as it is.

        Returns (4, 6). The rows are force_x, force_y on the journal [N], shear, and side_flow out
        of the film at both ends [m3/s]. shear is the integral of 1/H over the wetted area, out of
        2 pi; a cavitated cell counts with its content (streamlets). The columns are the value and
        d/d(ex, ey, vx, vy, spin), with every cell left full or cavitated as it is.

        The content is stored at 12 (H (f - old) / elapsed + old dH/dt), the implicit Euler step of
        a straight path to
        here: full cells depend on the rate alone as elapsed -> 0. A liner, by contrast, keeps its
            pressure then. Anything that is not finite answers nan.
        Raises ValueError for elapsed < 0, RuntimeError for an unsettled film.
        """
        out = np.full((4, 6), math.nan)
        now = Moment(*moment)
        if not math.isfinite(sum(now)):
            return out
        hold = 12.0 / self._since(now)
        self._turn(now.angle, now.lift)
        self._sweep(now)
        flow = Flow(6.0 * now.spin, hold, hold)
        self._respond(now[:2], flow, self.content, out, now.spin)
        return out

    def _respond(self, motion, flow, old, out, spin) -> None:
        """`respond` on this film's arrays, its balance in rate form."""
        past = Past(old, self._base, self._growth, self._held, self._stored, True)
        answer = Answer(self._scales, out, self._right)
        film = self._state, past, flow, self._mesh, self._system
        self._settled(lambda: respond(motion, *film, answer), *motion, spin)

    def steady(
        self, ex: float, ey: float, spin: float, vx: float = 0.0, vy: float = 0.0
    ) -> np.ndarray:
        """force_x, force_y, shear, side_flow as in `trial`, (4,), of a film that no longer changes,
        or whose rigid gap changes at a constant rate while its liner stands still.

        Raises ValueError where nothing determines the content: a conserving film without a groove;
        and for a worn journal that turns.
        """
        if self._outlines[1] is not None and spin != 0.0:
            raise ValueError("a film on a worn journal that turns is never steady")
        if self.conserving and not self.bearing.grooves:
            raise ValueError(
                "a steady film with memory needs a groove: without one its oil depends on the past"
            )
        out = np.full((4, 6), math.nan)
        if math.isfinite(ex + ey + spin):
            sweep((vx, vy), spin, np.ones(self.content.shape), self._mesh, self._base)
            # oil that nothing moves counts as full; too weak to be seen where the flow carries it
            weak = 1e-9 * max(abs(spin), 1.0)
            self._respond(
                (ex, ey), Flow(6.0 * spin, weak, 0.0), np.ones(self.content.shape), out, spin
            )
            if self.summits.size > 0:
                out[:2, 0] += self._asperities(ex, ey)
        return out[:, 0]

    def _asperities(self, ex: float, ey: float) -> np.ndarray:
        """Force of the asperities on the journal [N]: they lift the surfaces from the gap that the
        oil alone would leave.
        """
        mesh = self._mesh
        p = self._state.p + self._mesh.lowest
        ring = mesh.ring[:, :2]
        smooth = 1.0 - mesh.mean * (ring @ (ex, ey)) + mesh.worn[:, 2]
        pressure = (self.gap - smooth[:, None] - mesh.soft * p) / mesh.soft
        load = self._scales[0] * mesh.width * (pressure @ (2.0 * mesh.depth))
        self.asperity_load = float(load.sum())
        return -load @ ring

    def commit(self, *moment: float) -> None:
        """Accept a moment: the conservative step from the last one, then remember content, gap and
        pressure.

        The rate counts in the first step after `reset` alone (the gap
        before is not known). Raises ValueError for what is not finite or elapsed < 0, RuntimeError
        for an unsettled film.
        """
        now = Moment(*moment)
        for name, value in now._asdict().items():
            checks.finite(name, value)
        since = self._since(now)
        hold = 12.0 / since
        first = not self._begun or since > now.elapsed
        self._turn(now.angle, now.lift)
        self._sweep(now)
        if not first:
            self._base[:] = 0.0
        flow = Flow(6.0 * now.spin, hold, hold)
        past = Past(self.content, self._base, self._growth, self._held, self._stored, first)
        film = self._state, past, flow, self._mesh, self._system
        self._settled(lambda: settle(now[:2], *film), *now[:2], now.spin)
        self._remember(flow)

    def _remember(self, flow: Flow) -> None:
        """The settled state becomes the last accepted moment."""
        kind, p, content = self._state
        volume = np.array(
            np.broadcast_to(self._system.cell[:, : kind.shape[1], VOLUME], kind.shape)
        )
        self._held = np.maximum(p, 0.0)
        if self.conserving:
            free = kind != FIXED
            was = self.content * (volume - self._growth) - self._base / flow.hold
            depth = np.broadcast_to(self._mesh.depth, kind.shape)[free]
            gained = np.sum(depth * (content * volume - was)[free])
            entered = inflow(self._state, flow, self._mesh, self._system) / flow.hold
            self.mass_defect = abs(gained - entered) / max(
                np.sum(depth * (content * volume)[free]), 1e-300
            )
            self.content = np.clip(content, 0.0, 1.0)
        self._stored, self._begun = volume, True
        self.thinnest = min(self.thinnest, float(self.gap[kind != FIXED].min()))

    def doubt(self, eccentricity_ratio: float) -> str | None:
        """Objection to the mesh after a run up to an eccentricity ratio.

        With a liner the thinnest film counts. With n cells in sqrt(2 H) rad some 0.12 / n^2 of the
        load are missed, at most what the film adds to a contact.
        """
        cells = len(self.theta)
        if self.liner == 0.0:
            return coarseness(cells, eccentricity_ratio, self.bearing.slenderness)
        inside = cells * math.sqrt(2.0 * self.thinnest) / (2.0 * math.pi)
        added = 2.0 * self.thinnest / (self.thinnest + max(eccentricity_ratio - 1.0, 0.0))
        if (error := min(0.12 / inside**2, added)) <= DOUBTFUL:
            return None
        finer = math.ceil(cells * math.sqrt(0.12 / DOUBTFUL) / inside / 16.0) * 16
        where = f"for a film of {self.thinnest:.3g} of the clearance"
        return too_coarse(cells, where, error, finer)
