"""Cells of a notebook: tables and pictures of scenes, runs, motions, sweeps, lives and fits."""

import itertools
from collections.abc import Iterator
from functools import partial, singledispatch
from pathlib import Path

import numpy as np
from clearance.postprocess import optima, report, scene_fits, scenes, sweep_report, view
from clearance.postprocess.branches import branches
from clearance.postprocess.drawing import sketch
from clearance.postprocess.lives import life
from clearance.postprocess.pages import (
    Markup,
    Page,
    element,
    join,
    missing,
    number,
    quantity,
    table,
)

from clearance.identify.designs import Optimum
from clearance.identify.scene_parameters import SceneFit
from clearance.results.errors import Errors
from clearance.results.result import Result
from clearance.sweeping.index import Sweep
from clearance.values.accessors import accessor
from clearance.wearing.life_record import Life

#: characters of a moving page from which on a cell names the call that writes it
LARGEST = 6_000_000
STYLE = """
.clearance h1{font-size:1.15em;margin:.2em 0}.clearance figure{margin:.5em 0}
.clearance .wide{max-height:24em;overflow:auto}.clearance svg{max-width:100%;height:auto}
.clearance .box{border-left:5px solid;padding:.2em .7em;margin:.4em 0;color:#1a1a1a}
.clearance .bad{border-color:#c0392b;background:#fdeeec}
.clearance .doubt{border-color:#e0a800;background:#fff8e1}
.clearance .good{border-color:#2e7d4f;background:#edf7f0}
.clearance iframe{width:100%;height:620px;border:1px solid #ccc;background:#fff}
"""
#: pictures of all cells of a session, whose ids must differ
_drawn = itertools.count(1)


def cell(thing) -> str:
    """HTML of a thing in a notebook; what cannot be drawn is a sentence there."""
    page = Page("")
    page.pictures = 1000 * next(_drawn)
    style = Markup(f"<style>{STYLE}</style>")
    return element("div", style, join(_parts(thing, page)), class_="clearance")


@singledispatch
def _parts(thing, page: Page) -> Iterator[Markup]:
    """Pieces of a cell, by the class of the thing; this is that of a scene and of motions."""
    if of_motion := OF_MOTIONS.get(type(thing).__name__):
        yield from of_motion(thing, page)
        return
    scene = thing.description()
    yield element("h1", thing.name)
    yield scenes.described(scene)
    yield page.picture(partial(_sketched, thing), "The mechanism with ideal joints, to scale")
    yield scenes.tables(scene)


def _sketched(scene, path: Path) -> None:
    """Draw a scene, and paths of its points over a turn where one turns."""
    sketch(accessor("ideal_turn")(scene), path, trails=bool(scene.turn))


@_parts.register
def _(thing: Result, page: Page):
    yield report.head(thing)
    yield from report.summed(thing, None)
    yield _moving(thing)


def _moving(run: Result) -> Markup:
    """The moving page of a run, in a frame."""
    try:
        text = view.page_text([run])
    except (KeyError, ValueError) as error:
        return missing(f"No moving page: {error.args[0]}.")
    if len(text) > LARGEST:
        size = f"{len(text) / 1e6:.0f} MB"
        return missing(f"The moving page has {size}: run.view('run.html') writes it to a file.")
    return element("iframe", srcdoc=text, sandbox="allow-scripts", title="moving page")


@_parts.register
def _(thing: Errors, page: Page):
    yield element("p", repr(thing).strip("<>"))
    heads = ("name", "value", "stated error", "by the film table", "relative")
    rows = []
    for name, row in thing.items():
        errors = (quantity(e, row.units) if e else "" for e in (row.stated, row.film))
        rows.append((name, quantity(row.value, row.units), *errors, number(row.relative, 2)))
    yield table(heads, rows) if rows else ""


def _steady(thing, page: Page):
    turns = f"{thing.period} turn{'s' * (thing.period > 1)}"
    yield element("h1", f"periodic after {turns}, {quantity(thing.duration, 's')}")
    rows = zip(thing.multipliers, np.abs(thing.multipliers), thing.errors, strict=True)
    cells = [(f"{m:.4g}", number(s), number(e, 2)) for m, s, e in rows]
    yield table(("multiplier", "size", "error"), cells)
    yield from _parts(thing.orbit, page)


def _branch(thing, page: Page):
    yield element("h1", f"{thing.case}: a periodic motion over {thing.parameter}; {thing.reason}")
    yield page.picture(partial(branches, thing.columns()), "Where turns begin; largest multiplier")
    rows = [(p.kind, quantity(p.value, thing.units), number(p.largest)) for p in thing.bifurcations]
    yield table(("bifurcation", thing.parameter, "largest multiplier"), rows) if rows else ""


def _statistics(thing, page: Page):
    yield element("h1", thing.verdict)
    yield element("pre", "\n".join(thing.lines()))


#: pieces of motions, by the name of their class: pictures import no solver
OF_MOTIONS = {"Steady": _steady, "Branch": _branch, "Statistics": _statistics}


@_parts.register
def _(thing: Sweep, page: Page):
    yield sweep_report.head(thing)
    yield from sweep_report.pictures(page, thing)[:1]
    yield from sweep_report.extremes(thing) if thing.done.any() else ()


@_parts.register
def _(thing: Life, page: Page):
    yield element("h1", repr(thing))
    if rows := thing.table():
        yield table([*rows[0]], [[number(v) for v in row.values()] for row in rows])
        yield page.picture(partial(life, thing), "Outlines, depths and forces over the life")


@_parts.register
def _(thing: SceneFit, page: Page):
    yield from _sections(scene_fits.page_of(thing, page), "Parameters", "Record and fit")


@_parts.register
def _(thing: Optimum, page: Page):
    yield from _sections(optima.page_of(thing), "Parameters", "Metrics", "Limits")


def _sections(page: Page, *titles: str) -> Iterator[Markup]:
    """Head and some sections of a page."""
    yield page.head
    yield from (content for title, content, _ in page.sections if title in titles)
