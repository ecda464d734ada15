"""Pressure fields that a run has stored, over the unwrapped bearing."""

from pathlib import Path

import numpy as np
from clearance.postprocess.figures import COLOURS, degrees, levels, save, sheet
from clearance.postprocess.labels import title

from clearance.results.record import PressureFields, Record

#: most instants on a page, and of them beside each other
MOST, COLUMNS = 9, 3
#: content of the gap along the edge of the film
EDGE = 0.5
KEEP = "run it with --pressure-fields N"


def pressures(record: Record, path: str | Path, *, joint: str | None = None) -> Path:
    """Pressure over angle and length of the bearing at instants of the last turn, on one scale;
    saved under `path`.

    Grey: the cavity; white: its edge, where the film ruptures and forms again; dotted: the thinnest
    film. Up to 9 instants, spread evenly. joint: default the first with fields. Raises ValueError
    for a joint without, naming those with.
    """
    name, fields = _fields(record, joint)
    begin = record.time[-1] - (record.turn or record.time[-1]) * (1.0 + 1e-9)
    late = np.flatnonzero(fields.time >= begin)
    places = late[np.unique(np.linspace(-1, len(late) - 1, MOST + 1).astype(int)[1:].clip(0))]
    columns = min(COLUMNS, len(places))
    rows = -(-len(places) // columns)
    figure = sheet(3.9 * columns, 2.3 * rows + 0.7)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    shown = 1e-6 * fields.pressure[places]
    steps = levels(float(shown.min()), float(shown.max()))
    for axes, instant in zip(panels.flat, places, strict=False):
        drawn = _field(axes, fields, instant, steps)
    for axes in panels.flat[len(places) :]:
        axes.axis("off")
    for i in range(len(places)):
        if i + columns >= len(places):
            panels.flat[i].set_xlabel("angle on the bearing [deg]")
            panels.flat[i].tick_params(labelbottom=True)
    for axes in panels[:, 0]:
        axes.set_ylabel("axial [mm]")
    figure.colorbar(drawn, ax=panels, label="pressure above ambient [MPa]", shrink=0.9)
    heading = ": ".join(filter(None, (record.attributes["case"], title(record))))
    marks = "grey: cavity; dotted: thinnest film"
    figure.suptitle(f"{heading}\njoint {name} ({marks})", fontsize="medium")
    return save(figure, path, dpi=130)


def _fields(record: Record, joint: str | None) -> tuple[str, PressureFields]:
    """The joint requested, or the first one with fields, and its fields."""
    names = [n for n in record.clearances if record.pressure_fields(n) is not None]
    if not names:
        raise ValueError(f"{record.path.name} has no pressure fields; {KEEP}")
    if joint is not None and joint not in names:
        raise ValueError(
            f"{record.path.name} has no pressure fields of joint {joint!r}; of {', '.join(names)}"
        )
    return joint or names[0], record.pressure_fields(joint or names[0])


def _field(axes, fields: PressureFields, instant: int, steps: np.ndarray):
    """The field of one instant; its angles are closed to a full turn."""
    around = np.append(fields.angle, fields.angle[0] + 2.0 * np.pi)
    angle, axial = np.degrees(around), 1e3 * fields.axial
    pressure, content = (_closed(values[instant]) for values in (fields.pressure, fields.content))
    drawn = axes.contourf(angle, axial, 1e-6 * pressure, levels=steps, cmap=COLOURS)
    if content.min() < EDGE < content.max():
        axes.contourf(angle, axial, content, levels=[-1.0, EDGE], colors=["0.8"])
        axes.contour(angle, axial, content, levels=[EDGE], colors="white", linewidths=1.2)
    axes.axvline(np.degrees(fields.line_of_centres[instant]), color="white", ls=":", lw=1.0)
    peak = 1e-6 * fields.pressure[instant].max()
    state = f"eccentricity {fields.eccentricity_ratio[instant]:.3f}, up to {peak:.3g} MPa"
    axes.set_title(f"{1e3 * fields.time[instant]:.4g} ms: {state}", fontsize="small")
    axes.set_xlim(0.0, 360.0)
    degrees(axes, most=5)
    return drawn


def _closed(values: np.ndarray) -> np.ndarray:
    """A field (axial, angle) with its first angle again at the end."""
    return np.hstack([values, values[:, :1]])
