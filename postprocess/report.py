"""A report of a run or of a sweep: one HTML file with numbers, tables and pictures, that needs
nothing else.

Everything in it comes from the result file or the sweep directory. A sentence states each part that
cannot be drawn, for example because a channel was not stored or the run was too short.
"""

import hashlib
import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from clearance.postprocess import labels, plots, scenes, sections
from clearance.postprocess.channels import KINDS, WHOLE
from clearance.postprocess.contacts import SHOWN, contact_joints, contact_table, contacts
from clearance.postprocess.drawing import sketch
from clearance.postprocess.efforts import drive_efforts, efforts, friction, joint_friction
from clearance.postprocess.guides import guides
from clearance.postprocess.histories import MOST_PANELS, histories
from clearance.postprocess.pages import (
    Markup,
    Page,
    box,
    breakable,
    date,
    element,
    facts,
    join,
    measured,
    missing,
    number,
    points,
    quantity,
    scaled,
    table,
    valued,
)
from clearance.postprocess.spectra import spectra
from clearance.postprocess.sweep_report import sweep_page
from clearance.postprocess.tornado import tornado

from clearance.metrics.assumptions import assumptions
from clearance.metrics.metrics import Metric, Window, metrics, startup
from clearance.metrics.summary import ELASTIC, elastic_state
from clearance.results.reading import Damaged
from clearance.results.result import Result, open_result
from clearance.sweeping.index import Sweep, open_sweep

#: turns left out of a Poincare section, and passages that make one worth drawing
SETTLE, PASSAGES = 2.0, 4
ROUNDING = 1e-9  # of a turn
#: attributes that state where a run is from
ORIGINS = {"case_file": "case", "command": "command"}
#: channels that a sentence names at most
NAMED = 6
#: what a run file has of a joint as a complete: name, words, units
JOINT_FACTS = (
    ("film_pressure", "largest film pressure, an estimate", "Pa"),
    ("film_thickness_ratio", "smallest film thickness ratio", "1"),
    ("piezoviscous_number", "piezoviscous number", "1"),
    ("flattening_ratio", "elastic flattening over film thickness", "1"),
    ("share_full_film", "share of the time in full film", "1"),
    ("share_mixed", "share of the time in mixed lubrication", "1"),
    ("share_dry", "share of the time in dry contact", "1"),
    ("mean_asperity_share", "mean share of the load on the solids", "1"),
    ("film_table_error_closing", "error of the film table, journal closing in", "1"),
    ("film_table_error_opening", "error of the film table, journal receding", "1"),
)


def report(
    source: str | Path | Result | Sweep,
    path: str | Path,
    *,
    settle: float | None = None,
    sections: dict | None = None,
) -> Path:
    """Write the report of a run or of a sweep as one HTML file under `path`.

    source: a run's file or Result, a sweep's directory or Sweep. settle: turns of a run's start-up
        (seconds, where nothing turns; default one of two or more), whose numbers stand apart.
        sections: of links, see `assumptions`.
    Raises ValueError for a path that does not end in .html and for a run that has not ended. For
    paths that are no run and no sweep it raises FileNotFoundError and ValueError as `open_result`
    and `open_sweep` do.
    """
    path = Path(path)
    if path.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"report {path}: its name must end in .html")
    if isinstance(source, Result):
        return run_page(source, settle, sections).save(path)
    if isinstance(source, Sweep) or Path(source).is_dir():
        if settle is not None:
            raise ValueError(
                "settle is for the report of a run; a sweep has its own, given when it was run"
            )
        sweep = source if isinstance(source, Sweep) else open_sweep(source)
        return sweep_page(sweep, path).save(path)
    with open_result(source) as run:
        return run_page(run, settle, sections).save(path)


