"""`clearance inverse`: prescribed motion in, driving efforts and joint reactions out."""

import time
from pathlib import Path

from clearance.commands.common import (
    FAILED,
    LENGTH,
    case_options,
    complain,
    length_of,
    scene_of,
    show,
)

OPTIONS = (
    case_options()
    | LENGTH
    | {
        "--samples N": (int, None, "output rows in all (default 400 a turn, or 401)"),
        "-o OUT": "result file (default CASE_inverse.h5)",
    }
)


def run(options) -> int:
    """Solve and summarise; exit status 1 where the motion leads into a singular position
    part-way.
    """
    from clearance.motions.inverse import inverse_dynamics
    from clearance.simulation import SimulationError

    case, values, scene = scene_of(options)
    length = {**length_of(options, case, scene), "samples": options.samples}
    path, failure, began = (
        Path(options.output or f"{case.name}_inverse.h5"),
        None,
        time.perf_counter(),
    )
    try:
        result = inverse_dynamics(scene, **length, path=path)
    except SimulationError as error:
        failure, result = str(error), error.result
    summary = {"case": case.name, "parameters": values, **_summary(scene, result)}
    summary["wall_s"] = time.perf_counter() - began
    if failure is not None:
        summary.pop("status")
        message = f"{failure}; kept {result.time.size} samples before it in {path}"
        return complain(options, message, FAILED, **summary)
    return show(options, summary, _readable(summary))


def _summary(scene, result) -> dict:
    """Result of inverse dynamics as plain data; only its size for a motion that ended before its
    first sample.
    """
    summary = {
        "status": result.status,
        "file": str(result.path),
        "method": result.solver["method"],
        "samples": int(result.time.size),
        "solved_s": float(result.solver["wall_s"]),
        "loop_s": float(result.solver["loop_s"]),
        "until_s": float(result.time[-1]) if result.time.size else 0.0,
    }
    if not result.time.size:
        return summary
    from clearance.metrics.power import power_residual

    summary["drives"] = {n: _largest(result, f"drives/{n}", DRIVE) for n in result.names("drives")}
    summary["joints"] = {n: _largest(result, f"joints/{n}", JOINT) for n in result.names("joints")}
    if "friction/iterations" in result:
        summary["friction"] = {
            n: result.range(f"friction/{n}")[1] for n in ("iterations", "contraction")
        }
    summary["power_residual"] = float(abs(power_residual(scene, result)).max())
    summary["power"] = max(x["power"] for x in summary["drives"].values())
    return summary


DRIVE = ("torque", "torque_ideal", "force", "force_ideal", "power")
JOINT = ("force", "moment", "axial_force", "bending", "friction", "power_loss")


def _largest(result, group: str, names: tuple[str, ...]) -> dict[str, float]:
    """Largest absolute values of channels, or lengths of pairs, by name; of those that there
    are.
    """
    from clearance.metrics.summary import peak

    largest = {}
    for name in names:
        if f"{group}/{name}_x" in result:
            x, y = (result.values(f"{group}/{name}_{axis}") for axis in "xy")
            largest[name] = float((x * x + y * y).max() ** 0.5)
        elif f"{group}/{name}" in result:
            largest[name] = peak(result, f"{group}/{name}")
    return largest


def _readable(summary: dict) -> list[str]:
    s = summary
    lines = [
        f"{s['case']}: {s['samples']} samples over {s['until_s']:.6g} s in "
        f"{1e3 * s['solved_s']:.3g} ms "
        f"({1e3 * s['loop_s']:.3g} ms in compiled code), {s['status']}",
        f"  method       {s['method']}",
    ]
    width = max(6, *(len(n) for group in ("drives", "joints") for n in s[group]))
    for name, drive in s["drives"].items():
        kind, unit = ("torque", "N m") if "torque" in drive else ("force", "N")
        ideal = (
            f" ({drive[f'{kind}_ideal']:.6g} {unit} without joint friction)"
            if f"{kind}_ideal" in drive
            else ""
        )
        largest = (
            f"largest {kind} {drive[kind]:.6g} {unit}{ideal}, largest power {drive['power']:.4g} W"
        )
        lines.append(f"  drive {name:<{width}} {largest}")
    for name, joint in s["joints"].items():
        line = f"  joint {name:<{width}} largest force {joint['force']:.6g} N"
        for kind, unit in (("moment", "N m"), ("axial_force", "N"), ("bending", "N m")):
            line += (
                f", {kind.replace('_', ' ')} {joint[kind]:.4g} {unit}" if joint.get(kind) else ""
            )
        line += f", friction {joint['friction']:.4g}" if "friction" in joint else ""
        lines.append(line)
    if "friction" in s:
        lines.append(
            f"  friction     coupled: at most {s['friction']['iterations']:.0f} iterations, "
            f"contraction {s['friction']['contraction']:.2g}"
        )
    lines.append(
        f"  power        residual {s['power_residual']:.2g} W, largest of a drive "
        f"{s['power']:.4g} W"
    )
    return [*lines, f"  file         {s['file']}"]
