"""Frames of bodies, coordinates of joints, and quantities of a joint with clearance.

Group: evidence

Answers: where angles, coordinates and forces of scenes and result files are measured; no source
shows it.

Reproduced: the conventions of bodies, of a slide and of a hinge with clearance.

Assumed: nothing; the clearance is drawn a hundred times too large.

Not comparable: a drawing, not a result.
"""

from dataclasses import dataclass

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.figures import sheet
from matplotlib.patches import Arc, Circle, Polygon

INK, GROUND, BODY_A, BODY_B, LOAD = "#222222", "#777777", "#1f77b4", "#d95f02", "#2ca02c"
ARROW = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "lw": 1.4}
BOTH = ARROW | {"arrowstyle": "<|-|>", "lw": 1.0}


def arrow(axes, start, end, text="", at=(0.0, 0.0), colour=INK, style=ARROW) -> None:
    """An arrow between two points, and a text beside its end or, of two heads, its middle."""
    start, end = np.asarray(start), np.asarray(end)
    axes.annotate("", end, start, arrowprops=style | {"color": colour})
    point = 0.5 * (start + end) if style is BOTH else end
    axes.text(*(point + at), text, color=colour, ha="center", va="center", size=9)


def direction(angle) -> np.ndarray:
    """The unit vector at an angle [rad]."""
    return np.array([np.cos(angle), np.sin(angle)])


def frame(axes, origin, angle, names, colour, size=0.5) -> None:
    """Two axes at an origin."""
    for turned, name in zip((0.0, np.pi / 2), names, strict=True):
        way = direction(angle + turned)
        arrow(axes, origin, origin + size * way, name, 0.13 * way, colour)


def angle_mark(axes, centre, radius, begin, end, text) -> None:
    """An arc from one angle to another [deg], with its name at the middle."""
    axes.add_patch(Arc(centre, 2 * radius, 2 * radius, theta1=begin, theta2=end, color=INK))
    axes.text(
        *(centre + (radius + 0.14) * direction(np.radians(0.5 * (begin + end)))), text, size=9
    )


@dataclass(frozen=True)
class Slope:
    """Coordinates in a turned frame."""

    origin: np.ndarray
    along: np.ndarray
    across: np.ndarray

    def __call__(self, u: float, v: float) -> np.ndarray:
        """The point at u along and v across."""
        return self.origin + u * self.along + v * self.across


def draw_bodies(axes) -> None:
    """A body a in the fixed frame, and a block b that slides along an axis of it."""
    axes.set_title("bodies and a joint without clearance", size=10)
    frame(axes, np.zeros(2), 0.0, ("x", "y"), GROUND, 0.7)
    origin, turn = np.array([1.1, 0.35]), np.radians(25.0)
    along, across = direction(turn), direction(turn + np.pi / 2)
    corners = [(-0.3, -0.25), (3.0, -0.25), (3.0, 0.12), (-0.3, 0.12)]
    outline = [origin + u * along + v * across for u, v in corners]
    axes.add_patch(Polygon(outline, closed=True, fc="#dbe9f6", ec=BODY_A, lw=1.2))
    frame(axes, origin, turn, ("", ""), BODY_A)
    axes.plot([origin[0], origin[0] + 0.9], 2 * [origin[1]], color=GROUND, lw=0.8, ls=":")
    angle_mark(axes, origin, 0.6, 0, 25, "theta")
    at = Slope(origin, along, across)
    axes.plot(*at(1.15, -0.07), "o", color=BODY_A, ms=6)
    style = {"arrowstyle": "-", "lw": 0.6, "color": BODY_A}
    words = {"size": 8, "color": BODY_A, "arrowprops": style}
    axes.annotate("centre of mass:\nx, y of the body", at(1.15, -0.07), (2.5, 0.1), **words)
    block = [at(u, v) for u, v in ((2.2, 0.12), (2.8, 0.12), (2.8, 0.62), (2.2, 0.62))]
    axes.add_patch(Polygon(block, closed=True, fc="#fde3cf", ec=BODY_B, lw=1.2))
    for point, name, colour in ((at(1.6, 0.0), "a", BODY_A), (at(2.5, 0.4), "b", BODY_B)):
        axes.plot(*point, "s", color=colour, ms=4)
        axes.text(*(point - (0.16, 0.04)), name, color=colour)
    for ends in (((1.6, 0.0), (1.6, 1.0)), ((2.5, 0.4), (2.5, 1.0))):
        axes.plot(*zip(*(at(*e) for e in ends), strict=True), color=GROUND, lw=0.8, ls=":")
    for ends in (((1.6, 0.0), (3.3, 0.0)), ((2.5, 0.4), (3.3, 0.4))):
        axes.plot(*zip(*(at(*e) for e in ends), strict=True), color=GROUND, lw=0.8, ls=":")
    arrow(axes, at(1.6, 0.95), at(2.5, 0.95), "along", 0.14 * across, style=BOTH)
    arrow(axes, at(3.25, 0.0), at(3.25, 0.4), "across", 0.32 * along, style=BOTH)
    axes.text(*at(2.1, 0.25), "body b", color=BODY_B, size=9, ha="right")
    axes.text(*(origin - 0.42 * across), "body a", color=BODY_A, size=9)
    axes.set(xlim=(-0.3, 4.6), ylim=(-0.6, 3.0))


