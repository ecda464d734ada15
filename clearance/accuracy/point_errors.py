"""Stated errors of the points of a sweep: a metric <metric>_error for each metric, of integration
and film table.
"""

from clearance.accuracy.companion import (
    CompanionFailed,
    Start,
    paired,
    reason_without,
    size_of,
    stated,
)
from clearance.accuracy.request import Request, ToleranceSearch
from clearance.metrics.metrics import Metric, Metrics
from clearance.results.errors import Errors, asks
from clearance.results.recorder import MemoryRecord
from clearance.run.recording import record_run
from clearance.run.run import Run


class Stating:
    """Errors of one point: those that its run has, or a run with the requested ones.

    error: of `simulate`; settle: turns left out of the metrics.
    """

    def __init__(self, run: Run, error: float | str | dict | None, settle: float | None):
        self.run, self.settle = run, settle
        self.request = Request.of(error) if asks(error) else None
        stating = error is not None and self.request is None
        self.left_out = reason_without(run, error) if stating else ""
        self.start = Start.of(run) if stating and not self.left_out else None
        self.errors: Errors | None = None

    def run_into(self, keeper, summed) -> str | None:
        """Make the run, whose output goes to a keeper; why it failed, None where it did not.

        summed: metrics of a record.
        """
        if self.request is None:
            return record_run(self.run, keeper)
        answer = ToleranceSearch(self.run, self.request, self.settle, summed).climb()
        self.errors, keeper.run = answer.errors, answer.attempt.run
        answer.attempt.memory.replay(keeper)
        return answer.cannot or None

    def columns(self, record: MemoryRecord, values: Metrics, summed) -> Metrics:
        """Errors of the metrics of a run that has come to its end; none where they cannot be
        stated.
        """
        if self.start is not None and record.complete:
            try:
                pair = paired(self.run, self.start, record)
                self.errors = stated(pair, summed, self.settle, size_of(self.run.mechanism))
            except CompanionFailed as reason:
                self.left_out = str(reason)
        errors = self.errors or {}
        return {
            f"{n}_error": Metric(errors[n].total, m.units, f"stated error: {m.text}")
            for n, m in values.items()
            if n in errors and not is_period(n)
        }


def is_period(metric: str) -> bool:
    """True for metrics about periods, which get no stated error."""
    return metric.startswith("period")
