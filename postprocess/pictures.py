"""Pictures of runs, sweeps and lives: which there are, with which options, and what draws them."""

import argparse
from contextlib import ExitStack
from pathlib import Path

from clearance.files.texts import listed
from clearance.values.checks import meant

#: kinds of pictures of run files and of sweeps, each with the options that belong to it; the first
#: is the default
OF_RUNS = {
    "overview": ("settle",),
    "history": ("channels", "along", "last"),
    "orbit": ("joint",),
    "phase": ("channels", "settle"),
    "poincare": ("channels", "joint", "settle", "angle"),
    "spectrum": ("channels", "settle"),
    "contacts": ("joint", "settle"),
    "guide": ("joint",),
    "efforts": (),
    "friction": ("joint",),
    "pressure": ("joint",),
    "sketch": ("turns",),
    "tornado": ("metrics",),
    "measured": ("measured", "channels", "column", "shift", "settle"),
    "animation": ("turns", "frames", "magnify"),
}
OF_SWEEPS = {
    "map": ("metrics", "x", "y", "at", "only_settled"),
    "curves": ("metrics", "x", "at", "only_settled"),
    "bifurcation": ("x", "channels", "settle", "angle", "at"),
    "scatter": ("metrics",),
}
#: kinds of pictures of lives, each with its options
OF_LIVES = {"life": ("joint", "surface"), "animation": ("joint", "surface", "frames")}
#: kinds that lay several runs over each other
OF_SEVERAL = ("history", "phase", "poincare", "spectrum")
KINDS = OF_LIVES | OF_RUNS | OF_SWEEPS
#: options that select what is shown
SHOWN = ("measured", "channels", "joint", "metrics", "x")
OPTIONS = tuple(dict.fromkeys(o for some in (*KINDS.values(), *OF_LIVES.values()) for o in some))
FRAMES = 120


def plot(source, kind: str | None = None, output: str | Path | None = None, **options):
    """Draw a picture of a run or of a sweep, as `clearance plot` does.

    source: a run file or Result (for history, phase, poincare and spectrum also a list of them), or
    the directory of a sweep or Sweep. kind, of a run: overview, history, orbit, phase, poincare,
    spectrum, contacts, guide, efforts, friction, pressure, sketch, tornado, measured, animation. Of
    a sweep: map, curves, bifurcation, scatter; default: the overview of a run, the map of a grid,
    the scatter of a scatter, the curves of other sweeps.
    output: .png, .pdf or .svg, of an animation .gif or .mp4. The path is returned; without one,
    the matplotlib figure, which notebooks show.
    options: those of the command that belong to the kind, in SI, such as joint="B",
    channels="slider.ax,B.force" or at={"model": "dry"}.
    Raises TypeError for other options, and ValueError for what cannot be drawn.
    """
    if kind is not None and kind not in KINDS:
        answer = f"{meant(kind, KINDS)}; there are {', '.join(KINDS)}"
        raise ValueError(f"plot: no kind {kind!r}{answer}")
    for name in options:
        if name not in OPTIONS:
            answer = f"{meant(name, OPTIONS)}; it has {', '.join(OPTIONS)}"
            raise TypeError(f"plot has no option {name!r}{answer}")
    if output is None and kind == "animation":
        raise ValueError("plot: an animation needs a file, .gif or .mp4")
    chosen = argparse.Namespace(
        **dict.fromkeys(OPTIONS) | options, output=output, returned=output is None
    )
    chosen.at = chosen.at and [f"{name}={value}" for name, value in chosen.at.items()]
    sources = source if isinstance(source, list | tuple) else [source]
    return drawn(chosen, [*map(_where, sources), *([kind] if kind else [])])