def run_page(run: Result, settle: float | None = None, sections: dict | None = None) -> Page:
    """The report of a run, not yet written; settle as in `report`.

    Raises ValueError for a file whose run has not ended.
    """
    if "method" not in run.solver:
        raise ValueError(f"{run.path} has no summary, for its run has not ended ({run.status})")
    page = Page(f"{run.attributes['case']}: report of {run.path.name}")
    page.head = head(run)
    page.section("Mechanism", *_mechanism(page, run))
    page.section(*_how(run))
    page.section("Summary", *summed(run, settle))
    if run.sensitivities:
        page.section("Sensitivities", *_sensitivities(page, run))
    page.section("Overview", _overview(page, run, settle), apart=True)
    if rubbing := _rubbing(page, run):
        page.section("Efforts and joint friction", *rubbing, apart=True)
    for joint in (j for j in run.scene["joints"] if j.get("clearance") is not None):
        page.section(f"Joint {joint['name']}", *_joint(page, run, joint["name"]), apart=True)
    if estimates := assumptions(run, sections, settle):
        page.section("Is it rigid? Is the film?", *_assumed(estimates))
    page.section("Motion in phase space", *_phase(page, run))
    page.section("Spectrum", _spectrum(page, run))
    page.section("Provenance", *_provenance(run))
    return page


def _assumed(estimates: list) -> list[Markup]:
    """Effects that the run leaves out, each estimate with its formula."""
    words = "Static estimates from this file; none of this is in the equations of motion."
    rows = [(a.part, a.text, a.formula) for a in estimates]
    return [element("p", words), table(["of", "estimate", "formula, source"], rows)]


# --- what was run


def head(run: Result) -> Markup:
    """Case, status, date and versions; warnings where they cannot be missed."""
    about, solver = run.attributes, run.solver
    versions = ", ".join(
        f"{n.removeprefix('version_')} {v}" for n, v in about.items() if n.startswith("version_")
    )
    title = element("h1", f"{about['case']}: {_how_long(run)}")
    written = f"Written {date(about['created'])} by {versions}."
    line = element("p", ". ".join(filter(None, (", ".join(labels.about(run)), written))))
    if run.complete:
        counted = f"{solver['steps']} steps" if "steps" in solver else f"{run.time.size} samples"
        state = box(
            "good", element("b", "complete"), f": {counted} in {quantity(solver['wall_s'], 's')}"
        )
    else:
        state = box("bad", element("b", "partial"), f": {run.status.removeprefix('partial: ')}")
    doubts = (
        box("doubt", element("b", f"Warnings ({len(run.warnings)})"), points(run.warnings))
        if run.warnings
        else ""
    )
    return join([title, line, state, doubts or element("p", "No warnings.")])


def _how_long(run: Result) -> str:
    time = run.time
    if not time.size:
        return "no sample"
    turns = f"{number(float(run.turns_at(time[-1])))} turns, " if run.turn else ""
    return f"{turns}{quantity(time[-1], 's')}"


def _mechanism(page: Page, run: Result) -> list[Markup]:
    scene, words = (
        run.scene,
        "The mechanism at the start of the run, to scale, with the paths of its points",
    )
    poses = [f"bodies/{b['name']}/{c}" for b in scene["bodies"] for c in ("x", "y", "theta")]
    drawn = page.picture(_needing(run, poses, partial(sketch, run)), words, run.time.size)
    return [scenes.described(scene), drawn, scenes.tables(scene)]


def _needing(
    run: Result, paths: list[str], draw: Callable[[Path], object]
) -> Callable[[Path], object]:
    """A way to draw a picture of channels that states which of them were not stored."""
    absent = [p for p in paths if p not in run]

    def checked(path: Path) -> object:
        if run.time.size < 2:
            raise ValueError("the run has fewer than two samples")
        if absent:
            more = f" and {len(absent) - NAMED} more" if len(absent) > NAMED else ""
            raise ValueError(f"these channels were not stored: {', '.join(absent[:NAMED])}{more}")
        return draw(path)

    return checked


def _how(run: Result) -> tuple[str, Markup]:
    """Method, tolerance and cost of the run, with its title."""
    if "rtol" in run.solver:
        return "Integration", _integration(run)
    rows = [
        ("method", run.solver["method"]),
        ("motion", _how_long(run)),
        ("samples", int(run.time.size)),
    ]
    return "Computation", facts([*rows, ("wall time", _wall_time(run))])


