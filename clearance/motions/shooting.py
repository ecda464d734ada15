"""Newton's method on the map of a section, and on its slow states alone."""

from dataclasses import dataclass

import numpy as np

from clearance.motions.maps import NotPeriodic, Place, Section

LIMIT = 0.3  # natural sizes: longest step of Newton's method
ROUNDS = 12  # of it, at most
STRAIGHT = 0.1  # step over the one before below which the derivative is used again
STEADY_ROUNDS = 25  # of the method for slow states, at most
SLOW_STEP = 1e-3  # natural sizes: of its first differences
SLOW_LIMIT = 3.0  # natural sizes: its longest step


@dataclass(frozen=True)
class Fixed:
    """A fixed point of a section's map. derivative: of the map there; spread: errors of it, see
    `Section.refined`; change: what is left of P(y) - y [natural sizes]; distance: the next step of
    Newton's method, how far away the fixed point lies.
    """

    passage: Place
    derivative: np.ndarray
    spread: np.ndarray
    change: float
    distance: float

    @property
    def multipliers(self) -> np.ndarray:
        """Floquet multipliers, the largest first."""
        return multipliers(self.derivative, self.spread)[0]

    @property
    def errors(self) -> np.ndarray:
        """Errors of the multipliers, in their order."""
        return multipliers(self.derivative, self.spread)[1]


def multipliers(derivative: np.ndarray, spread: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues, the largest first, of a pair the one above the real axis, and their errors.

    With left and right eigenvectors w and v, w v = 1, the error is sum_j |w spread_j v_j|. Each
    column j comes from runs of its own, whose errors are independent. An error in one of the two
    runs moves the central difference as much as the spread. A spread may have several such matrices
    side by side. Infinite where there are too few eigenvectors.
    Source: Golub and Van Loan, Matrix Computations, 4th ed. 2013, 7.2.
    """
    values, vectors = np.linalg.eig(derivative)
    values = values.astype(complex)
    order = np.lexsort((-values.imag, -np.abs(values).round(12)))
    values, vectors = values[order], vectors[:, order]
    try:
        lefts = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return values, np.full(values.size, np.inf)
    sides = spread.shape[1] // values.size
    return values, np.abs((lefts @ spread) * np.tile(vectors.T, sides)).sum(axis=1)


def newton(section: Section, passage: Place, tolerance: float) -> Fixed:
    """The fixed point near a passage: (P'(y) - 1) dy = y - P(y), until dy is below the tolerance
    [natural sizes]. That step is taken too, so that what is left is far below the error of the
    integration.

    The derivative is used again where the steps shrink fast without a new one.
    Raises NotPeriodic where the steps do not shrink, or a motion on the way cannot be continued;
    NotSolved where the first one cannot.
    """
    derivative, last = None, np.inf
    change, _ = section.change(passage)
    with section.motion.trials():
        for _ in range(ROUNDS + 1):
            base = section.vector(passage)
            if derivative is None:
                derivative = section.derivative(passage, base + change)
            step = _solved(np.eye(base.size) - derivative, change)
            length = float(np.abs(step).max())
            if last < tolerance:
                both = section.refined(passage, base + change)
                return Fixed(passage, *both, float(np.abs(change).max()), length)
            if length > 2.0 * last and length > LIMIT:
                break
            if length > max(STRAIGHT * last, tolerance):
                derivative = None
            passage = section.passage(base + step * (LIMIT / max(length, LIMIT)), passage)
            change, _ = section.change(passage)
            last = length
    raise NotPeriodic(
        f"Newton's method stays {last:.2g} of the natural sizes away from a periodic motion"
    )


def _solved(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Solution of a linear system. Raises NotPeriodic for a singular one."""
    try:
        return np.linalg.solve(matrix, vector)
    except np.linalg.LinAlgError:
        raise NotPeriodic("the periodic motion is not isolated: a multiplier is 1") from None


def slow_states(section: Section) -> list[int]:
    """Places in the section's coordinates of states that may need many turns. These are warmings,
    states of drives, and the speed of a drive that depends on its load.
    """
    layout = section.motion.mechanism.layout
    names = {n for n in layout.first_order if n.endswith("/warming") or n.startswith("drives/")}
    if section.angle is not None:
        names.add(layout.names[section.angle + layout.size])
    return [i for i, state in enumerate(section.states) if layout.names[state] in names]


def settled(
    section: Section, passage: Place, slow: list[int], tolerance: float, report=lambda text: None
) -> Place:
    """A passage whose slow states come back, the fast ones carried along.

    g(z) = z(end) - z(start) of the second of two periods that both begin with the slow states z;
    Broyden's method on g, which is the secant method for one slow state, from a derivative by
    differences. It ends where its step, the distance from the solution g / (1 - mu), is below the
    tolerance [natural sizes].
    Raises NotPeriodic where it does not converge.
    """
    here = passage

    def change(z: np.ndarray) -> np.ndarray:
        nonlocal here
        for _ in range(2):
            vector = section.vector(here)
            vector[slow] = z
            here = section.next(section.passage(vector, here))
        return section.vector(here)[slow] - z

    z = section.vector(passage)[slow]
    g = change(z)
    slope = np.zeros((z.size, z.size))
    with section.motion.trials():
        for i in range(z.size):
            step = np.zeros(z.size)
            step[i] = SLOW_STEP
            slope[:, i] = (change(z + step) - g) / SLOW_STEP
        for _ in range(STEADY_ROUNDS):
            step = -_solved(slope, g)
            length = float(np.abs(step).max())
            report(f"slow states {length:.2g} away")
            if length < tolerance:
                vector = section.vector(here)
                vector[slow] = z
                return section.passage(vector, here)
            step *= min(1.0, SLOW_LIMIT / length)
            z = z + step
            before, g = g, change(z)
            slope += np.outer(g - before - slope @ step, step) / (step @ step)
    raise NotPeriodic(
        f"the slow states stay {length:.2g} of their natural sizes away from a steady motion"
    )