class Pictures:
    """Pictures of a run or a sweep by their kinds: `run.plot.orbit("B")`,
    `sweep.plot.map("period")`.

    The first argument of most kinds is what they show: channels, a joint, metrics. Options are
    those of `clearance plot`, in SI; `output` saves the picture. Called itself it draws the
    overview of a run, the map of a grid, the curves of other sweeps.
    """

    def __init__(self, source):
        self._source = source

    @property
    def _kinds(self) -> dict:
        return OF_SWEEPS if hasattr(self._source, "folder") else OF_RUNS

    def __call__(self, **options):
        return plot(self._source, **options)

    def __repr__(self) -> str:
        return f"<pictures of {self._source!r}: {', '.join(self._kinds)}>"

    def __getattr__(self, kind: str):
        if kind.startswith("_") or kind not in self._kinds:
            answer = f"{meant(kind, self._kinds)}; there are {', '.join(self._kinds)}"
            raise AttributeError(f"no picture {kind!r}{answer}")
        first = next((name for name in self._kinds[kind] if name in SHOWN), None)

        def draw(shown=None, output: str | Path | None = None, **options):
            if shown is not None:
                if first is None:
                    raise TypeError(f"{kind} takes no argument but options, as output={shown!r}")
                options[first] = shown
            return plot(self._source, kind, output, **options)

        draw.__name__ = kind
        draw.__doc__ = f"Picture {kind!r}; options: {', '.join(self._kinds[kind]) or 'none'}."
        return draw

    def __dir__(self):
        return [*super().__dir__(), *self._kinds]


def _where(source):
    """Path of a run's file or of a sweep's directory; a run without a file itself."""
    if hasattr(source, "names") and not hasattr(source, "path"):
        return source
    return str(getattr(source, "folder", getattr(source, "path", source)))


def drawn(options, words: list) -> Path:
    """The picture of the options of `clearance plot`; words: what it is of, then its kind."""
    paths, kind = _inputs(words)
    if isinstance(paths[0], Path) and is_life(paths[0]):
        return _of_life(options, paths[0], kind or "life")
    if isinstance(paths[0], Path) and paths[0].is_dir():
        return _of_sweep(options, paths[0], kind)
    kind = kind or ("measured" if options.measured else "overview")
    _check(options, kind)
    return _of_runs(options, paths, kind)


def _inputs(words: list[str]) -> tuple[list[Path], str | None]:
    """Files or directory, and the kind of picture where one is named."""
    kind = words[-1] if len(words) > 1 and words[-1] in KINDS else None
    paths = [Path(w) if isinstance(w, str) else w for w in (words[:-1] if kind else words)]
    named = [p for p in paths if isinstance(p, Path)]
    for path in named:
        if not path.exists():
            hint = (
                f", and {path} is no kind of picture; those are {', '.join(KINDS)}"
                if path != paths[0]
                else ""
            )
            raise FileNotFoundError(f"no file or directory {path}{hint}")
    folders = [p for p in named if p.is_dir()]
    if folders and len(paths) > 1:
        raise ValueError(f"{folders[0]} is a directory: a sweep or a life has a picture of its own")
    kinds, source = (OF_SWEEPS, "a sweep") if folders else (OF_RUNS, "a run file")
    if folders and is_life(folders[0]):
        kinds, source = OF_LIVES, "a life"
    if kind is not None and kind not in kinds:
        raise ValueError(
            f"{paths[0]} is {source}, of which there is no {kind}; there is {', '.join(kinds)}"
        )
    if len(paths) > 1 and kind not in OF_SEVERAL:
        raise ValueError(
            f"several runs are for {', '.join(OF_SEVERAL)}, not for {kind or 'overview'}"
        )
    return paths, kind


def _output(options, default: Path) -> Path | None:
    """Path of the picture; None where the figure is returned."""
    return None if getattr(options, "returned", False) else Path(options.output or default)


def _check(options, kind: str) -> None:
    for name in OPTIONS:
        if getattr(options, name) is not None and name not in KINDS[kind]:
            belongs = ", ".join(k for k, options_of in KINDS.items() if name in options_of)
            raise ValueError(
                f"--{name.replace('_', '-')} does not belong to {kind}; it belongs to {belongs}"
            )


def _chosen(options, *names: str) -> dict:
    """Options that were given, by the names of the drawing functions' arguments."""
    return {n: v for n in names if (v := getattr(options, n)) is not None}


# --- pictures of runs
def _of_runs(options, paths: list[Path], kind: str) -> Path:
    from clearance.results.result import open_result

    suffix = ".gif" if kind == "animation" else ".png"
    first = paths[0] if isinstance(paths[0], Path) else Path("run")
    output = _output(options, first.with_name(f"{first.stem}_{kind}{suffix}"))
    with ExitStack() as opened:
        records = [
            opened.enter_context(open_result(p)) if isinstance(p, Path) else p for p in paths
        ]
        for record in records:
            if record.time.size < 2:
                name = getattr(record, "path", record.attributes["case"])
                raise ValueError(
                    f"{name} has {record.time.size} sample(s): there is nothing to draw"
                )
        return DRAW[kind](options, records, output)


