"""`clearance diff`: two runs side by side."""

from fnmatch import fnmatchcase
from itertools import zip_longest

from clearance.commands.common import existing, show
from clearance.files.texts import listed

OPTIONS = {
    "first A.h5": "a result file",
    "second B.h5": "another one",
    "--metrics LIST": 'only these: "joint_B_*" (default all)',
}


def _short(fact: object) -> str:
    """A fact in print: of texts of several lines their number."""
    text = str(fact)
    lines = len(text.splitlines())
    return f"text of {lines} lines" if lines > 1 else text if len(text) <= 80 else f"{text[:77]}..."


def _pair(first: object, second: object) -> str:
    """Both sides of a fact: of two texts, such as a law's source, the first line that differs."""
    texts = [str(fact).splitlines() for fact in (first, second)]
    if min(map(len, texts)) > 1:
        for number, pair in enumerate(zip_longest(*texts, fillvalue=""), 1):
            if pair[0] != pair[1]:
                return f"line {number}: {_short(pair[0].strip())} | {_short(pair[1].strip())}"
    return f"{_short(first)} | {_short(second)}"


def run(options) -> int:
    """Print what both runs do not share, then the numbers that both have."""
    from clearance.postprocess.tables import changed_facts, differences
    from clearance.results.result import open_result

    with open_result(existing(options.first)) as one, open_result(existing(options.second)) as two:
        facts, rows = list(changed_facts(one, two)), differences(one, two)
    if options.metrics:
        patterns = listed(options.metrics)
        rows = [r for r in rows if any(fnmatchcase(r.name, p) for p in patterns)]
    document = {
        "facts": [{"name": n, "first": a, "second": b} for n, a, b in facts],
        "metrics": [vars(r) | {"change": r.change, "beyond_errors": r.beyond} for r in rows],
    }
    lines = ["not shared:" if facts else "the runs share scene and options"]
    lines += [f"  {name}: {_pair(first, second)}" for name, first, second in facts]
    lines.append(f"{'number':<40} {'A':>13} {'B':>13} {'B - A':>12} {'share':>9} {'errors':>9}")
    for r in rows:
        share = f"{100.0 * r.relative:+8.3g}%" if r.first else "       -"
        errors = "" if r.errors is None else f"{r.errors:9.1e}"
        mark = "" if r.beyond else " within errors" if r.errors else " the same"
        lines.append(
            f"{r.name:<40} {r.first:13.6g} {r.second:13.6g} {r.change:12.4g} {share} {errors:>9}"
            f" {'' if r.units in ('-', '1') else r.units}{mark}"
        )
    return show(options, document, lines)
