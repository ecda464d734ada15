"""`clearance run`: a case, integrated, into a result file."""

import argparse
import logging
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from clearance.commands.common import (
    DONE,
    FAILED,
    add_case,
    add_command,
    add_length,
    channel_patterns,
    complain,
    json_text,
    length_of,
    number,
    peak,
    quantity_of,
    scene_of,
)
from clearance.interrupts import terminable


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "run", help="run a case and write an HDF5 result file")
    add_case(p)
    add_length(p)
    p.add_argument("--rtol", type=number, default=1e-6, metavar="R", help="local error tolerance (default 1e-6)")
    p.add_argument("--method", default="auto", help="auto, dop853, rodas5p, radau5, radau9 or radau (default auto)")
    p.add_argument("--max-step", type=quantity_of("s"), metavar="S", help="longest step, where loads act briefly")
    p.add_argument("--samples-per-turn", type=number, default=400, metavar="N", help="output rows a turn (default 400)")
    p.add_argument(
        "--channels", metavar="PATHS", help='kept in the file: comma list such as "bodies/slider,joints/B/gap" (all)'
    )
    p.add_argument("--compression", type=int, default=0, metavar="0..9", help="gzip level of the file (default 0)")
    p.add_argument(
        "--checkpoint", type=quantity_of("s"), metavar="S",
        help="keep a checkpoint every so many seconds of wall time: the same command goes on from it after a crash",
    )  # fmt: skip
    p.add_argument("-o", dest="output", metavar="FILE.h5", help="result file (default CASE.h5)")
    p.add_argument("--plot", action="store_true", help="draw a picture beside the result file")
    return p


def run(options) -> int:
    """Run the case, say what it cost and gave; exit status 1 where it ended early.

    Raises KeyboardInterrupt, with a note that says what is kept, where the user or the system asks it to end.
    """
    with terminable():
        case, values, scene = scene_of(options)
        output = _output(options, case)
        began = time.perf_counter(), time.process_time()
        with _noted(f"{output} was not written"):
            result, failure = _simulated(options, scene, output)
        if result is None:
            return complain(options, failure, FAILED)
        with _noted(f"the run is kept in {output}"):
            summary = _summary(case, values, result, began)
            if failure is None:
                summary |= _comparable(scene, result, options.rtol)
            if options.plot:
                summary["plot"] = str(_plot(result, output))
    if failure is not None:
        summary.pop("status")
        return complain(options, failure, FAILED, **summary)
    print(json_text(summary) if options.json else _readable(summary))
    return DONE


def _output(options, case) -> Path:
    """The result file. Raises ValueError where its picture would have the same name."""
    output = Path(options.output or f"{case.name}.h5")
    if options.plot and output.suffix == ".png":
        raise ValueError(f"-o {output}: the result would be overwritten by the picture; name the result file .h5")
    return output


@contextmanager
def _noted(note: str) -> Iterator[None]:
    """An interrupt that says nothing of what is kept says it with this note."""
    try:
        yield
    except KeyboardInterrupt as request:
        if not hasattr(request, "__notes__"):
            request.add_note(note)
        raise


def _simulated(options, scene, output: Path):
    """The result, None where no file could be kept, and why the run ended early, None where it did not."""
    from clearance.simulation import SimulationError, simulate

    watched = not options.json and sys.stderr.isatty()
    bar = ProgressBar() if watched else None
    if watched:
        logging.basicConfig(level=logging.INFO, format="%(message)s")
    try:
        result = simulate(
            scene, **length_of(options, scene), rtol=options.rtol, method=options.method,
            max_step=options.max_step, samples_per_turn=options.samples_per_turn, path=output, progress=bar,
            channels=channel_patterns(options.channels), compression=options.compression,
            checkpoint=options.checkpoint,
        )  # fmt: skip
    except SimulationError as error:
        return error.result, str(error)
    finally:
        if bar is not None:
            bar.close()
    return result, None


def _comparable(scene, result, rtol: float) -> dict:
    """How far the run can be compared with another, and statistics where that ends before the run does."""
    from clearance.evidence.statistics import over_turns

    horizon = _horizon(scene, result, rtol)
    if horizon is None:
        return {}
    said, chaotic = horizon
    means = over_turns(result, scene.turn) if chaotic else {}
    if not means:
        return {"horizon": said}
    return {
        "horizon": said, "statistics": {n: {"mean": m.value, "standard_error": m.error} for n, m in means.items()},
        "statistics_turns": next(iter(means.values())).turns,
    }  # fmt: skip


def _horizon(scene, result, rtol: float) -> tuple[str, bool] | None:
    """How far a run with impacts can be compared with another, and whether it ends there; None without impacts."""
    from clearance.evidence.problem import NotSolved, horizon

    if not any(j.impacts for j in scene.clearance_joints) or not result.file["time"].size:
        return None
    until = float(result.file["time"][-1])
    try:
        found = horizon(scene, until, rtol, str(result.solver["method"]).rpartition(", ")[2])
    except NotSolved as reason:
        return f"not found: {reason}", True
    return found.sentence(scene.turn), found.time is not None


class ProgressBar:
    """A progress bar on stderr."""

    def __init__(self):
        from tqdm import tqdm

        self.bar = tqdm(total=100, unit="%", bar_format="{l_bar}{bar}| {elapsed} passed, {remaining} left")

    def __call__(self, share: float) -> None:
        self.bar.update(100.0 * share - self.bar.n)

    def close(self) -> None:
        self.bar.close()


def _plot(result, output: Path) -> Path:
    from clearance.postprocess.plots import overview

    return overview(result, output.with_suffix(".png"))


