"""`clearance run`: a case, integrated, into a result file."""

import json
import time
from collections.abc import Iterable
from pathlib import Path

from clearance.commands import again, chaos, sensitivities, steady
from clearance.commands.accuracy import (
    ERROR,
    document,
    error_line,
    prefixed,
    tolerance,
    with_error,
)
from clearance.commands.common import (
    FAILED,
    FORCE,
    LENGTH,
    WARNED,
    case_options,
    channel_patterns,
    complain,
    folded,
    length_of,
    log_to_terminal,
    noted,
    number,
    parameter_lines,
    scene_of,
    show,
    taken,
)
from clearance.run.interrupts import terminable

OPTIONS = (
    case_options()
    | LENGTH
    | {
        "--rtol R": (number, None, "local error tolerance (default 1e-6)"),
        "--method METHOD": ("auto", "auto, dop853, rodas5p, radau5, radau9 or radau"),
        "--max-step S": ("s", None, "longest step, where loads act briefly"),
        "--samples-per-turn N": (
            number,
            400,
            "output rows a turn, of the complete run where nothing turns evenly",
        ),
        "--channels PATHS": 'stored in the file: comma list such as "bodies/slider,joints/B/gap" '
        "(all)",
        "--pressure-fields N": (
            int,
            None,
            "keep N pressure fields of the films a turn in the file (default none)",
        ),
        "--compression 0..9": (0, "gzip level of the file"),
        "--checkpoint S": (
            "s",
            None,
            "keep a checkpoint every so many seconds of wall time: the same command goes on from "
            "it after a crash",
        ),
        "-o FILE.h5": "result file (default CASE.h5)",
        "--settle N": (
            number,
            None,
            "turns (seconds, where nothing turns) of the start-up, left out of the numbers "
            "(default 1 of two or more)",
        ),
        "--from FILE.h5": 'begin in the state at the end of another run, or "quasi-static": with '
        "journals where their films carry the joint forces",
        "--plot": "draw a picture beside the result file",
    }
    | ERROR
    | FORCE
    | sensitivities.OPTIONS
    | steady.OPTIONS
)
OPTIONS |= again.OPTIONS | chaos.OPTIONS


def run(options) -> int:
    """Run the case, print its cost and its results; exit status 1 where it ended early.

    Raises KeyboardInterrupt, with a note that states what is stored, where the user or the system
    ends it.
    """
    began = time.perf_counter(), time.process_time()
    with terminable():
        case, values, scene = again.scene_of(options) if options.again else scene_of(options)
        options.rtol = tolerance(options)
        steady.check(options)
        chaotic = chaos.recognised(options, scene)
        options.error = None if chaotic else options.error
        output = _output(options, case)
        replaced = output.exists()
        with noted(f"{output} was not written"):
            simulated = _simulated if options.steady is None else steady.solved
            result, failure = simulated(options, case, scene, output)
        with noted(f"the run is stored in {output}"):
            summary = _summary(case, values, result, options.settle) | {"replaced": replaced}
            summary["resolved"] = json.loads(scene.origin.get("resolved", "{}"))
            if options.steady is not None:
                summary |= steady.summary(result)
            elif failure is None and chaotic:
                more, failure = chaotic.statistics(options, scene, output)
                summary |= more
            elif failure is None:
                summary |= _comparable(scene, result, summary["rtol"])
            if options.sensitivity is not None and failure is None:
                summary["sensitivities"] = sensitivities.document(result)
            if options.again:
                summary["again"] = again.compared(options.case, result)
            if options.plot:
                summary["plot"] = str(_plot(result, output, options.settle))
    summary["wall_s"] = time.perf_counter() - began[0]
    summary["cpu_s"] = time.process_time() - began[1]
    lines = parameter_lines(case, values, scene)
    if failure is not None:
        if result.complete and not options.json:
            print("\n".join(_readable(summary, lines)))
            summary["warnings"] = []
        summary.pop("status")
        return complain(options, failure, FAILED, **summary)
    return show(options, summary, _readable(summary, lines))


def _output(options, case) -> Path:
    """The result file. Raises ValueError where its picture would have the same name."""
    output = again.output(options) if options.again else Path(options.output or f"{case.name}.h5")
    if options.plot and output.suffix == ".png":
        raise ValueError(
            f"-o {output}: the result would be overwritten by the picture; name the result file .h5"
        )
    return output


def _simulated(options, case, scene, output: Path):
    """The result, and why the run ended early, None where it did not."""
    from clearance.simulation import SimulationError, simulate

    log_to_terminal(options)
    more = taken(options, "checkpoint force sensitivity")
    arguments = options.of_file if options.again else _arguments(options, case, scene)
    try:
        result = simulate(scene, path=output, progress=not options.json, **more, **arguments)
    except SimulationError as error:
        if error.result is None:
            raise
        return error.result, str(error)
    return result, None


