"""One call: a scene to C source, to a unit for other tools, or to both."""

from dataclasses import dataclass
from pathlib import Path

from clearance.exporting.c_source import write_c
from clearance.exporting.model import Model
from clearance.exporting.unit import write_unit
from clearance.scene.scene import Scene


@dataclass(frozen=True)
class Exported:
    """Files of an export.

    model: parameters, inputs, outputs and kernels; c: folder of the source; fmu: path of the unit;
    None without one. platforms: that the unit has binaries for; none: it has its sources alone.
    """

    model: Model
    c: Path | None
    fmu: Path | None
    platforms: tuple[str, ...]


def export(scene: Scene, *, c: str | Path | None = None, fmu: str | Path | None = None) -> Exported:
    """Write a scene for other tools.

    c: folder for C99 source, which needs libm alone; its `main.c` prints a run as CSV. fmu: path of
        a functional mock-up unit (FMI 3.0) for model exchange and co-simulation. It has binaries
        for all platforms with the extra `export`, else for this one by its compiler.
    Raises ValueError, with the reasons, for a scene that cannot be exported.
    """
    if c is None and fmu is None:
        raise ValueError("export: give fmu=FILE, c=FOLDER, or both")
    if fmu is not None and Path(fmu).suffix != ".fmu":
        raise ValueError(f"export: the name of a unit ends in .fmu, got {fmu}")
    model = Model(scene)
    platforms = () if fmu is None else tuple(write_unit(model, fmu))
    folder = None if c is None else write_c(model, c)
    return Exported(model, folder, None if fmu is None else Path(fmu), platforms)
