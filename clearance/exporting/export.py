"""One call: a scene to C source, to a unit for other tools, or to both."""

from dataclasses import dataclass
from pathlib import Path

from clearance.exporting.c_source import write_c
from clearance.exporting.model import Model
from clearance.scene.scene import Scene


@dataclass(frozen=True)
class Exported:
    """Files of an export.

    model: parameters, inputs, outputs and kernels; c: folder of the source, None without one.
    """

    model: Model
    c: Path | None


def export(scene: Scene, *, c: str | Path | None = None) -> Exported:
    """Write a scene for other tools.

    c: folder for C99 source, which needs libm alone; its `main.c` prints a run as CSV.
    Raises ValueError, with the reasons, for a scene that cannot be exported.
    """
    if c is None:
        raise ValueError("export: give c=FOLDER")
    model = Model(scene)
    return Exported(model, write_c(model, c))
