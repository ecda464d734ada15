"""Sensitivities of points of a sweep: metrics <metric>_by_<parameter> and their stated errors."""

from clearance.accuracy.by_differences import Impossible, Sensing, reason_without
from clearance.metrics.metrics import Metric
from clearance.metrics.of_points import of_point
from clearance.results.memory import MemoryRecord
from clearance.run.ideal_motion import ideal_motion
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.simulation import prepare
from clearance.sweeping.definition import Definition

#: options of a run that those with varied parameters have too
KEPT = ("energy", "max_step")


def sensing_of(definition: Definition, scene: Scene) -> Sensing | None:
    """Sensitivities of a point, None where none are requested. Raises ValueError."""
    if (request := definition.options.get("sensitivity")) is None:
        return None
    options_of_all = {n: v for n, v in definition.options.items() if n in KEPT}

    def prepared(varied: Scene, **options) -> Run:
        return prepare(varied, **options_of_all, **options)

    def summed(run: Run, record: MemoryRecord) -> dict[str, Metric]:
        ideal = ideal_motion(run.mechanism.scene, run.span, record.scene)
        return of_point(record, definition.settle, ideal)

    return Sensing(scene, request, prepared, definition.settle, summed)


def columns(sensing: Sensing, run: Run) -> tuple[dict[str, Metric], str]:
    """Sensitivities of a run that has come to its end and their errors; why there are none."""
    if reason := reason_without(run):
        return {}, reason
    try:
        sensitivities = sensing.of(run)
    except (Impossible, ValueError) as reason:
        return {}, str(reason)
    metrics = {}
    for (metric, parameter), s in sensitivities.items():
        name, text = f"{metric}_by_{parameter.replace('/', '_')}", f"{metric} by {parameter}"
        metrics[name] = Metric(s.value, s.units, f"derivative of {text}")
        metrics[f"{name}_error"] = Metric(s.error, s.units, f"stated error: derivative of {text}")
    return metrics, ""