def _wall_time(run: Result) -> str:
    total, loop = (quantity(run.solver[n], "s") for n in ("wall_s", "loop_s"))
    return f"{total}, of it {loop} in the compiled loop"


def _integration(run: Result) -> Markup:
    """Method and why, tolerances, counts, cost, and how well the energy ledger closes."""
    solver = run.solver
    atol, steps = np.atleast_1d(solver["atol"]), run.values("solver/step")
    rows = [
        ("method", f"{solver['method']} ({solver['method_reason']})"),
        ("relative tolerance", number(solver["rtol"])),
        ("absolute tolerances", _range(atol, "") if atol.size else "no state is integrated"),
        ("simulated", _how_long(run)),
        ("samples", int(run.time.size)),
        ("steps", f"{solver['steps']}, {solver['rejected']} rejected"),
        (
            "step sizes",
            f"{_range(steps, 's')}, median {quantity(np.median(steps), 's')}"
            if steps.size
            else None,
        ),
        (
            "evaluations",
            f"{solver['evaluations']} of the right-hand side, {solver['jacobians']} of "
            "its Jacobian",
        ),
        ("factorisations", int(solver["factorisations"])),
        ("wall time", _wall_time(run)),
        ("energy residual", _ledger(run)),
    ]
    return facts(rows)


