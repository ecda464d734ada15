"""The one scatter call: a case and distributions in, the spread of its metrics out."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from clearance.accuracy.point_errors import Stating
from clearance.run.recording import record_run
from clearance.scene.case import Case
from clearance.scene.catalogue import AnyCase, find_case
from clearance.simulation import prepare
from clearance.sweeping.points import grid
from clearance.sweeping.scatter import (
    DISTRIBUTIONS,
    Distribution,
    Scatter,
    design,
    from_words,
    of_fit,
    write,
)
from clearance.sweeping.sweep import OPTIONS, define, sweep
from clearance.sweeping.worker import Keeper
from clearance.values import checks
from clearance.values.spelling import alike
from clearance.values.units import quantity

#: end of the metrics that some runs lack
SELDOM = "_jam_ratio"


def scatter(
    case: AnyCase,
    spread: Mapping[str, Distribution | str],
    folder: str | Path,
    *,
    points: int = 1024,
    seed: int = 0,
    limits: Mapping[str, float | str] | None = None,
    channels: list[str] | tuple[str, ...] = (),
    **options,
) -> Scatter:
    """Run a case with parameters that vary by chance, each by itself, and return the spread of its
    metrics.

    spread: distributions by parameter, also in words: {"clearance": "normal(0.1mm, 5um)"}, or a
        fit, {"clearance": "H7/f7"}; points: runs in all, at most; seed: the same seed, the same
        points; limits: of metrics, whose probability of going beyond is computed,
        as numbers in SI or in words: "0.2mm". Their names and units are those of a run at the
        medians. channels: stored in run files (none: no files); options: of `sweep`, among them
        fixed and turns. The same call again runs only what is missing.
    Raises ValueError for wrong input, and what `sweep` raises.

    Example:

        >>> scene = cl.load_case("slider_crank", model="lubricated")
        >>> laws = {"viscosity": "normal(40cP, 4cP)"}
        >>> spread = cl.scatter(scene, laws, "machines", points=24, turns=2, workers=1)
        >>> bool(spread.sweep.done.all())
        True
    """
    chosen_case = find_case(case)
    laws = {
        n: law if isinstance(law, Distribution) else _law(chosen_case, n, law, options)
        for n, law in spread.items()
    }
    chosen, n = design(laws, points, seed)
    beyond = limits_of(limits, _units(case, laws, **options)) if limits else {}
    swept = sweep(case, chosen, folder, channels=list(channels), **options)
    result = Scatter(swept, laws, n, beyond)
    write(result, Path(folder))
    return result


def _units(
    case: AnyCase,
    laws: Mapping[str, Distribution],
    fixed: Mapping[str, object] | None = None,
    settle: float | None = None,
    metrics: Sequence[Callable | str] = (),
    **options,
) -> dict[str, str]:
    """Units by metric, of one run at the medians; empty where that run fails. Raises ValueError."""
    middle = grid(**{n: [float(law.at(0.5))] for n, law in laws.items()})
    options = {n: v for n, v in options.items() if n in OPTIONS}
    definition = define(case, middle, fixed or {}, (), 0, settle, metrics, options)
    run = prepare(
        find_case(definition.path).scene(**definition.values(0)), **definition.run_options
    )
    keeper = Keeper(Stating(run, None, settle), definition, "", None, {})
    failure = record_run(run, keeper)
    return {} if failure else {n: m.units for n, m in keeper.values.items()}


def limits_of(limits: Mapping[str, float | str], metrics: Mapping[str, str]) -> dict[str, float]:
    """Limits in SI.

    metrics: units by metric; empty where they are not known. Raises ValueError for a metric that a
        run lacks, and for a unit of another kind.
    """
    numbers = {}
    for path, limit in limits.items():
        name = alike(path, metrics)
        if metrics and not name.endswith(SELDOM):
            checks.known("no metric", name, metrics)
        try:
            number = quantity(limit, metrics.get(name))
        except ValueError as error:
            raise ValueError(f"limit of {name}: {error}{_written(metrics.get(name))}") from None
        numbers[name] = checks.finite(f"limit of {name}", number)
    return numbers


def _written(units: str | None) -> str:
    """The way in which a limit in these units is written; empty where they are not known."""
    if units is None:
        return ""
    if units in ("-", "1", "?"):
        return "; this metric is a plain number, such as 2"
    try:
        quantity(f"2 {units}", units)
    except ValueError:
        return f"; this metric is in {units}: give the number alone, such as 2"
    return f"; this metric is in {units}, such as 2 {units}"


def _law(case: Case, name: str, text: str, options: Mapping) -> Distribution:
    if case.takes_fit(name, text):
        return of_fit(case.fit(name, text, options.get("fixed") or {}))
    about = case.parameters.get(name)
    law = from_words(text, partial(quantity, units=about and about.units))
    if law is None:
        raise ValueError(
            f"{name}: {text!r} is no distribution; there are {', '.join(DISTRIBUTIONS)}"
        )
    return law
