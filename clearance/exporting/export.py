"""One call: a scene to C source, to a unit for other tools, to a page that computes."""

from dataclasses import dataclass
from pathlib import Path

from clearance.exporting.c_source import write_c
from clearance.exporting.model import Model
from clearance.exporting.page import facts, first_run
from clearance.exporting.unit import module, write_unit
from clearance.scene.scene import Scene
from clearance.values.accessors import accessor


@dataclass(frozen=True)
class Exported:
    """Files of an export.

    model: parameters, inputs, outputs and kernels; c: folder of the source; fmu: path of the unit;
    page: path of the page; None without one. platforms: that the unit has binaries for; none: it
    has its sources alone.
    """

    model: Model
    c: Path | None
    fmu: Path | None
    platforms: tuple[str, ...]
    page: Path | None


def export(
    scene: Scene,
    *,
    c: str | Path | None = None,
    fmu: str | Path | None = None,
    page: str | Path | None = None,
) -> Exported:
    """Write a scene for other tools.

    c: folder for C99 source, which needs libm alone; its `main.c` prints a run as CSV. fmu: path of
        a functional mock-up unit (FMI 3.0) for model exchange and co-simulation. It has binaries
        for all platforms with the extra `export`, else for this one by its compiler. page: path of
        an HTML page with sliders that integrates the scene in the browser; it needs the extra.
    Raises ValueError, with the reasons, for a scene that cannot be exported.
    """
    if c is fmu is page is None:
        raise ValueError("export: give fmu=FILE.fmu, c=FOLDER or page=FILE.html")
    if fmu is not None and Path(fmu).suffix != ".fmu":
        raise ValueError(f"export: the name of a unit ends in .fmu, got {fmu}")
    model = Model(scene)
    platforms = () if fmu is None else tuple(write_unit(model, fmu))
    folder = None if c is None else write_c(model, c)
    if page is not None:
        page = accessor("live")(first_run(model), page, facts(model), module(model))
    return Exported(model, folder, None if fmu is None else Path(fmu), platforms, page)
