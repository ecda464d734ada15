"""`clearance cases`: the cases there are, with their parameters."""

import argparse

from clearance.commands.common import DONE, add_command, json_text, quiet


def add(commands) -> argparse.ArgumentParser:
    """The command and its options."""
    p = add_command(commands, "cases")
    p.add_argument(
        "cases",
        metavar="CASE",
        nargs="*",
        help="name of a case, or path to your own case file (default all cases)",
    )
    return p


def run(options) -> int:
    """List them."""
    from clearance.scene.catalogue import case_names, find_case

    with quiet(options):
        cases = [find_case(name) for name in options.cases or case_names()]
    if options.json:
        rows = {
            c.name: {
                "summary": c.summary,
                "parameters": {
                    p.name: {"default": p.default, "units": p.units, "text": p.text}
                    for p in c.parameters.values()
                },
            }
            for c in cases
        }
        print(json_text(rows, indent=1))
        return DONE
    for case in cases:
        print(f"{case.name}: {case.summary}")
        for p in case.parameters.values():
            default = f"{p.default:g}" if isinstance(p.default, float) else str(p.default)
            print(f"    {p.name:<20} {default:>18} {p.units:<9} {p.text}")
        print()
    return DONE
