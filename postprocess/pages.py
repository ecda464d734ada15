"""Pieces of an HTML page that needs nothing else: numbers with units, tables, pictures in the page,
its frame.

Every text is escaped on its way in; only `Markup`, made here, goes in as it is.
"""

import base64
import html
import math
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from clearance.postprocess.figures import SUPERSCRIPTS
from clearance.postprocess.labels import NO_BREAK, SHOWN_IN, shown_in
from clearance.postprocess.policy import policy

from clearance.files.locks import replacing
from clearance.results.reading import Damaged

DASH, MINUS = "\u2013", "\u2212"
#: significant digits of a number
DIGITS = 5
#: units in which numbers of tables read well, as in pictures and beyond: (from which largest value
#: on, unit, factor)
SHOWN = SHOWN_IN | {
    "m": (*SHOWN_IN["m"][:2], (1e-7, "µm", 1e6), (0.0, "nm", 1e9)),
    "s": ((1.0, "s", 1.0), (1e-3, "ms", 1e3), (1e-6, "µs", 1e6), (0.0, "ns", 1e9)),
    "Pa": ((1e9, "GPa", 1e-9), *SHOWN_IN["Pa"]),
    "kg": ((0.1, "kg", 1.0), (0.0, "g", 1e3)),
    "kg m2": ((0.01, "kg m²", 1.0), (0.0, "kg mm²", 1e6)),
    "N m": ((0.1, "N m", 1.0), (0.0, "mN m", 1e3)),
    "m/s": ((0.1, "m/s", 1.0), (0.0, "mm/s", 1e3)),
}
ALIKE = {
    "m/s2": "m/s²",
    "kg/m3": "kg/m³",
    "m3/s": "m³/s",
    "rad/s2": "rad/s²",
    "J/(m3 K)": "J/(m³ K)",
    "1": "",
    "-": "",
    "?": "",
}
#: bytes of an SVG picture that is not worth being drawn as PNG too, which has some 100,000, and
#: samples from which on no SVG is tried
SMALL, LONG = 250_000, 20_000

STYLE = """
body{font:15px/1.45 system-ui,sans-serif;color:#1a1a1a;background:#fff;
max-width:64rem;margin:0 auto;padding:1rem}
h1{font-size:1.7rem;margin:0 0 .3rem}
h2{font-size:1.3rem;margin:2rem 0 .6rem;border-bottom:1px solid #bbb}
h3{font-size:1.05rem;margin:1.3rem 0 .4rem}p{margin:.5rem 0}nav{font-size:.9rem}
nav a{margin-right:1em}
table{border-collapse:collapse;margin:.5rem 0;font-size:.86rem;font-variant-numeric:tabular-nums}
caption{text-align:left;color:#444;padding:.2rem 0}
th,td{border:1px solid #ccc;padding:.2rem .5rem;text-align:left;vertical-align:top}
thead th{background:#eef1f4}td.number{text-align:right;white-space:nowrap}
th[data-sorted]::after{content:" \\25B2"}th[data-sorted=down]::after{content:" \\25BC"}
table.sortable thead th{cursor:pointer}.wide{overflow-x:auto}figure{margin:.8rem 0}
figcaption{font-size:.86rem;color:#444}
figure svg,figure img{max-width:100%;height:auto}svg *{stroke-linejoin:round;stroke-linecap:butt}
.pair{display:flex;flex-wrap:wrap;gap:0 1.5rem;align-items:flex-start}
.pair figure{flex:0 1 26rem;min-width:17rem}
.box{border-left:5px solid;padding:.4rem .8rem;margin:.8rem 0}
.box ul{margin:.2rem 0;padding-left:1.2rem}
.bad{border-color:#c0392b;background:#fdeeec}.doubt{border-color:#e0a800;background:#fff8e1}
.good{border-color:#2e7d4f;background:#edf7f0}.missing{color:#555;font-style:italic}
pre{background:#f4f4f4;padding:.6rem;overflow-x:auto}code{overflow-wrap:anywhere}
@media print{body{font-size:10pt;max-width:none;padding:0}nav{display:none}a{color:inherit}
.wide{overflow:visible}table{font-size:8pt}table.sortable{font-size:6.5pt}
table.sortable th,table.sortable td{padding:1pt 2pt}
h2,h3,caption{break-after:avoid}figure,tr,.box,pre{break-inside:avoid}
figure svg,figure img{max-height:225mm}
section.page{break-before:page}}@page{margin:15mm}
"""
#: clicks on a head cell sort its table; without scripts tables stay as they are
SCRIPT = """
for(const head of document.querySelectorAll("table.sortable thead th"))
head.addEventListener("click",()=>{
const table=head.closest("table"),body=table.tBodies[0],
down=head.dataset.sorted==="up",i=head.cellIndex;
const key=row=>{const c=row.cells[i];
return c.dataset.value===undefined?c.textContent:+c.dataset.value};
const order=(x,y)=>typeof x==="number"&&typeof y==="number"?(isNaN(x)?1:isNaN(y)?-1:x-y):
String(x).localeCompare(String(y));
const rows=[...body.rows].sort((a,b)=>order(key(a),key(b))*(down?-1:1));
for(const other of table.querySelectorAll("th"))delete other.dataset.sorted;
head.dataset.sorted=down?"down":"up";body.append(...rows)});
"""