def _range(values: np.ndarray, units: str) -> str:
    low, high = (quantity(v, units) for v in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _ledger(run: Result) -> str:
    share, turned = run.solver["energy_residual_share"], run.facts("energy").get("turned_over", 0.0)
    if share == 0.0 and "energy/residual" not in run:
        return "no energy ledger was stored or integrated"
    words = f"at worst {number(share)} of the energy turned over in a stretch of the run"
    return f"{words}; {quantity(turned, 'J')} were turned over in all"


# --- what came out


def summed(run: Result, settle: float | None) -> list[Markup]:
    """The metrics of the settled motion, and the extremes of the start-up beside them.

    Where they need channels that were not stored, the ranges of those that were.
    """
    numbers, words = kept_metrics(run), "As the sweep that this run belongs to has stored them."
    before = {}
    if not numbers:
        window = Window.of(run, settle)
        if window is None:
            return [missing("The run ended before there was anything to sum up.")]
        turns = f", {number(window.turns)} turns" if window.turns else ""
        words = (
            f"Taken from t = {quantity(window.begin, 's')} to {quantity(window.end, 's')}{turns}."
        )
        try:
            numbers, before = metrics(run, settle), startup(run, settle)
        except KeyError as error:
            return [missing(f"There are no summary metrics: {error.args[0]}."), _ranges(run)]
    if not numbers:
        return [missing("There is nothing to sum up.")]
    shown, errors = (
        {name: measured(m.value, m.units) for name, m in numbers.items()},
        _errors(run, numbers),
    )
    titles = [
        "what",
        "value",
        "units",
        "at time [s]",
        "in the start-up",
        *([*ERROR_TITLES] if errors else []),
        "name",
    ]
    rows = [
        (
            m.text,
            valued(m.value, shown[n][0]),
            shown[n][1],
            _at(m),
            _before(before.get(n), m.units),
            *errors.get(n, [""] * len(ERROR_TITLES) if errors else ()),
            breakable(n),
        )
        for n, m in numbers.items()
    ]
    return [element("p", words), element("p", _stated(run)), table(titles, rows)]


ERROR_TITLES = ("stated error", "by the film table")


def _errors(run: Result, metrics_of: dict[str, Metric]) -> dict[str, list[str]]:
    """Stated errors of the metrics that they were stated of, and of these the parts of film
    tables.
    """
    errors = {
        n: run.errors[n]
        for n, m in metrics_of.items()
        if n in run.errors and run.errors[n].value == m.value
    }
    return {n: [_error(e.stated, e.units), _error(e.film, e.units)] for n, e in errors.items()}


def _error(error: float, units: str) -> str:
    """An error with two digits."""
    unit, factor = scaled(units, error)
    return f"{number(error * factor, 2)} {unit}".rstrip() if error else ""


def _stated(run: Result) -> str:
    """A sentence about the stated errors."""
    errors = run.errors
    if errors.reason:
        return f"No errors of these numbers are stated: {errors.reason}."
    loose = f"from a second run at rtol {number(errors.rtol[1])}"
    moved = "over the clearance" if run.clearances else "over their size"
    trajectory = (
        f"; trajectories within {number(errors.trajectory, 2)} {moved}"
        if "trajectory" in errors
        else ""
    )
    return (
        f"Errors of the integration are stated, {loose}{trajectory}. Those of film tables are "
        "apart."
    )


def _sensitivities(page: Page, run: Result) -> list[Markup]:
    """Tornado of the first metrics, and changes of all of them with their stated errors."""
    sensitivities = run.sensitivities
    rows = [
        (breakable(metric), parameter, *_change(sensitivities[metric, parameter]))
        for metric in sensitivities.telling(run.clearances)
        for parameter in sensitivities.parameters
        if (metric, parameter) in sensitivities
    ]
    titles = ["metric", "parameter", "change", "stated error", "units", "trusted"]
    words = "Changes of the metrics where a parameter grows by 1 % of its size."
    picture = page.picture(partial(tornado, run), words, run.time.size)
    return [element("p", words), picture, table(titles, rows, sortable=True)]


def _change(one) -> tuple:
    """Change, its error, units and mark of a sensitivity, as cells."""
    shown, units = measured(one.change, one.metric_units)
    error, trusted = _error(one.change_error, one.metric_units), "yes" if one.trusted else "no"
    return valued(one.change, shown), error, units, trusted


def _at(metric: Metric) -> str:
    return "" if metric.time is None else number(metric.time)


def _before(metric: Metric | None, units: str) -> str:
    return "" if metric is None else " ".join(measured(metric.value, units))


def kept_metrics(run: Result) -> dict[str, Metric]:
    """The metrics that a sweep has stored in a run's file; none in the file of a run by itself."""
    values, described = run.facts("metrics"), json.loads(run.facts("sweep").get("known", "{}"))
    return {n: Metric(float(values[n]), *described[n]) for n in described if n in values}


def kept_channels(run: Result) -> list[str]:
    """Paths of all channels that were stored."""
    owners = [f"{kind}/{name}" for kind in KINDS for name in run.names(kind)]
    return [f"{owner}/{name}" for owner in [*owners, *WHOLE] for name in run.names(owner)]


def _ranges(run: Result) -> Markup:
    """Smallest and largest values of the channels that were stored."""
    rows = []
    for path in kept_channels(run):
        low, high = run.extremes(path)
        unit, factor = scaled(run.units(path), low, high)
        rows.append([breakable(path), unit, *(valued(v, number(v * factor)) for v in (low, high))])
    return table(["channel", "units", "smallest", "largest"], rows)


def _overview(page: Page, run: Result, settle: float | None) -> Markup:
    """The overview, or where it needs more channels than were stored, those that were."""
    wanted, present = overview_channels(run), kept_channels(run)
    words = "Motion, drive, joint forces, energies, and journal paths of the joints with clearance"
    if joint_friction(run) and not run.clearances:
        words = (
            "Driving efforts, motion, energies, joint friction, reactions of the joints with "
            "friction, power lost"
        )
    drawn = page.picture(
        _needing(run, wanted, partial(plots.overview, run, settle=settle)), words, run.time.size
    )
    if all(p in run for p in wanted) or not present or run.time.size < 2:
        return drawn
    instead = partial(histories, run, channels=present[:MOST_PANELS])
    return join([drawn, page.picture(instead, "Channels that were stored", run.time.size)])


def overview_channels(run: Result) -> list[str]:
    """Paths of the channels that the overview draws."""
    scene, rubbing = run.scene, joint_friction(run)
    paths = [f"bodies/{plots.output_body(scene)}/{c}" for c in ("ax", "ay")]
    drives = run.names("drives")
    paths += [f"drives/{d}/{'force' if f'drives/{d}/force' in run else 'torque'}" for d in drives]
    paths += [] if drives else [f"bodies/{b}/theta" for b in run.names("bodies")]
    paths += [f"joints/{j}/force_{axis}" for j in run.names("joints") for axis in "xy"]
    return [*paths, *(f"joints/{j}/power_loss" for j in rubbing), "energy/kinetic"]


def _rubbing(page: Page, run: Result) -> list[Markup]:
    """Driving efforts where no joint has clearance, or joints without it rub; friction of these."""
    rubbing, parts = joint_friction(run), []
    if drive_efforts(run) and (rubbing or not run.clearances):
        draw = _needing(run, [], partial(efforts, run))
        words = "Driving torques and forces" + (
            ", dashed without joint friction; what friction adds" if rubbing else ""
        )
        parts.append(page.picture(draw, words, run.time.size))
    if rubbing:
        words = (
            "Friction of hinges and slides and its load along time, and friction over the rate "
            "of the joint"
        )
        parts.append(page.picture(_needing(run, [], partial(friction, run)), words, run.time.size))
    return parts


def _joint(page: Page, run: Result, joint: str) -> list[Markup]:
    """Extremes, journal path, regimes and contacts of a joint with clearance."""
    numbers, group = run.facts(f"joints/{joint}"), f"joints/{joint}"
    described = run.described(joint)
    elastic = elastic_state(run, described)  # its film is no rigid one that pressure flattens
    rows = [
        (text, quantity(float(numbers[name]), units))
        for name, text, units in JOINT_FACTS
        if name in numbers and not (elastic and name == "flattening_ratio")
    ]
    rows += [(ELASTIC[n][0], quantity(v, ELASTIC[n][1])) for n, v in elastic.items()]
    parts = [element("div", element("p", "Over the entire run:"), facts(rows))] if rows else []
    if described["type"] == "ClearancePrismatic":
        draw = _needing(
            run, [f"{group}/{c}" for c in ("offset", "tilt")], partial(guides, run, joints=joint)
        )
        words = f"The block in guide {joint}, its offset and tilt, and what it touches with"
        return [*parts, page.picture(draw, words, run.time.size), *_contacts(page, run, joint)]
    if described["type"] != "ClearanceRevolute":
        return [*parts, *_contacts(page, run, joint)]
    mixed = described["transition"]
    channels = ["eccentricity_x", "eccentricity_y", *(sorted(plots.OF_STATES) if mixed else [])]
    draw = _needing(
        run, [f"{group}/{c}" for c in channels], partial(plots.orbits, run, joints=joint)
    )
    words = f"Path of the journal's centre in joint {joint}, over the clearance"
    words += (
        "; film thickness ratio, states and load on the solids over the last turns" if mixed else ""
    )
    drawn = page.picture(draw, words, run.time.size)
    parts = [*parts, drawn] if mixed else [element("div", *parts, drawn, class_="pair")]
    return [*parts, *(_contacts(page, run, joint) if joint in contact_joints(run) else [])]


def _contacts(page: Page, run: Result, joint: str) -> list[Markup]:
    title = element("h3", f"Contacts of joint {joint}")
    try:
        numbers = contact_table(run)[joint]
    except Damaged:
        raise
    except ValueError as error:
        return [title, missing(f"Not known: {error}.")]
    if not numbers["contacts"]:
        return [title, element("p", "No contact in this run, that of asperities alone left out.")]
    rows = [
        (text, " ".join(filter(None, (number(factor * numbers[n]), u))))
        for n, text, u, factor in SHOWN
    ]
    draw = partial(contacts, run, joints=joint)
    return [
        title,
        element("p", "Over the entire run:"),
        facts(rows),
        page.picture(draw, f"Contact statistics of joint {joint}", len(run.events["time"])),
    ]


def _turns(run: Result) -> float:
    """Turns of the drive that a run has; 0 where nothing turns at constant speed."""
    return float(run.turns_at(run.time[-1])) if run.turn and run.time.size else 0.0


def _settle(run: Result) -> tuple[float, str]:
    """Turns left out of a picture, the first where there is a second, and what its caption states
    of them.
    """
    return (1.0, ", without the first turn") if _turns(run) > 2.0 - ROUNDING else (0.0, "")


def _phase(page: Page, run: Result) -> list[Markup]:
    """Phase portraits, and where there are enough turns a Poincare section."""
    body, (settle, without) = plots.output_body(run.scene), _settle(run)
    moves = [f"bodies/{body}/{rate}{axis}" for rate in ("", "v", "a") for axis in "xy"]
    draw = _needing(run, moves, partial(sections.portrait, run, settle=settle))
    parts = [page.picture(draw, f"Phase portraits of {body}{without}", run.time.size)]
    if not run.turn:
        return [*parts, missing("No drive turns at constant speed: there is no Poincaré section.")]
    if _turns(run) < (enough := SETTLE + PASSAGES - 1.0) - ROUNDING:
        text = (
            f"A Poincaré section is drawn from {enough:g} turns on; this run has "
            f"{number(_turns(run))}."
        )
        return [*parts, missing(text)]
    words = f"Poincaré section, once a turn of the drive, without the first {SETTLE:g} turns"
    journal = [f"joints/{j}/eccentricity_{axis}" for j in list(run.clearances)[:1] for axis in "xy"]
    return [
        *parts,
        page.picture(
            _needing(run, moves + journal, partial(sections.poincare, run, settle=SETTLE)), words
        ),
    ]


def _spectrum(page: Page, run: Result) -> Markup:
    """Spectrum of the last body's acceleration along the axis that it moves on more."""
    body, (settle, without) = plots.output_body(run.scene), _settle(run)

    def draw(path: Path) -> Path:
        channels = [f"bodies/{body}/{c}" for c in ("ax", "ay") if f"bodies/{body}/{c}" in run]
        if not channels:
            raise ValueError("its channels ax and ay were not stored")
        largest = max(
            channels, key=lambda p: float(np.ptp(run.values(p))) if run.time.size else 0.0
        )
        return spectra(run, path, channels=largest, settle=settle)

    return page.picture(
        draw, f"Amplitude spectrum of the acceleration of {body}{without}", run.time.size
    )


def _parameters(about: dict, name: str) -> str | None:
    """Parameters of the case in SI, None where the file has none."""
    values = json.loads(about.get(name, "{}")).items()
    texts = [f"{n} = {v:g}" if isinstance(v, float) else f"{n} = {v}" for n, v in values]
    return ", ".join(texts) or None


def _provenance(run: Result) -> list[Markup]:
    """Sources of the numbers, and notes for their reader."""
    about, path = run.attributes, run.path
    digest = hashlib.sha256(str(about["kernel"]).encode()).hexdigest()
    rows = [
        ("file", path.name),
        ("size", f"{number(path.stat().st_size / 1e6, 4)} MB"),
        ("format", f"{about['format']} {about['format_version']}"),
        ("created", date(about["created"])),
        *((title, element("code", about[n])) for n, title in ORIGINS.items() if about.get(n)),
        ("parameters given", _parameters(about, "parameters")),
        ("default parameters", _parameters(about, "defaults")),
        ("auto means", _parameters(about, "resolved")),
        *((n.replace("_", " of ", 1), v) for n, v in about.items() if n.startswith("version_")),
        ("kernel", element("code", f"sha256 {digest}")),
    ]
    rows.append(("channels stored", len(kept_channels(run))))
    how = (
        f"import clearance as cl\nrun = cl.open_result({path.name!r})\nrun.time, run.scene, "
        'run.names("bodies")'
    )
    return [facts(rows), element("h3", "In Python"), element("pre", how)]