def _overview(options, records, output: Path) -> Path:
    from clearance.postprocess.plots import overview

    try:
        return overview(records[0], output, **_chosen(options, "settle"))
    except (KeyError, AttributeError) as error:  # exceptions for a channel that is not in the file
        reason = str(error.args[0]).partition(";")[0]
        raise ValueError(
            f"overview needs more channels than were stored: {reason}; draw a history"
        ) from None


def _history(options, records, output: Path) -> Path:
    from clearance.postprocess.histories import histories

    channels = listed(options.channels) or _telling(records[0])
    return histories(records, output, channels=channels, **_chosen(options, "along", "last"))


def _telling(record) -> list[str]:
    """Acceleration of the last body, what drives, forces of the first clearance joints."""
    from clearance.postprocess.channels import principal

    efforts = [f"drives/{d}/{e}" for d in record.names("drives") for e in ("torque", "force")]
    forces = [
        f"joints/{j}/force" for j in list(record.clearances)[:3] if f"joints/{j}/force_x" in record
    ]
    return [principal(record).format("a"), *(e for e in efforts if e in record), *forces]


def _orbit(options, records, output: Path) -> Path:
    from clearance.postprocess.plots import orbits

    return orbits(records[0], output, joints=listed(options.joint))


def _phase(options, records, output: Path) -> Path:
    from clearance.postprocess.sections import portrait

    return portrait(records, output, pairs=_pairs(options), **_chosen(options, "settle"))


def _poincare(options, records, output: Path) -> Path:
    from clearance.postprocess.sections import poincare

    return poincare(
        records, output, pairs=_pairs(options), **_chosen(options, "joint", "angle", "settle")
    )


def _pairs(options) -> list[tuple[str, str]] | None:
    """Channels two by two."""
    names = listed(options.channels)
    if names is None:
        return None
    if not names or len(names) % 2:
        raise ValueError(f"--channels {options.channels}: expected pairs X,Y or X1,Y1,X2,Y2")
    return list(zip(names[::2], names[1::2], strict=True))


def _spectrum(options, records, output: Path) -> Path:
    from clearance.postprocess.channels import principal
    from clearance.postprocess.spectra import spectra

    channels = listed(options.channels) or [principal(records[0]).format("a")]
    return spectra(records, output, channels=channels, **_chosen(options, "settle"))


def _contacts(options, records, output: Path) -> Path:
    from clearance.postprocess.contacts import contacts

    return contacts(records[0], output, joints=listed(options.joint), **_chosen(options, "settle"))


def _guide(options, records, output: Path) -> Path:
    from clearance.postprocess.guides import guides

    return guides(records[0], output, joints=listed(options.joint))


def _efforts(_options, records, output: Path) -> Path:
    from clearance.postprocess.efforts import efforts

    return efforts(records[0], output)


def _friction(options, records, output: Path) -> Path:
    from clearance.postprocess.efforts import friction

    return friction(records[0], output, joints=listed(options.joint))


def _pressure(options, records, output: Path) -> Path:
    from clearance.postprocess.pressures import pressures

    names = listed(options.joint) or [None]
    if len(names) > 1:
        raise ValueError(f"--joint {options.joint}: a picture of pressures has one joint")
    return pressures(records[0], output, joint=names[0])


def _sketch(options, records, output: Path) -> Path:
    from clearance.postprocess.drawing import sketch

    return sketch(records[0], output, at=options.turns or 0.0)


def _tornado(options, records, output: Path) -> Path:
    from clearance.postprocess.tornado import tornado

    return tornado(records[0], output, listed(options.metrics))


def _measured(options, records, output: Path) -> Path:
    from clearance.postprocess.measured import compare, overlay

    if not options.measured:
        raise ValueError("measured needs a record: --measured FILE.csv")
    chosen = _chosen(options, "channels", "column", "shift", "settle")
    compared = compare(records[0], options.measured, **chosen)
    if hasattr(options, "facts"):
        names = ("channel", "units", "shift", "rms", "largest", "share", "correlation")
        options.facts |= {n: getattr(compared, n) for n in names} | {"sentence": str(compared)}
    return overlay(records[0], output, compared)


