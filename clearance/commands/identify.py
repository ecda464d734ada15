"""`clearance identify`: parameters of a friction model from measured torques."""

import argparse
import dataclasses
import json
from pathlib import Path

from clearance.commands.common import DONE, Line, add_command, listed, make_folder

#: parameters are listed up to so many; networks have more
MOST_LISTED = 100


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "identify", help="parameters of a joint-friction model from measured torques")
    p.add_argument("--data", required=True, metavar="FILE", help="measurement, HDF5 or CSV (see identify/records.py)")
    p.add_argument(
        "--model", default="lugre3d", metavar="NAME",
        help="lugre1d, lugre3d, curve, or lstm with the extra learn (default lugre3d)",
    )  # fmt: skip
    p.add_argument("--roles", default="training", metavar="NAMES", help="trials to fit: comma list (training)")
    p.add_argument("--starts", type=int, default=5, metavar="N", help="points a nonlinear fit begins from (5)")
    p.add_argument("--seed", type=int, default=0, metavar="N", help="of the starts (0)")
    p.add_argument("--trust-units", action="store_true", help="read numbers that look like degrees, N mm or ms as SI")
    p.add_argument("-o", dest="output", metavar="DIR", help="folder for fit.h5, modelled.h5 and pictures")
    p.add_argument("--plot", action="store_true", help="draw pictures into the folder")
    return p


def run(options) -> int:
    """Fit the model, say what came out and keep it."""
    from clearance.identify.fit import fit
    from clearance.identify.records import read

    if options.plot and not options.output:
        raise ValueError("--plot needs a folder for the pictures: give -o DIR")
    measurement = read(options.data, trusted=options.trust_units)
    line = Line(options)
    found = fit(
        measurement, options.model, starts=options.starts, seed=options.seed, roles=listed(options.roles),
        progress=lambda share: line(f"{share:.0%}"),
    )  # fmt: skip
    found.facts["data"] = str(options.data)
    document = _document(found, measurement)
    lines = _readable(document)
    if options.output:
        make_folder(options)
        document["files"] = [str(p) for p in _keep(found, measurement, Path(options.output), options.plot)]
        lines += [f"  wrote        {path}" for path in document["files"]]
    print(json.dumps(document) if options.json else "\n".join(lines))
    return DONE


def _keep(found, measurement, folder: Path, plot: bool) -> list[Path]:
    """The fit, its torques in the layout of the measurement, and pictures."""
    from clearance.identify.records import Measurement, write

    modelled = Measurement(
        tuple(dataclasses.replace(t, torque=found.torque(t)) for t in measurement.trials),
        {**measurement.facts, "modelled_by": found.model.name},
    )
    files = [found.save(folder / "fit.h5"), write(folder / "modelled.h5", modelled)]
    if plot:
        from clearance.postprocess import fits

        for role in measurement.roles:
            files.append(fits.loops(found, measurement.of(role), folder / f"loops_{role}.png"))
            files.append(fits.histories(found, measurement.of(role), folder / f"time_{role}.png"))
        files.append(fits.residuals(found, measurement, folder / "residuals.png"))
        if not found.model.linear:
            files.append(fits.progress(found, folder / "progress.png"))
    return files


def _document(found, measurement) -> dict:
    """What a fit gave, as plain data."""
    scores = {}
    for role in measurement.roles:
        of = measurement.of(role)
        ways = {over: found.score(of.trials, over) for over in ("rms", "std", "range")}
        scores[role] = {"trials": len(of.trials), "samples": of.samples, "nrmse": ways["rms"], "over": ways}
    document = {
        "status": "complete", "model": found.model.name, "data": found.facts["data"],
        "synthetic": bool(measurement.facts.get("synthetic", False)), "fitted": found.facts["samples"],
        "roles": found.facts["roles"], "seconds": found.facts["seconds"], "parameter_count": len(found.values),
        "scores": scores, "doubts": list(found.doubts),
        "left_aside": list(measurement.facts.get("columns_left_aside", [])),
    }  # fmt: skip
    if len(found.values) <= MOST_LISTED:
        units = {p.name: p.units for p in found.model.parameters}
        document["parameters"] = {
            n: {"value": v, "units": units[n], "low": found.low.get(n), "high": found.high.get(n)}
            for n, v in found.values.items()
        }
    return document


def _readable(document: dict) -> list[str]:
    d = document
    lines = [
        f"{d['model']} of {d['data']}: {d['fitted']} samples of {', '.join(d['roles'])} in {d['seconds']:.3g} s"
        f"{' (synthetic data)' if d['synthetic'] else ''}"
    ]
    for name, p in d.get("parameters", {}).items():
        line = f"  {name:<24} {p['value']:>11.5g} {p['units']:<10}"
        lines.append(line + (f" 95 % {p['low']:.5g} to {p['high']:.5g}" if p["low"] is not None else ""))
    if "parameters" not in d:
        lines.append(f"  {d['parameter_count']} parameters, kept in the file of the fit")
    lines.append(f"  {'NRMSE: rms error over':<24} {'rms':>8} {'std':>8} {'range':>8}   of the measured torque")
    for role, s in d["scores"].items():
        three = " ".join(f"{s['over'][over]:>8.4f}" for over in ("rms", "std", "range"))
        lines.append(f"    {role:<22} {three}   {s['trials']} trials, {s['samples']} samples")
    lines += [f"  doubt        {doubt}" for doubt in d["doubts"]]
    return lines + [f"  left aside   column {name}" for name in d["left_aside"]]
