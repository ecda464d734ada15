"""`clearance cases`: the cases there are, with their parameters."""

from clearance.commands.common import quiet, show

OPTIONS = {"cases CASE *": "name of a case, or path to your own case file (default all cases)"}


def run(options) -> int:
    """List them."""
    from clearance.scene.catalogue import case_names, find_case

    with quiet(options):
        cases = [find_case(name) for name in options.cases or case_names()]
    rows, lines = {}, []
    for case in cases:
        rows[case.name] = {"summary": case.summary, "parameters": {}}
        lines.append(f"{case.name}: {case.summary}")
        for p in case.parameters.values():
            about = {"default": p.default, "units": p.units, "text": p.text}
            rows[case.name]["parameters"][p.name] = about
            default = f"{p.default:g}" if isinstance(p.default, float) else str(p.default)
            lines.append(f"    {p.name:<20} {default:>18} {p.units:<9} {p.text}")
        lines.append("")
    return show(options, rows, lines)