def _arguments(options, case, scene) -> dict:
    """Arguments of `simulate`, which make the same run again."""
    return {
        **length_of(options, case, scene),
        **taken(options, "rtol method max_step samples_per_turn compression start"),
        **taken(options, "pressure_fields error settle"),
        "channels": channel_patterns(options.channels),
    }


def _comparable(scene, result, rtol: float) -> dict:
    """Time up to which the run can be compared with another, and statistics where that ends before
    the run.
    """
    from clearance.metrics.by_turn import TRANSIENT, means

    horizon = _horizon(scene, result, rtol)
    if horizon is None:
        return {}
    words, chaotic = horizon
    numbers = means(result) if chaotic else {}
    if not numbers:
        return {"horizon": words}
    return {
        "horizon": words,
        "statistics": {n: m.plain() for n, m in numbers.items()},
        "statistics_turns": next(iter(numbers.values())).count,
        "statistics_left_out": TRANSIENT,
    }


def _horizon(scene, result, rtol: float) -> tuple[str, bool] | None:
    """Time up to which a run with impacts can be compared, and True where it is chaotic; None
    without impacts.
    """
    from clearance.accuracy.horizon import NotSolved, horizon

    if not any(j.impacts for j in scene.clearance_joints) or not result.file["time"].size:
        return None
    until = float(result.file["time"][-1])
    try:
        limit = horizon(scene, until, rtol, str(result.solver["method"]).rpartition(", ")[2])
    except NotSolved as reason:
        return f"not found: {reason}", True
    return limit.sentence(scene.turn), limit.time is not None


def _plot(result, output: Path, settle: float | None) -> Path:
    from clearance.postprocess.plots import overview

    return overview(result, output.with_suffix(".png"), settle=settle)


def _summary(case, values: dict, result, settle: float | None) -> dict:
    """Results of a run, as plain data."""
    from clearance.metrics.summary import summary

    return {
        "case": case.name,
        "parameters": values,
        "file": str(result.path),
        "errors": document(result.errors),
        **summary(result, settle),
    }


#: estimates of what a run leaves out, as `run` heads them; one of each kind is printed
HEADS = {"bending": "rigid", "liner": "film", "flash": "contact"}


def _assumed(estimates: list[dict]) -> list[str]:
    """The largest effect of each kind that the run leaves out."""
    lines = []
    for kind, head in HEADS.items():
        mine = [a for a in estimates if a["kind"] == kind]
        if mine:
            largest = max(mine, key=lambda a: a["share"] or a["value"])
            lines.append(f"  {head:<12} {largest['short']}")
    return lines


def _readable(summary: dict, parameters: list[str]) -> Iterable[str]:
    s = summary
    lines = [
        f"{s['case']}: {s['simulated_s']:.6g} s simulated in {s['integration_s']:.3g} s "
        f"({s['wall_s']:.3g} s in all), {s['status']}",
        *parameters,
        f"  method       {s['method']} ({s['method_reason']}), rtol {s['rtol']:g}",
        f"  steps        {s['steps']} ({s['rejected']} rejected), {s['evaluations']} evaluations, "
        f"{s['jacobians']} jacobians",
        error_line(s),
        f"  energy       residual {s['energy_residual']:.3g} J of {s['energy_turned_over']:.3g} J "
        f"turned over",
    ]
    lines += steady.lines(s.get("steady")) + _settled_lines(s) + _assumed(s["assumptions"])
    if s["contacts"]:
        still = f" ({s['open_contacts']} not over at the end)" if s["open_contacts"] else ""
        lines.append(f"  events       {_contacts(sum(s['contacts'].values()))}{still}")
    if "horizon" in s:
        lines.append(f"  horizon      {s['horizon']}")
    if "statistics" in s:
        lines.append(
            f"  statistics   mean and 95 % interval over {s['statistics_turns']} turns, "
            f"the first left out"
        )
        lines += [
            f"    {n:<32} {m['mean']:.5g} +- {m['half_width']:.2g}"
            for n, m in s["statistics"].items()
        ]
    lines += chaos.lines(s) + sensitivities.lines(s)
    lines += map(WARNED.format, s["warnings"])
    lines += [f"  again        {s['again']['sentence']}"] if "again" in s else []
    replaced = " (it replaced an earlier one)" if s["replaced"] else ""
    lines.append(f"  file         {s['file']}{replaced}")
    lines += [f"  picture      {s[n]}" for n in ("plot", "statistics_plot") if n in s]
    return folded(lines)