def _animation(options, records, output: Path) -> Path:
    from clearance.postprocess.animation import animate
    from clearance.postprocess.drawing import period

    record, frames = records[0], options.frames
    if frames is None:
        time, shown = record.time, (options.turns or 1.0) * period(record)
        frames = max(min(FRAMES, int((time > time[-1] - shown * (1.0 - 1e-9)).sum())), 2)
    return animate(record, output, frames=frames, **_chosen(options, "turns", "magnify"))


DRAW = {
    "overview": _overview,
    "history": _history,
    "orbit": _orbit,
    "phase": _phase,
    "poincare": _poincare,
    "spectrum": _spectrum,
    "contacts": _contacts,
    "guide": _guide,
    "efforts": _efforts,
    "friction": _friction,
    "pressure": _pressure,
    "sketch": _sketch,
    "tornado": _tornado,
    "measured": _measured,
    "animation": _animation,
}


# --- pictures of lives
def is_life(path: Path) -> bool:
    """True for the directory of a life."""
    return (path / "life.json").is_file()


def _of_life(options, folder: Path, kind: str) -> Path:
    from clearance.postprocess import lives

    other = [n for n in OPTIONS if getattr(options, n) is not None and n not in OF_LIVES[kind]]
    if other:
        name = other[0].replace("_", "-")
        raise ValueError(f"--{name} does not belong to the {kind} of a life")
    shown = _chosen(options, "joint", "surface")
    if kind == "animation":
        output = _output(options, folder / "life.gif")
        return lives.animation(folder, output, **shown, **_chosen(options, "frames"))
    return lives.life(folder, _output(options, folder / "life.png"), **shown)


# --- pictures of sweeps
def _of_sweep(options, folder: Path, kind: str | None) -> Path:
    from clearance.postprocess import maps

    from clearance.sweeping.index import open_sweep

    if kind == "scatter" or kind is None and (folder / "scatter.json").exists():
        return _scatter(options, folder)
    sweep = open_sweep(folder)
    points = sweep.definition.points
    kind = kind or (
        "map" if not points.sampled and sum(count > 1 for _, count in points.axes) > 1 else "curves"
    )
    _check(options, kind)
    output = _output(options, folder / f"{kind}.png")
    at = _at(sweep, options.at or [])
    if kind == "bifurcation":
        more = _chosen(options, "settle", "angle")
        return maps.bifurcation_of(
            sweep, output, parameter=options.x, channels=listed(options.channels), at=at, **more
        )
    settled = _chosen(options, "only_settled")
    if kind == "curves":
        return maps.curves(
            sweep, output, metrics=listed(options.metrics), x=options.x, at=at, **settled
        )
    return maps.maps(
        sweep, output, metrics=listed(options.metrics), x=options.x, y=options.y, at=at, **settled
    )


def usual(folder: Path) -> Path:
    """The usual picture of a finished sweep, in its directory."""
    return _of_sweep(argparse.Namespace(**dict.fromkeys(OPTIONS), output=None), folder, None)


def _scatter(options, folder: Path) -> Path:
    from clearance.postprocess.scatter import scatter

    from clearance.sweeping.scatter import open_scatter

    _check(options, "scatter")
    output = _output(options, folder / "scatter.png")
    return scatter(open_scatter(folder), output, listed(options.metrics))


def _at(sweep, texts: list[str]) -> dict:
    """Values at which swept parameters are held, SI."""
    from clearance.values.units import quantity

    values = {}
    for item in texts:
        name, equals, text = item.partition("=")
        if not equals:
            raise ValueError(f"--at {item}: expected NAME=VALUE")
        if name not in sweep.columns:
            raise ValueError(
                f"--at {item}: {name} is not swept in {sweep.folder}; swept are "
                f"{', '.join(sweep.columns)}"
            )
        column = sweep.columns[name]
        try:
            if column.dtype.kind in "iuf":
                values[name] = quantity(text, sweep.definition.units.get(name))
            else:
                values[name] = next(
                    (v for v in column.tolist() if str(v).lower() == text.lower()), text
                )
        except ValueError as error:
            raise ValueError(f"--at {name}: {error}") from None
    return values
