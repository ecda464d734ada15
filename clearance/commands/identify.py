"""`clearance identify`: parameters of a friction model from measured torques, or of a model of
one's own.
"""

from pathlib import Path

from clearance.commands.common import (
    listed,
    make_folder,
    pair,
    progress_of,
    seed_of,
    show,
)

#: parameters are listed up to so many; networks have more
MOST_LISTED = 100
MOST_TRIALS = 6  # whose rms errors are listed
#: options of models that have an option of the command
APART = "bounds", "lag"


OPTIONS = {
    "--data FILE !": "measurement, HDF5 or CSV (see identify/records.py)",
    "--model NAME": (
        "lugre3d",
        "lugre1d, lugre3d, curve, or lstm with the extra learn; one's own as FILE.py:NAME "
        "(NAME only where the file has several), a law or any function of a record (see "
        "identify/own.py)",
    ),
    "-p NAME=VALUE ...": "an option of the model, such as knots=0.01,0.1,1 network=4 "
    "exponent=1 symmetric=no static=yes load=power nonnegative=yes smoothing=0.1, of the lstm "
    "hidden=8",
    "--bound NAME=LO:HI ...": "bounds of a parameter in its SI unit, such as "
    "spin_stiffness=500:5000",
    "--roles NAMES": ("training", "trials to fit: comma list"),
    "--starts N": (
        int,
        None,
        "points a nonlinear fit begins from (20, of a model of one's own 1)",
    ),
    "--lag": "fit a time by which the torque comes after its rate, too",
    "--seed N": (0, "of the starts"),
    "--trust-units": "read numbers that look like degrees, N mm or ms as SI",
    "--predict FILE ...": "a measurement that is predicted, not fitted, such as of another speed",
    "--columns LIST": "headings of any CSV file: time=t,rate_z=speed,torque_z=torque",
    "-o DIR": "folder for fit.h5, modelled.h5 and pictures",
    "--plot": "draw pictures into the folder",
}


def run(options) -> int:
    """Fit the model, print the result and write it."""
    from clearance.identify.fit import fit
    from clearance.identify.records import read

    if options.plot and not options.output:
        raise ValueError("--plot needs a folder for the pictures: give -o DIR")
    model = _model(options)
    about = {
        "trusted": options.trust_units,
        "predicts": getattr(model, "predicts", None),
        "columns": _columns(options.columns),
    }
    measurement = read(options.data, **about)
    for path in options.predict:
        measurement = measurement.with_predicted(read(path, **about))
    make_folder(options)
    with progress_of(options) as shown:
        fitted = fit(
            measurement,
            model,
            starts=options.starts,
            seed=seed_of(options),
            roles=listed(options.roles),
            progress=shown,
        )
    fitted.facts["data"] = str(options.data)
    document = _document(fitted, measurement)
    lines = _readable(document)
    if options.output:
        files = _keep(fitted, measurement, Path(options.output), options.plot)
        document["files"] = [*map(str, files)]
        lines += [f"  wrote        {path}" for path in document["files"]]
        if fitted.has_law:
            lines.append(
                f"  a hinge      open_fit('{document['files'][0]}').law('spin') is its friction, a "
                f"cl.joint_lugre"
            )
    return show(options, document, lines)


def _columns(text: str | None) -> dict[str, str] | None:
    """Headings of a file by our names. Raises ValueError for what is no such list."""
    if text is None:
        return None
    pairs = (pair("--columns", item, "NAME=HEADING,NAME=HEADING") for item in text.split(","))
    return {name: heading.strip() for name, heading in pairs}


def _model(options):
    """The model with its options and bounds.

    Raises ValueError for those it has not or cannot have.
    """
    from clearance.identify import models, own

    if ":" in options.model or options.model.endswith(".py"):
        return _own_model(options, own.open_model(options.model))
    defaults, chosen = models.model(options.model).options, {}
    for item in options.parameters:
        name, text = pair("-p", item)
        if name not in defaults or name in APART:
            names = ", ".join(n for n in defaults if n not in APART)
            raise ValueError(f"-p {item}: {options.model} has no option {name!r}; it has {names}")
        chosen[name] = _value(item, text, defaults[name])
    if options.bound and "bounds" not in defaults:
        raise ValueError(f"--bound {options.bound[0]}: {options.model} has no bounds")
    if options.bound:
        chosen["bounds"] = dict(map(_bound, options.bound))
    if options.lag and "lag" not in defaults:
        raise ValueError(
            f"--lag: {options.model} has no lag; lugre1d, lugre3d and models of one's own have"
        )
    if options.lag:
        chosen["lag"] = True
    return models.model(options.model, **chosen)


def _own_model(options, model):
    """A model of one's own with the bounds and the lag requested."""
    if options.parameters:
        raise ValueError(
            f"-p {options.parameters[0]}: a model of one's own has no options; its file holds its "
            f"numbers"
        )
    model = model.with_bounds(dict(map(_bound, options.bound)))
    return model.with_lag() if options.lag else model