def draw_clearance(axes) -> None:
    """The journal in its bearing, with the line of centres."""
    axes.set_title("a hinge with clearance (magnified)", size=10)
    radius, clearance, eccentricity, phase = 1.0, 0.45, 0.33, np.radians(-38.0)
    way, side = direction(phase), direction(phase + np.pi / 2)
    centre = eccentricity * way
    axes.add_patch(Circle((0, 0), radius + clearance + 0.25, fc="#dbe9f6", ec="none"))
    axes.add_patch(Circle((0, 0), radius + clearance, fc="white", ec=BODY_A, lw=1.5))
    axes.add_patch(Circle(centre, radius, fc="#fde3cf", ec=BODY_B, lw=1.5))
    frame(axes, np.zeros(2), 0.0, ("x", "y"), GROUND, 0.62)
    axes.plot(*(np.outer(way, (-0.3, 2.25))), color=INK, lw=0.8, ls="-.")
    axes.text(*(2.32 * way), "line of\ncentres", size=8, va="top")
    axes.plot(0, 0, "o", color=BODY_A, ms=5)
    axes.plot(*centre, "o", color=BODY_B, ms=5)
    arrow(axes, (0, 0), centre, "e", (-0.19, -0.02), INK)
    inner = centre + radius * way
    arrow(axes, inner, (radius + clearance) * way, style=BOTH)
    axes.annotate(
        "gap = c - e", inner, (1.85, -0.2), size=9, arrowprops={"arrowstyle": "-", "lw": 0.6}
    )
    arrow(axes, centre, centre + radius * direction(3.4), "R", (0.3, 0.22), BODY_B)
    arrow(axes, (0, 0), (radius + clearance) * direction(1.9), "R + c", (0.3, -0.25), BODY_A)
    arrow(axes, centre, centre + 0.6 * way, "film_radial", (-0.1, -0.14), LOAD)
    arrow(axes, centre, centre + 0.6 * side, "film_tangential", (0.28, 0.12), LOAD)
    axes.text(-1.85, -1.35, "bearing,\nbody a", color=BODY_A, size=9, ha="center")
    axes.text(0.0, -0.95, "journal,\nbody b", color=BODY_B, size=9, ha="center")
    axes.set(xlim=(-2.3, 2.8), ylim=(-1.85, 1.75))


def picture():
    """Both drawings side by side."""
    figure = sheet(11.0, 4.3)
    for axes, draw_part in zip(figure.subplots(1, 2), (draw_bodies, draw_clearance), strict=True):
        draw_part(axes)
        axes.set_aspect("equal")
        axes.set_axis_off()
    return figure


def draw(work: workshop.Workshop) -> None:
    work.keep(picture())