class Markup(str):
    """HTML that goes into a page as it is."""


class Cell(Markup):
    """A complete table cell."""


def markup(value: object) -> Markup:
    """A value as HTML: texts escaped, numbers to 5 digits, None and NaN as a dash."""
    if isinstance(value, Markup):
        return value
    if value is None:
        return Markup(DASH)
    if isinstance(value, bool | np.bool_):
        return Markup("yes" if value else "no")
    if isinstance(value, int | float | np.integer | np.floating):
        return Markup(number(value))
    return Markup(html.escape(str(value)))


def element(tag: str, *content: object, **attributes: object) -> Markup:
    """An element with its content, both escaped; `class_` is the attribute class, `data_value` is
    data-value.
    """
    text = "".join(
        f' {name.rstrip("_").replace("_", "-")}="{html.escape(str(value))}"'
        for name, value in attributes.items()
    )
    return Markup(f"<{tag}{text}>{''.join(map(markup, content))}</{tag}>")


def join(parts: Iterable[object], between: str = "") -> Markup:
    return Markup(between.join(map(markup, parts)))


def number(value: float, digits: int = DIGITS) -> str:
    """A number in print: "0.00012345", "1.2 × 10⁻⁷"; integers entire, a dash for NaN."""
    if isinstance(value, int | np.integer):
        return str(value).replace("-", MINUS)
    if math.isnan(value):
        return DASH
    if value == 0.0:
        return "0"
    if math.isinf(value):
        return "∞" if value > 0.0 else f"{MINUS}∞"
    text, _, power = f"{value:.{digits}g}".partition("e")
    if abs(value) >= 10.0**digits and abs(value) < 1e6:
        text, power = f"{value:.0f}", ""
    text = text.replace("-", MINUS)
    return (
        f"{text} × 10{str(int(power)).translate(SUPERSCRIPTS)}".replace(" ", NO_BREAK)
        if power
        else text
    )


def scaled(units: str, *values: float) -> tuple[str, float]:
    """Unit in which values in SI units are shown, one that suits the largest of them, and the
    factor to it.
    """
    if units not in SHOWN:
        return ALIKE.get(units, units), 1.0
    if not any(v and math.isfinite(v) for v in values):
        return next(
            ((unit, factor) for _, unit, factor in SHOWN[units] if factor == 1.0),
            SHOWN[units][0][1:],
        )
    return shown_in(units, values, SHOWN)


def measured(value: float, units: str) -> tuple[str, str]:
    """A number and units of a size that suits it: 1e-5 m is "10" and "µm"."""
    unit, factor = scaled(units, value)
    return number(value * factor if factor != 1.0 else value), unit.replace(" ", NO_BREAK)


def quantity(value: float, units: str) -> str:
    """A number with its units, as `measured`: "10 µm"."""
    shown, unit = measured(value, units)
    return shown + (unit if unit in ("", "°") else NO_BREAK + unit)


# --- pieces of a page


def cell(value: object) -> Cell:
    """A table cell; numbers on the right."""
    if isinstance(value, Cell):
        return value
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        return valued(value, number(value))
    return Cell(element("td", value))


def valued(value: float, shown: str) -> Cell:
    """A table cell with a number as it is shown, and its value to sort by."""
    return Cell(element("td", shown, class_="number", data_value=f"{value:.9g}"))


def table(
    head: Sequence[object],
    rows: Iterable[Sequence[object]],
    *,
    says: str = "",
    sortable: bool = False,
) -> Markup:
    """A table with a head row; `says` is its caption.

    A sortable one is sorted by clicks on its head.
    """
    caption = element("caption", says) if says else ""
    top = element("thead", element("tr", *(element("th", h, scope="col") for h in head)))
    body = element("tbody", *(element("tr", *map(cell, row)) for row in rows))
    grid = element("table", caption, top, body, **({"class_": "sortable"} if sortable else {}))
    return element("div", grid, class_="wide")


def facts(rows: Iterable[tuple[object, object]]) -> Markup:
    """A table of names and values, without a head."""
    lines = (
        element("tr", element("th", name, scope="row"), element("td", value))
        for name, value in rows
    )
    return element("div", element("table", element("tbody", *lines)), class_="wide")


def breakable(name: str) -> Markup:
    """A name that lines may break in after its underscores and slashes."""
    return Markup(re.sub("([_/])", r"\1<wbr>", html.escape(name)))


def date(created: str) -> str:
    """A time of provenance in print."""
    return created.replace("T", " ").replace("+00:00", " UTC")


def points(items: Iterable[object]) -> Markup:
    return element("ul", *(element("li", item) for item in items))