def _value(item: str, text: str, default):
    """The value of an option, of the kind that its default has."""
    try:
        if isinstance(default, bool):
            return {"yes": True, "true": True, "no": False, "false": False}[text.lower()]
        if isinstance(default, tuple):
            return tuple(float(part) for part in listed(text) or ())
        return type(default)(text)
    except (KeyError, ValueError):
        kinds = {bool: "yes or no", tuple: "a comma list of numbers", int: "a whole number"}
        raise ValueError(
            f"-p {item}: expected {kinds.get(type(default), 'a number')}, got {text!r}"
        ) from None


def _bound(item: str) -> tuple[str, tuple[float, float]]:
    form = "NAME=LO:HI"
    name, ends = pair("--bound", item, form)
    try:
        low, high = map(float, ends.split(":"))
    except ValueError:
        raise ValueError(f"--bound {item}: expected {form}") from None
    return name, (low, high)


def _keep(fitted, measurement, folder: Path, plot: bool) -> list[Path]:
    """The fit, its torques in the layout of the measurement, and pictures."""
    from clearance.identify.records import Measurement, write

    modelled = Measurement(
        tuple(fitted.model.modelled(fitted.values, t) for t in measurement.trials),
        {**measurement.facts, "modelled_by": fitted.model.name},
    )
    files = [fitted.save(folder / "fit.h5"), write(folder / "modelled.h5", modelled)]
    if plot:
        from clearance.postprocess import fits

        if predicts := getattr(fitted.model, "predicts", {}):
            return [*files, fits.columns(fitted, measurement, predicts, folder / "columns.png")]
        for role in measurement.roles:
            files.append(fits.loops(fitted, measurement.of(role), folder / f"loops_{role}.png"))
            files.append(fits.histories(fitted, measurement.of(role), folder / f"time_{role}.png"))
        files.append(fits.residuals(fitted, measurement, folder / "residuals.png"))
        if not fitted.model.linear:
            files.append(fits.progress(fitted, folder / "progress.png"))
    return files


def _document(fitted, measurement) -> dict:
    """Result of a fit as plain data."""
    scores = {}
    for role in measurement.roles:
        of = measurement.of(role)
        ways = {over: fitted.score(of.trials, over) for over in ("rms", "std", "range")}
        scores[role] = {
            "trials": len(of.trials),
            "samples": of.samples,
            "nrmse": ways["rms"],
            "over": ways,
        }
    document = {
        "status": "complete",
        "model": fitted.model.name,
        "data": fitted.facts["data"],
        "synthetic": bool(measurement.facts.get("synthetic", False)),
        "fitted": fitted.facts["samples"],
        "options": fitted.model.options,
        "widening": fitted.facts.get("widening"),
        "roles": fitted.facts["roles"],
        "seconds": fitted.facts["seconds"],
        "parameter_count": len(fitted.fitted),
        "not_fitted": fitted.facts.get("still", []),
        "scores": scores,
        "rms": {t.name: fitted.rms(t) for t in measurement.trials},
        "doubts": list(fitted.doubts),
        "left_aside": list(measurement.facts.get("columns_left_aside", [])),
    }
    if len(fitted.values) <= MOST_LISTED:
        units, (low, high) = {p.name: p.units for p in fitted.model.parameters}, fitted.widened()
        document["parameters"] = {
            n: {
                "value": v,
                "units": units[n],
                "low": fitted.low.get(n),
                "high": fitted.high.get(n),
                "widened_low": low.get(n),
                "widened_high": high.get(n),
            }
            for n, v in fitted.fitted.items()
        }
    return document


def _readable(document: dict) -> list[str]:
    from clearance.identify.doubts import WIDER

    d = document
    lines = [
        f"{d['model']} of {d['data']}: {d['fitted']} samples of {', '.join(d['roles'])} in "
        f"{d['seconds']:.3g} s"
        f"{' (synthetic data)' if d['synthetic'] else ''}"
    ]
    for name, p in d.get("parameters", {}).items():
        line = f"  {name:<24} {p['value']:>11.5g} {p['units']:<10}"
        if p["low"] is not None:
            line += f" 95 % {p['low']:.5g} to {p['high']:.5g}"
            line += (
                f", widened {p['widened_low']:.5g} to {p['widened_high']:.5g}"
                if d["widening"] >= WIDER
                else ""
            )
        lines.append(line)
    if "parameters" not in d:
        lines.append(f"  {d['parameter_count']} parameters, stored in the file of the fit")
    lines.append(
        f"  {'NRMSE: rms error over':<24} {'rms':>8} {'std':>8} {'range':>8}   of what was measured"
    )
    for role, s in d["scores"].items():
        three = " ".join(f"{s['over'][over]:>8.4f}" for over in ("rms", "std", "range"))
        lines.append(f"    {role:<22} {three}   {s['trials']} trials, {s['samples']} samples")
    if len(d["rms"]) <= MOST_TRIALS:
        lines += [f"    {name:<22} rms error {rms:.4g}" for name, rms in d["rms"].items()]
    lines += [f"  doubt        {doubt}" for doubt in d["doubts"]]
    return lines + [f"  left aside   column {name}" for name in d["left_aside"]]
