"""Contacts of dry and mixed joints: how many, how hard, how long, and where on the bearing.

Joints with impacts have a row for each contact in the result's events. In joints whose contact sets
in gradually (mixed ones, mostly) a contact is a stretch of samples with a contact force, that of
asperities left out: its start and length are known to a sample, and its impact speed is not known.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import kept, name_of
from clearance.postprocess.labels import headline

from clearance.metrics.metrics import CORNERS
from clearance.results.record import Record

#: most joints on a page
MOST_JOINTS = 3
SECTORS = 36
#: largest over smallest value from which axes are logarithmic
FAR_APART = 100.0


@dataclass(frozen=True)
class Contacts:
    """The contacts of a joint, arrays (contacts,): start [s], duration [s], impact speed [m/s],
    peak force [N].

    angle: of the eccentricity at the start [rad], nan where it is not known; spot: corner of a
        block in its guide, empty texts of hinges; `open`: not over at the end of the run;
    sampled: True for contacts from the samples, not from the events; start and end of the time
        window [s]; share of it in contact, nan for no time.
    """

    time: np.ndarray
    duration: np.ndarray
    impact_speed: np.ndarray
    peak_force: np.ndarray
    angle: np.ndarray
    spot: np.ndarray
    open: np.ndarray
    sampled: bool
    start: float
    end: float
    share: float


def contact_joints(record: Record) -> list[str]:
    """Clearance joints whose scene gives them a contact law."""
    return [
        j["name"] for j in record.scene["joints"] if j.get("clearance") is not None and j["contact"]
    ]


def contacts_of(
    record: Record, joint: str, *, settle: float = 0.0, frame: str = "bearing"
) -> Contacts:
    """Contacts of a joint that start after `settle` turns.

    frame: whether angles are seen from the "bearing", which turns with its body, or from the fixed
        axes ("world"). The eccentricity is interpolated linearly between the samples about the
        start of the contact. It is right to a fraction of a degree where samples are closer than
        contacts, and off by tens where the journal bounces between two samples.
    Raises ValueError for a joint without contact law, another frame, and a run with no sample after
    `settle`. A mixed joint with neither events nor contact force in the result raises it, too.
    """
    joints = contact_joints(record)
    if joint not in joints:
        raise ValueError(
            f"joint {joint!r} has no contact law in {name_of(record)}; with one: "
            f"{', '.join(joints) or 'none'}"
        )
    if frame not in ("bearing", "world"):
        raise ValueError(f"frame must be bearing or world, got {frame!r}")
    time = record.time[kept(record, settle=settle)]
    if record.time.size and not time.size:
        raise ValueError(f"{name_of(record)} has no sample after turn {settle:g}")
    start, end = (float(time[0]), float(time[-1])) if time.size else (0.0, 0.0)
    events = record.events
    mine = np.array([spot.partition("/")[0] == joint for spot in events["joint"]], bool)
    sampled = not mine.any() and _gradual(record, joint)
    rows = _from_samples(record, joint) if sampled else _from_events(events, mine)
    touching = _time_in_contact(rows, start, end)
    late = rows["time"] >= start - 1e-12 * end
    rows = {name: values[late] for name, values in rows.items()}
    angle = _angles(record, joint, rows["time"], frame)
    share = float(touching / (end - start)) if end > start else np.nan
    return Contacts(**rows, angle=angle, sampled=sampled, start=start, end=end, share=share)


def _time_in_contact(rows: dict[str, np.ndarray], start: float, end: float) -> float:
    """Time with any contact [s]; those of several corners overlap."""
    order = np.argsort(rows["time"], kind="stable")
    begin, over = rows["time"][order], np.minimum(rows["time"] + rows["duration"], end)[order]
    before = np.maximum.accumulate(np.concatenate([[start], over[:-1]])) if over.size else over
    return np.maximum(over - np.maximum(begin, before), 0.0).sum()


def _gradual(record: Record, joint: str) -> bool:
    """True where the samples show contact and the events show none.

    Raises ValueError where only they could, the joint being a mixed one, and its contact force was
    not stored.
    """
    path = f"joints/{joint}/contact_force"
    if path in record:
        return bool((record.values(path) > 0.0).any())
    if record.described(joint).get("transition"):
        raise ValueError(
            f"{name_of(record)}: mixed joint {joint} needs the channel {path}, which was not stored"
        )
    return False


def _from_events(events: dict[str, np.ndarray], mine: np.ndarray) -> dict[str, np.ndarray]:
    names = ("time", "duration", "impact_speed", "peak_force")
    spots = np.array([spot.partition("/")[2] for spot in events["joint"][mine]], str)
    return {n: events[n][mine] for n in names} | {
        "spot": spots,
        "open": events["kind"][mine] == "open_contact",
    }


def _from_samples(record: Record, joint: str) -> dict[str, np.ndarray]:
    """Stretches of samples with a contact force; each sample stands for the time half-way to its
    neighbours.
    """
    time, force = record.time, record.values(f"joints/{joint}/contact_force")
    edges = np.diff(np.concatenate([[0], (force > 0.0).astype(int), [0]]))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    middle = np.concatenate([time[:1], 0.5 * (time[1:] + time[:-1]), time[-1:]])
    return {
        "time": middle[first],
        "duration": middle[last + 1] - middle[first],
        "impact_speed": np.full(len(first), np.nan),
        "peak_force": np.array([force[a : b + 1].max() for a, b in zip(first, last, strict=True)]),
        "spot": np.full(len(first), ""),
        "open": last == len(time) - 1,
    }


def _angles(record: Record, joint: str, times: np.ndarray, frame: str) -> np.ndarray:
    """Angles of the eccentricity [rad] in (-pi, pi], nan where channels were not stored or no
    sample is about.
    """
    paths = [f"joints/{joint}/eccentricity_{axis}" for axis in "xy"]
    bearing = record.described(joint)["a"]["body"]
    turned = f"bodies/{bearing}/theta"
    if (
        not all(p in record for p in paths)
        or frame == "bearing"
        and bearing != "ground"
        and turned not in record
    ):
        return np.full(len(times), np.nan)
    if not len(times):
        return np.zeros(0)
    x, y = (np.interp(times, record.time, record.values(p)) for p in paths)
    angle = np.arctan2(y, x)
    if frame == "bearing" and bearing != "ground":
        angle -= np.interp(times, record.time, record.values(turned))
    return np.pi - np.mod(np.pi - angle, 2.0 * np.pi)


def contact_table(record: Record, *, settle: float = 0.0) -> dict[str, dict[str, float]]:
    """Contact statistics of every joint with a contact law, in SI units; nan for what is not known.

    Contacts that the end of the run cuts off count in `contacts`, `open_contacts` and
    `share_in_contact`, not in the durations. `contact_angle` is the circular mean on the bearing
    [rad], `angle_concentration` 0 for contacts all round and 1 for all at one place. `sampled` is 1
    where contacts come from the samples. Raises ValueError as `contacts_of`.
    """
    return {
        joint: _numbers(record, contacts_of(record, joint, settle=settle))
        for joint in contact_joints(record)
    }


def _numbers(record: Record, touches: Contacts) -> dict[str, float]:
    count, span, over = (
        len(touches.time),
        touches.end - touches.start,
        touches.duration[~touches.open],
    )
    turns = record.turns_at(touches.end) - record.turns_at(touches.start) if record.turn else 0.0
    mean = (
        np.exp(1j * touches.angle).mean() if count and np.isfinite(touches.angle).all() else np.nan
    )
    return {
        "contacts": count,
        "open_contacts": int(touches.open.sum()),
        "contacts_per_second": count / span if span > 0.0 else np.nan,
        "contacts_per_turn": count / turns if turns > 0.0 else np.nan,
        "share_in_contact": touches.share,
        "mean_impact_speed": _of(np.mean, touches.impact_speed),
        "largest_impact_speed": _of(np.max, touches.impact_speed),
        "mean_peak_force": _of(np.mean, touches.peak_force),
        "largest_peak_force": _of(np.max, touches.peak_force),
        "median_duration": _of(np.median, over),
        "longest_duration": _of(np.max, over),
        "contact_angle": float(np.angle(mean)) if np.isfinite(mean) else np.nan,
        "angle_concentration": float(abs(mean)) if np.isfinite(mean) else np.nan,
        "sampled": int(touches.sampled),
    }


def _of(statistic, values: np.ndarray) -> float:
    return float(statistic(values)) if values.size and np.isfinite(values).all() else float("nan")


def contacts(
    record: Record,
    path: str | Path,
    *,
    joints: str | list[str] | None = None,
    settle: float = 0.0,
    frame: str = "bearing",
) -> Path:
    """Contact statistics of joints, six panels each, saved under `path`.

    Impact speeds, peak forces over them, durations, contacts a turn, where on the bearing contacts
    began (their number, weighted by nothing), and the numbers of `contact_table`. joints: default
    the first three with a contact law;
    settle: turns left out at the start; frame: of the angles, see `contacts_of`. A run without
        contacts gets a picture that states so.
    Raises ValueError for a joint without contact law.
    """
    names = (
        [joints]
        if isinstance(joints, str)
        else list(joints or contact_joints(record)[:MOST_JOINTS])
    )
    by_joint = {joint: contacts_of(record, joint, settle=settle, frame=frame) for joint in names}
    since = f"from turn {settle:g} on" if settle else ""
    if not any(len(c.time) for c in by_joint.values()):
        return _nothing(record, path, names, since)
    none = [joint for joint, touches in by_joint.items() if not len(touches.time)]
    by_joint = {joint: touches for joint, touches in by_joint.items() if len(touches.time)}
    figure = figures.sheet(7.0, 0.6 + 7.2 * len(by_joint))
    pages = figure.subfigures(len(by_joint), squeeze=False)[:, 0]
    for page, (joint, touches) in zip(pages, by_joint.items(), strict=True):
        _page(page, record, joint, touches, frame)
    quiet = _no_contact(record, none) if none else ""
    figure.suptitle(headline([record], [""], since, quiet), fontsize="medium")
    return figures.save(figure, path)


def _no_contact(record: Record, joints: list[str]) -> str:
    """That joints have no contact, and whether asperities, which do not count as one, may have
    carried load.
    """
    rough = any(j.get("asperity") for j in record.scene["joints"] if j["name"] in joints)
    return f"no contact in joint {', '.join(joints)}" + (
        ", load on asperities left out" if rough else ""
    )


def _nothing(record: Record, path: str | Path, joints: list[str], since: str) -> Path:
    figure = figures.sheet(7.0, 2.0)
    text = _no_contact(record, joints) if joints else "no joint of this scene has a contact law"
    figures.note(figure.add_subplot(), text)
    figure.suptitle(headline([record], [""], since), fontsize="medium")
    return figures.save(figure, path)


def _page(page, record: Record, joint: str, touches: Contacts, frame: str) -> None:
    """The six panels of a joint."""
    grid = page.add_gridspec(3, 2)
    where = "found in the samples" if touches.sampled else "from the events"
    page.suptitle(f"joint {joint}: {len(touches.time)} contacts, {where}", fontsize="medium")
    panels = [page.add_subplot(grid[i // 2, i % 2]) for i in range(4)]
    unknown = "not known: contact sets in gradually" if touches.sampled else None
    _histogram(panels[0], touches.impact_speed, "impact speed [m/s]", unknown)
    _forces(panels[1], touches)
    _histogram(
        panels[2], 1e3 * touches.duration[~touches.open], "duration [ms]", "no contact has ended"
    )
    _rate(panels[3], record, touches)
    if any(touches.spot):
        _corners(page.add_subplot(grid[2, 0]), touches)
    else:
        _rose(page.add_subplot(grid[2, 0], projection="polar"), touches, frame)
    _list(page.add_subplot(grid[2, 1]), _numbers(record, touches))


def _histogram(axes, values: np.ndarray, label: str, otherwise: str | None) -> None:
    """Numbers of contacts in bins, logarithmic ones where the values are of different sizes."""
    values = values[np.isfinite(values) & (values > 0.0)]
    if not values.size:
        figures.note(axes, otherwise or "none above zero")
        axes.set_xlabel(label)
        return
    low, high, bins = (
        0.999 * values.min(),
        1.001 * values.max(),
        int(np.clip(2.0 * np.sqrt(values.size), 5, 40)),
    )
    log = figures.wide(values, FAR_APART)
    edges = (np.geomspace if log else np.linspace)(low, high, bins + 1)
    axes.hist(values, edges, color="0.6", edgecolor="black", lw=0.5)
    axes.axvline(
        np.median(values), color="#d55e00", lw=1.2, label=f"median {np.median(values):.3g}"
    )
    axes.locator_params(axis="y", integer=True)
    axes.set_xscale("log" if log else "linear")
    figures.finish(axes, "contacts [-]", label)


def _forces(axes, touches: Contacts) -> None:
    """Peak force over impact speed, or over duration where the impact speed is not known."""
    x, label = (
        (1e3 * touches.duration, "duration [ms]")
        if touches.sampled
        else (touches.impact_speed, "impact speed [m/s]")
    )
    # their durations are cut off
    shown = (x > 0.0) & (touches.peak_force > 0.0) & ~(touches.sampled & touches.open)
    x, force = x[shown], touches.peak_force[shown]
    axes.plot(x, force, "o", ms=3.0, mfc="none", mew=0.6, color="black")
    axes.set_xscale("log" if figures.wide(x, FAR_APART) else "linear")
    axes.set_yscale("log" if figures.wide(force, FAR_APART) else "linear")
    figures.finish(axes, "peak contact force [N]", label)


def _rate(axes, record: Record, touches: Contacts) -> None:
    """Contacts that begin in each turn, or in each twentieth of the time where nothing turns."""
    span = touches.end - touches.start
    bin_length = record.turn or span / 20.0 or 1.0
    count = max(int(np.ceil(span / bin_length - 1e-6)), 1)
    edges = touches.start + bin_length * np.arange(count + 1)
    edges[-1] = min(edges[-1], touches.end)  # the last turn may not be complete
    numbers = np.histogram(touches.time, edges)[0]
    x = edges / record.turn if record.turn else edges
    axes.stairs(numbers, x, fill=True, fc="0.6", ec="black", lw=0.5)
    axes.locator_params(axis="y", integer=True)
    every = "contacts a turn [-]" if record.turn else f"contacts in {bin_length:.3g} s [-]"
    figures.finish(axes, every, "drive turns [-]" if record.turn else "time [s]")


def _corners(axes, touches: Contacts) -> None:
    """Numbers of contacts of each corner of a block."""
    names = [
        f"{'top' if y > 0.0 else 'bottom'}\n{'front' if x > 0.0 else 'rear'}" for _, x, y in CORNERS
    ]
    numbers = [(touches.spot == corner).sum() for corner, _, _ in CORNERS]
    axes.bar(names, numbers, color="0.6", edgecolor="black", lw=0.5)
    axes.locator_params(axis="y", integer=True)
    figures.finish(axes, "contacts [-]", "corner")


def _rose(axes, touches: Contacts, frame: str) -> None:
    """Numbers of contacts around the bearing."""
    angle = touches.angle[np.isfinite(touches.angle)]
    axes.set_title(f"where they began, in the {frame} frame", fontsize="small")
    if not angle.size:
        axes.set_xlabel("eccentricity or bearing angle not stored")
        return
    numbers, edges = np.histogram(angle, np.linspace(-np.pi, np.pi, SECTORS + 1))
    axes.bar(
        edges[:-1],
        numbers,
        width=np.diff(edges),
        align="edge",
        color="0.6",
        edgecolor="black",
        lw=0.5,
    )
    axes.set_xlabel("angle of the eccentricity; radius: contacts [-]", fontsize="small")
    axes.tick_params(labelsize="small")
    near = numbers + np.roll(numbers, 1) + np.roll(numbers, -1)
    # where no bar hides its numbers
    axes.set_rlabel_position(np.degrees(edges[np.argmin(near)] + np.pi / SECTORS))
    step = -(-int(numbers.max()) // 3)
    axes.set_yticks(np.arange(step, numbers.max() + 1, step))


#: what the list of numbers shows: name, words, units, factor
SHOWN = (
    ("contacts", "contacts", "", 1.0),
    ("open_contacts", "of these not over at the end", "", 1.0),
    ("contacts_per_turn", "contacts a turn", "", 1.0),
    ("share_in_contact", "share of the time in contact", "%", 100.0),
    ("mean_impact_speed", "mean impact speed", "m/s", 1.0),
    ("largest_impact_speed", "largest impact speed", "m/s", 1.0),
    ("mean_peak_force", "mean peak force", "N", 1.0),
    ("largest_peak_force", "largest peak force", "N", 1.0),
    ("median_duration", "median duration", "ms", 1e3),
    ("longest_duration", "longest duration", "ms", 1e3),
)


def _list(axes, numbers: dict[str, float]) -> None:
    axes.axis("off")
    for i, (name, label, units, factor) in enumerate(SHOWN):
        value = factor * numbers[name]
        digits = f"{value:.0f}" if 1e4 <= abs(value) < 1e8 else f"{value:.4g}"
        text = f"{digits} {units}" if np.isfinite(value) else "not known"
        for x, words, side in ((0.0, label, "left"), (1.0, text, "right")):
            axes.text(
                x,
                0.95 - 0.1 * i,
                words,
                fontsize="small",
                ha=side,
                va="center",
                transform=axes.transAxes,
            )