def box(kind: str, *content: object) -> Markup:
    """Something that must be seen; kind: "bad", `"doubt"` or "good"."""
    return element("div", *content, class_=f"box {kind}")


def missing(text: str) -> Markup:
    """A sentence in place of what cannot be shown."""
    return element("p", text, class_="missing")


class Page:
    """A page in the making: its title, sections in order, and pictures that have numbers."""

    def __init__(self, title: str):
        self.title, self.head, self.sections, self.pictures = title, Markup(""), [], 0

    def section(self, title: str, *content: object, apart: bool = False) -> None:
        """Add a section; `apart`: it begins on a new sheet of paper."""
        self.sections.append((title, join(content), apart))

    def picture(self, draw: Callable[[Path], object], words: str, samples: int = 0) -> Markup:
        """A picture in the page, as SVG, or of large ones as PNG if that is smaller; a sentence
        where it cannot be drawn.

        draw: saves it under the path it is given, or raises ValueError stating why it cannot;
            stated:
            what it shows;
        samples: length of the record, for long ones are not tried as SVG.
        """
        try:
            with TemporaryDirectory(prefix="clearance-") as folder:
                shown = self._smaller(draw, Path(folder), words, samples)
        except Damaged:
            raise
        except ValueError as error:
            return missing(f"{words}: not shown, for {error}.")
        return element("figure", shown, element("figcaption", words))

    def _smaller(
        self, draw: Callable[[Path], object], folder: Path, words: str, samples: int
    ) -> Markup:
        self.pictures += 1
        vector = None
        if samples < LONG:
            draw(folder / "picture.svg")
            text = (folder / "picture.svg").read_text(encoding="utf-8")
            vector = inline(text, f"p{self.pictures}", words)
            if len(vector) <= SMALL:
                return vector
        draw(folder / "picture.png")
        data = base64.b64encode((folder / "picture.png").read_bytes()).decode()
        image = Markup(f'<img alt="{html.escape(words)}" src="data:image/png;base64,{data}">')
        return vector if vector is not None and len(vector) <= len(image) else image

    def html(self) -> str:
        """The entire document."""
        names = [f"s{i}" for i in range(1, len(self.sections) + 1)]
        links = (
            element("a", title, href=f"#{n}")
            for n, (title, *_) in zip(names, self.sections, strict=True)
        )
        sections = (
            element(
                "section",
                element("h2", title),
                content,
                id=name,
                **({"class_": "page"} if apart else {}),
            )
            for name, (title, content, apart) in zip(names, self.sections, strict=True)
        )
        body = element(
            "body",
            self.head,
            element("nav", join(links, " ")),
            *sections,
            Markup(f"<script>{SCRIPT}</script>"),
        )
        # pictures have styles in their elements, and such of points stand in the page as data
        rules = policy(SCRIPT, STYLE, img_src="data:", style_src_attr="'unsafe-inline'")
        meta = (
            f'<meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{rules}">'
            '<meta name="viewport" content="width=device-width,initial-scale=1">'
        )
        head = element(
            "head", Markup(meta), element("title", self.title), Markup(f"<style>{STYLE}</style>")
        )
        return f"<!DOCTYPE html>\n{element('html', head, body, lang='en')}\n"

    def save(self, path: Path) -> Path:
        """Write the document, under a temporary name until it is complete."""
        with replacing(path) as temporary:
            temporary.write_text(self.html(), encoding="utf-8")
        return path


def inline(svg: str, name: str, words: str) -> Markup:
    """An SVG file as an element of a page: without prolog, styles and comments, its ids made the
    page's own.

    name: what its ids begin with; stated: its alternative text. Ids that nothing refers to are left
        out.
    """
    body = re.sub(
        r"<!--.*?-->|<metadata>.*?</metadata>|<style.*?</style>",
        "",
        svg[svg.index("<svg") :],
        flags=re.S,
    )
    opening, body = re.match(r"<svg([^>]*)>(.*)", body, flags=re.S).groups()
    size = dict(re.findall(r'(width|height|viewBox)="([^"]*)"', opening))
    body = body.replace("xlink:href", "href")
    used = dict.fromkeys(re.findall(r'url\(#([^)"]+)\)|href="#([^"]+)"', body))
    ids = {next(filter(None, pair)): "" for pair in used}
    ids = {old: f"{name}-{i}" for i, old in enumerate(ids)}
    body = re.sub(r' id="([^"]*)"', lambda m: f' id="{ids[m[1]]}"' if m[1] in ids else "", body)
    body = re.sub(r"url\(#([^)]+)\)", lambda m: f"url(#{ids[m[1]]})", body)
    body = re.sub(r'href="#([^"]+)"', lambda m: f'href="#{ids[m[1]]}"', body)
    body = re.sub(r"\s*\n\s*", "\n", body)
    sizes = "".join(f' {n}="{html.escape(v)}"' for n, v in size.items())
    return Markup(f'<svg role="img" aria-label="{html.escape(words)}"{sizes}>{body.strip()}')