def _settled_lines(s: dict) -> list[str]:
    """Joints and drives: the settled motion, and in brackets the start-up."""
    lines, window = [], s["settled"]
    if window and window["begin_s"] > 0.0:
        part = f"from {window['begin_s']:.6g} to {window['end_s']:.6g} s"
        lines.append(f"  settled      {part}; start-up in brackets")
    for name, joint in s["joints"].items():
        text = f"  joint {name:<6} {_joint_line(joint)}"
        if count := s["contacts"].get(name):
            early = s["startup_contacts"].get(name, 0)
            text += f", {_contacts(count - early)}" + (f" ({early})" if early else "")
        lines.append(text)
    for name, drive in s["drives"].items():
        bracket = _bracket(drive, "startup_peak")
        effort = with_error(drive["peak"], drive.get("peak_error"), drive["units"], bracket)
        lines.append(f"  drive {name:<6} peak effort {effort}")
        if "peak_ideal" in drive:
            lines[-1] += f", {drive['peak_ideal']:.6g} without joint friction in the same motion"
        if "mean_power" in drive:
            lines[-1] += f", mean power {drive['mean_power']:.4g} W"
    return lines


def _bracket(part: dict, name: str, factor: float = 1.0, form: str = ".6g") -> str:
    return f" ({part[name] * factor:{form}})" if name in part else ""


def _contacts(count: int) -> str:
    return f"{count} contact{'s' * (count != 1)}"


def _film_part(joint: dict) -> str:
    """Errors of the numbers before that the film table's error makes."""
    parts = [
        (joint.get(f"{name}_film_error"), units)
        for name, units in (("peak_force", "N"), ("smallest_gap", "m"))
    ]
    texts = [f"+- {prefixed(error, units)}" for error, units in parts if error]
    return f" of its force: {', '.join(texts)}" if texts else ""


def _elastic_film(joint: dict) -> str:
    """The thinnest film on elastic surfaces, and its state there where that is known."""
    from clearance.metrics.summary import regime_of

    film = f"thinnest film {1e6 * joint['least_elastic_film']:.4g} um on the elastic surfaces"
    if "least_elastic_ratio" in joint:
        film += f" ({joint['least_elastic_ratio']:.3g} roughnesses)"
    if "film_over_rigid" not in joint:
        return film
    symbols = {"moes_load": "M", "moes_material": "L"}
    where = "there"
    if "wedge_number" in joint:
        symbols, where = (
            {"wedge_number": "C_w", "squeeze_number": "C_s"},
            "where it is pressed most",
        )
    state = [
        f"{joint['film_over_rigid']:.3g} of the rigid film",
        f"deflection {joint['deflection_over_film']:.2g} of it",
        *(f"{symbol} {joint[name]:.2g}" for name, symbol in symbols.items()),
    ]
    pressure = prefixed(joint["film_pressure"], "Pa")
    state[-1] += f" ({regime_of(joint)}) {where}"
    parts = [film, *state, f"pressure to {pressure} (alpha p {joint['piezoviscous_number']:.2g})"]
    if "time_in_elastic" in joint:
        shares = (f"{joint[f'{n}_in_elastic']:.0%} of the {n}" for n in ("time", "load"))
        parts.append(f"elastic in {' and '.join(shares)}")
    return ", ".join(parts)


def _joint_line(joint: dict) -> str:
    from clearance.metrics.summary import SHARES, SURFACES

    bracket = _bracket(joint, "startup_peak_force")
    force = with_error(joint.get("peak_force", 0.0), joint.get("peak_force_error"), "N", bracket)
    parts = [f"peak force {force}"]
    # surfaces that press into each other have no film; elastic ones have another one
    elastic = "least_elastic_film" in joint
    if "smallest_gap" in joint:
        bracket, error = (
            _bracket(joint, "startup_smallest_gap", 1e6, ".4g"),
            joint.get("smallest_gap_error"),
        )
        gap = with_error(joint["smallest_gap"] * 1e6, error and error * 1e6, "um", bracket)
        parts.append(f"smallest {'nominal ' if elastic else ''}gap {gap}")
    if not elastic and joint.get("smallest_film_thickness_ratio", -1.0) >= 0.0:
        parts.append(f"film thickness ratio down to {joint['smallest_film_thickness_ratio']:.3g}")
    if "share_full_film" in joint:
        shares = (f"{text} {joint[n]:.0%}" for n, text in SHARES.items() if joint[n] >= 0.005)
        solids = f"{joint['mean_asperity_share']:.0%} of the load on the solids"
        span = " (with the start-up)" if "startup_peak_force" in joint else ""
        parts += [*shares, solids + span]
    if elastic:
        parts.append(_elastic_film(joint))
    names = ("film_table_error_closing", "film_table_error_load")
    for name in (n for n in names if n in joint):
        parts.append(f"film table within {joint[name]:.1e}{_film_part(joint)}")
    if "mean_loss" in joint:
        parts.append(f"mean loss {joint['mean_loss']:.4g} W")
    if "peak_friction" in joint:
        parts.append(f"friction up to {joint['peak_friction']:.4g} {joint['friction_units']}")
    for surface in SURFACES:
        if f"worn_{surface}" in joint:
            parts.append(f"{surface} worn by {1e9 * joint[f'worn_{surface}']:.4g} mm3")
    return ", ".join(parts)