def _summary(case, values: dict, result, began: tuple[float, float]) -> dict:
    """What a run cost and gave, as plain data."""
    solver, events = result.solver, result.events
    contacts: dict[str, int] = {}
    for joint in events["joint"]:
        contacts[str(joint)] = contacts.get(str(joint), 0) + 1
    return {
        "status": result.status,
        "case": case.name,
        "parameters": values,
        "file": str(result.path),
        "simulated_s": float(result.file["time"][-1]) if result.file["time"].size else 0.0,
        "samples": int(result.file["time"].size),
        "method": solver["method"],
        "method_reason": solver["method_reason"],
        "rtol": float(solver["rtol"]),
        "steps": int(solver["steps"]),
        "rejected": int(solver["rejected"]),
        "evaluations": int(solver["evaluations"]),
        "jacobians": int(solver["jacobians"]),
        "integration_s": float(solver["wall_s"]),
        "wall_s": time.perf_counter() - began[0],
        "cpu_s": time.process_time() - began[1],
        "energy_residual": float(result.facts("energy").get("largest_residual", 0.0)),
        "energy_turned_over": float(result.facts("energy").get("turned_over", 0.0)),
        "contacts": contacts,
        "open_contacts": sum(str(k) == "open_contact" for k in events["kind"]),
        "joints": _joint_extremes(result),
        "drives": _drive_extremes(result),
        "warnings": result.warnings,
    }


SHARES = {"share_full_film": "full film", "share_mixed": "mixed", "share_dry": "dry"}
JOINT_FACTS = (
    "peak_force", "smallest_gap", "film_pressure", "piezoviscous_number", "flattening_ratio", "mean_asperity_share",
    "film_table_error_closing", *SHARES,
)  # fmt: skip


def _joint_extremes(result) -> dict:
    """Peak forces and smallest gaps, of steps and contacts; nothing for a run that ended before its first sample."""
    found = {}
    for name in result.names("joints"):
        joint, facts = result.joint(name), result.facts(f"joints/{name}")
        found[name] = {n: float(facts[n]) for n in JOINT_FACTS if n in facts}
        if result.time.size and "film_thickness_ratio" in joint and "film_radial" in joint:
            found[name]["smallest_film_thickness_ratio"] = result.extremes(f"joints/{name}/film_thickness_ratio")[0]
        if result.time.size and f"joints/{name}/friction" in result and "gap" not in joint:
            found[name]["peak_friction"] = peak(result, f"joints/{name}/friction")
            found[name]["friction_units"] = result.units(f"joints/{name}/friction")
    return found


def _drive_extremes(result) -> dict:
    """Largest efforts of the drives, and of what they were without joint friction."""
    found = {}
    for name in result.names("drives") if result.time.size else ():
        kinds = [k for k in ("torque", "force") if f"drives/{name}/{k}" in result]
        for kind in kinds:
            path = f"drives/{name}/{kind}"
            found[name] = {"units": result.units(path), "peak": peak(result, path)}
            if f"{path}_ideal" in result:
                found[name]["peak_ideal"] = peak(result, f"{path}_ideal")
    return found


def _readable(summary: dict) -> str:
    s = summary
    lines = [
        f"{s['case']}: {s['simulated_s']:.6g} s simulated in {s['integration_s']:.3g} s "
        f"({s['wall_s']:.3g} s in all), {s['status']}",
        f"  method       {s['method']} ({s['method_reason']}), rtol {s['rtol']:g}",
        f"  steps        {s['steps']} ({s['rejected']} rejected), {s['evaluations']} evaluations, "
        f"{s['jacobians']} jacobians",
        f"  energy       residual {s['energy_residual']:.3g} J of {s['energy_turned_over']:.3g} J turned over",
    ]
    for name, joint in s["joints"].items():
        line = f"  joint {name:<6} peak force {joint.get('peak_force', 0.0):.6g} N"
        if "smallest_gap" in joint:
            line += f", smallest gap {joint['smallest_gap'] * 1e6:.4g} um"
        if "smallest_film_thickness_ratio" in joint:
            line += f", film thickness ratio down to {joint['smallest_film_thickness_ratio']:.3g}"
        if "share_full_film" in joint:
            shares = (f"{text} {joint[n]:.0%}" for n, text in SHARES.items() if joint[n] >= 0.005)
            line += f", {', '.join(shares)}, {joint['mean_asperity_share']:.0%} of the load on the solids"
        if "film_table_error_closing" in joint:
            line += f", film table within {joint['film_table_error_closing']:.1e}"
        if "peak_friction" in joint:
            line += f", friction up to {joint['peak_friction']:.4g} {joint['friction_units']}"
        if name in s["contacts"]:
            line += f", {s['contacts'][name]} contacts"
        lines.append(line)
    for name, drive in s["drives"].items():
        ideal = f", {drive['peak_ideal']:.6g} without joint friction" if "peak_ideal" in drive else ""
        lines.append(f"  drive {name:<6} peak effort {drive['peak']:.6g} {drive['units']}{ideal}")
    if s["contacts"]:
        still = f" ({s['open_contacts']} not over at the end)" if s["open_contacts"] else ""
        lines.append(f"  events       {sum(s['contacts'].values())} contacts{still}")
    if "horizon" in s:
        lines.append(f"  horizon      {s['horizon']}")
    if "statistics" in s:
        lines.append(f"  statistics   mean and standard error over {s['statistics_turns']} turns, the first left out")
        lines += [f"    {n:<32} {m['mean']:.5g} +- {m['standard_error']:.2g}" for n, m in s["statistics"].items()]
    lines += [f"  warning      {w}" for w in s["warnings"]]
    lines += [f"  file         {s['file']}"] + ([f"  picture      {s['plot']}"] if "plot" in s else [])
    return "\n".join(lines)
