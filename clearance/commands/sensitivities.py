"""Sensitivities in what `clearance run` prints: the option, plain data, lines."""

import math

from clearance.commands.accuracy import prefix
from clearance.values.spelling import taken

SHOWN = 8  # metrics in print


OPTIONS = {
    "--sensitivity NAMES": "differentiate the metrics by these parameters, such as "
    "clearance,viscosity or joints/B/clearance; of one that is 0 with the size that counts: load=1N"
}


def document(result) -> dict:
    """Sensitivities of a result by metric and parameter as plain data, the most telling first;
    the reason where there are none.
    """
    table = result.sensitivities
    if table.reason:
        return {"reason": table.reason}
    plain: dict = {metric: {} for metric in table.telling(result.clearances)}
    for (metric, parameter), s in table.items():
        numbers = taken(s, "value error units trusted change change_error")
        plain[metric][parameter] = numbers | {"change_units": s.metric_units}
    return plain


def lines(summary: dict) -> list[str]:
    """Changes of the first metrics where each parameter grows by 1 %, with their stated errors."""
    table = summary.get("sensitivities", {})
    if "reason" in table:
        return [f"  sensitivity  none: {table['reason']}"]
    if not table:
        return []
    names = list(dict.fromkeys(name for by_parameter in table.values() for name in by_parameter))
    rows = [(name, [_words(by.get(n)) for n in names]) for name, by in table.items()]
    head = ("sensitivity  change for 1 % more of", names)
    wide = [max(len(cells[i]) for _, cells in (head, *rows)) + 2 for i in range(len(names))]
    text = [
        f"  {name:<36}" + "".join(f"{c:>{w}}" for c, w in zip(cells, wide, strict=True))
        for name, cells in (head, *((f"  {name}", cells) for name, cells in rows[:SHOWN]))
    ]
    more = len(rows) - SHOWN
    return [*text, f"    and {more} more metrics: --json has them all"] if more > 0 else text


def _words(s: dict | None) -> str:
    """A change with at most four digits, its error, and a mark where it is not to be trusted."""
    change, error = (s["change"], s["change_error"]) if s else (0.0, 0.0)
    if not (change or error):
        return "0" if s else "-"
    units = s["change_units"]
    units, factor = ("", 1.0) if units in ("1", "?") else prefix(max(abs(change), error), units)
    number, error = change * factor, error * factor
    digits = 3 - (math.floor(math.log10(abs(number))) if number else 0)
    if error > 0.0:
        digits = min(digits, -math.floor(math.log10(error)))
    digits = max(digits, 0)
    unit = 10.0**-digits
    text = f"{number:+.{digits}f} +- {math.ceil(error / unit) * unit:.{digits}f} {units}".rstrip()
    return text if s["trusted"] else f"{text} ?"
