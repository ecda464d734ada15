"""Pictures of a scatter: how metrics spread, and which parameters are to blame."""

from pathlib import Path

import numpy as np
from clearance.postprocess.figures import Sheet, save, sheet, with_units
from clearance.postprocess.labels import shown_in, with_unit
from clearance.postprocess.maps import chosen_metrics

MOST = 4  # metrics of a picture
BINS = 40
WIDTH, ROW = 9.0, 2.5  # of the sheet and of a row [inch]


def scatter(
    result, path: str | Path | None = None, metrics: list[str] | None = None
) -> Path | Sheet:
    """Histogram of each metric with its median, its 5 and 95 % quantiles and its limit; Sobol'
    indices beside it.

    result: a `Scatter`; metrics: names or patterns, default those with a limit, then the first
        others, four in all.
    Raises ValueError where no metric varies, and for unknown metrics.
    """
    chosen = result.metrics[:MOST] if metrics is None else chosen_metrics(result.sweep, metrics)
    if not chosen:
        raise ValueError("there is no metric that varies")
    figure = sheet(WIDTH, ROW * len(chosen))
    table = figure.subplots(len(chosen), 2, squeeze=False, width_ratios=(1.6, 1.0))
    for (histogram, right), metric in zip(table, chosen, strict=True):
        _histogram(histogram, result, metric)
        _bars(right, result, metric)
    table[-1][1].set_xlabel("Sobol' index: share of the variance [-]")
    return save(figure, path)


def _histogram(axes, result, metric: str) -> None:
    values, (units, text) = result.values(metric), result.sweep.known.get(metric, ("?", metric))
    units, factor = shown_in(units, values)
    axes.hist(factor * values, BINS, histtype="stepfilled", color="#90a4ae", density=True)
    for share, style in ((0.05, ":"), (0.5, "-"), (0.95, ":")):
        quantile = factor * result.quantile(metric, share).value
        axes.axvline(quantile, color="#263238", linestyle=style, linewidth=1.0)
    title = f"median and 5, 95 % of {len(values)} runs"
    if metric in result.limits:
        limit, share = factor * result.limits[metric], result.beyond(metric)
        low, high = axes.get_xlim()
        if low <= limit <= high:
            axes.axvline(limit, color="#c62828", linewidth=1.5)
        title += (
            f"; beyond {with_unit(limit, units)}: {100 * share.value:.3g} % ("
            f"{100 * share.low:.3g} to {100 * share.high:.3g} %)"
        )
    axes.set_title(title, fontsize="small", loc="left")
    axes.set_xlabel(with_units(text, units), fontsize="small")
    axes.locator_params(axis="x", nbins=5)
    axes.set_yticks([])
    axes.set_ylabel("density")


def _bars(axes, result, metric: str) -> None:
    """First and total indices with their intervals, the largest on top."""
    indices = result.indices(metric)
    if not indices:
        axes.text(
            0.5, 0.5, "too few runs for indices", ha="center", va="center", transform=axes.transAxes
        )
        axes.set_axis_off()
        return
    if any(i.doubtful for i in indices.values()):
        axes.set_title("first above total: too few points", fontsize="small", loc="left")
    names, reach = sorted(indices, key=lambda n: indices[n].total.value), 1.0
    for k, (part, color) in enumerate((("total", "#b0bec5"), ("first", "#1565c0"))):
        ends = [getattr(indices[n], part) for n in names]
        height = np.arange(len(names)) + 0.2 * (1 - 2 * k)
        value = np.array([e.value for e in ends])
        error = np.clip(
            [[e.value - e.low for e in ends], [e.high - e.value for e in ends]], 0.0, None
        )
        reach = max(reach, *value, *(e.high for e in ends))
        axes.barh(
            height, value, 0.38, xerr=error, color=color, error_kw={"linewidth": 0.8}, label=part
        )
    axes.set_yticks(np.arange(len(names)), names)
    axes.set_xlim(0.0, 1.05 * reach)
    axes.legend(fontsize="small", frameon=False, loc="lower right")
