"""Stated errors in what commands print: options, numbers with their errors, the line that sums them
up.
"""

import math

from clearance.values.spelling import taken
from clearance.values.units import UNITS

#: units with prefixes, and the power of ten of each
PREFIXES = {-12: "p", -9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M"}
#: units that no prefix stands before
UNPREFIXED = ("rpm", "deg")
MOST_DIGITS = 9  # of a number with its error
NO_ERROR = 1e-12  # share of a number below which an error is rounding


ERROR = {
    "--error E": (
        "auto",
        "make the cheapest run with so small a relative error: 1e-3 or 0.1% of all numbers that it "
        "prints, or by name, such as joint_B_force_max=1e-4,trajectory=1e-5; of chaotic dry motion "
        "the error is half of the 95 % interval over the mean of a turn. auto: state the errors of "
        'a run at --rtol; "state": also where that costs a second run as long, of films solved '
        "online and of runs with checkpoints",
    ),
    "--no-error": {
        "dest": "error",
        "action": "store_const",
        "const": None,
        "help": "no stated errors: without the second run, at ten times the tolerance, that they "
        "come from",
    },
}


def tolerance(options, usual: float = 1e-6) -> float:
    """--rtol, else the usual one.

    Raises ValueError where --error chooses it, or stands beside --steady.
    """
    from clearance.results.errors import asks

    asked = asks(options.error)
    if asked and getattr(options, "steady", None) is not None:
        raise ValueError(
            f"--error {options.error} is for runs from a start; --steady has an error of its own"
        )
    if asked and options.rtol is not None:
        raise ValueError(f"--error {options.error} chooses the tolerance: leave out --rtol")
    return usual if options.rtol is None else options.rtol


def with_error(value: float, error: float | None, units: str, after: str = "") -> str:
    """A number with its error in the same units, to the last digit that the error leaves: "128.3252
    +- 0.0008 N".

    after: what stands between the numbers and the units.
    """
    if not error or not math.isfinite(error):
        return f"{value:.6g}{after} {units}"
    if error < NO_ERROR * abs(value):
        return f"{value:.{MOST_DIGITS}g}{after} {units} +- below {NO_ERROR:g} of it"
    error = rounded_up(error)
    decimals = -math.floor(math.log10(error))
    digits = math.floor(math.log10(abs(value))) + 1 if value else 1
    if decimals + digits > MOST_DIGITS:
        return f"{value:.{MOST_DIGITS}g}{after} {units} +- {prefixed(error, units)}"
    decimals = max(decimals, 0)
    return f"{value:.{decimals}f} +- {error:.{decimals}f}{after} {units}"


def rounded_up(error: float) -> float:
    """An error with one digit, not smaller than it is."""
    power = 10.0 ** math.floor(math.log10(error))
    return math.ceil(error / power * (1.0 - 1e-12)) * power


def prefixed(error: float, units: str) -> str:
    """An error with one digit and a prefix of its units: 20 uN for 2e-5 N, 3 pm for 3e-6 um."""
    units, factor = without_prefix(units)
    error = rounded_up(error * factor) if error > 0.0 else 0.0
    if error < 10.0 ** min(PREFIXES) or not units[:1].isalpha() or units in UNPREFIXED:
        return f"{error:.0e} {units}".rstrip()
    units, factor = prefix(error, units)
    return f"{error * factor:.3g} {units}"


def without_prefix(units: str) -> tuple[str, float]:
    """SI units of units with a prefix, and the factor to them: m and 1e-6 for um."""
    base, factor = UNITS.get(units, (units, 1.0))
    return (base, factor) if units in {f"{p}{base}" for p in PREFIXES.values()} else (units, 1.0)


def prefix(size: float, units: str) -> tuple[str, float]:
    """Units with a prefix that suits a size, and the factor to them."""
    power = 3 * math.floor(math.log10(size * (1.0 + 1e-12)) / 3) if size > 0.0 else 0
    power = min(max(power, min(PREFIXES)), max(PREFIXES))
    return f"{PREFIXES[power]}{units}", 10.0**-power


def document(errors) -> dict:
    """Stated errors as plain data."""
    if errors.reason:
        return {"reason": errors.reason}
    numbers = {name: taken(e, "value stated film units kind") for name, e in errors.items()}
    rtol, companion = errors.rtol
    document = {
        "rtol": rtol,
        "companion_rtol": companion,
        "numbers": numbers,
        "channels": dict(errors.channels),
    }
    return document | (
        {"asked": dict(errors.asked), "cannot": errors.cannot} if errors.asked else {}
    )


def error_line(summary: dict) -> str:
    """The largest of the stated errors that are printed, the trajectory's, and the runs that they
    come from.
    """
    errors = summary["errors"]
    if "reason" in errors:
        return f"  error        not stated: {errors['reason']}"
    asked = ", ".join(
        f"{e:g}" if n == "all" else f"{n} {e:g}" for n, e in errors.get("asked", {}).items()
    )
    parts = [f"{asked} asked, over the value"] if asked else []
    if shares := _shares(errors["numbers"]):
        worst = max(shares, key=shares.get)
        parts.append(f"at most {shares[worst]:.1e} of a number ({worst})")
    if "trajectory" in errors["numbers"]:
        measure = "the clearance" if summary["clearances"] else "their size"
        parts.append(f"trajectories {errors['numbers']['trajectory']['stated']:.1e} of {measure}")
    return (
        f"  error        {', '.join(parts)}; from runs at rtol {errors['rtol']:g} and "
        f"{errors['companion_rtol']:g}"
    )


def _shares(numbers: dict) -> dict[str, float]:
    """Relative errors of the numbers that a summary prints, by name; those of zeros left out."""
    from clearance.accuracy.request import printed
    from clearance.results.errors import Error

    errors = {name: Error(number["value"], number["stated"]) for name, number in numbers.items()}
    return {n: errors[n].relative for n in printed(errors) if errors[n].value}
