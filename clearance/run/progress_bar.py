"""A bar of what is done, in a terminal or a notebook, for studies that are called from Python."""

import importlib.util
import sys
import time
from collections.abc import Callable
from functools import wraps
from typing import TypeVar

Study = TypeVar("Study", bound=Callable)
DELAY = 1.0  # seconds before a bar is shown
FORM = "{l_bar}{bar}| {elapsed} passed, {remaining} left {postfix}"

#: what the process does: "command" shows no bar unless one is requested, "study" is inside another
_state: dict[str, bool] = {"command": False, "study": False}


def by_command() -> None:
    """Show bars only where they are requested: commands have lines of their own."""
    _state["command"] = True


def seen() -> bool:
    """True where a person may look: in a notebook, or at a terminal of the first process."""
    processes = sys.modules.get("multiprocessing")
    if processes is not None and processes.parent_process() is not None:
        return False
    return "ipykernel" in sys.modules or sys.stderr is not None and sys.stderr.isatty()


class ProgressBar:
    """A bar of the share that is done, or of words, once a study takes longer than a second."""

    def __init__(self, name: str):
        self.name, self.began, self.bar = name, time.perf_counter(), None

    def __call__(self, state, words: str = "") -> None:
        """state: done share, a sentence, or numbers of points as `sweep` reports them."""
        if time.perf_counter() - self.began < DELAY:
            return
        if isinstance(state, str):
            state, words = 0.0, state
        elif hasattr(state, "total"):
            words = f"{state.done} of {state.total} done, {state.failed} failed"
            state = (state.done + state.failed) / state.total
        bar = self.bar = self.bar or self._new()
        bar.set_postfix_str(words, refresh=False)
        bar.update(100.0 * state - bar.n)

    def _new(self):
        if "ipykernel" in sys.modules and importlib.util.find_spec("ipywidgets"):
            from tqdm.auto import tqdm
        else:
            from tqdm import tqdm
        bar = tqdm(total=100, unit="%", desc=self.name, bar_format=FORM, leave=False)
        bar.start_t -= time.perf_counter() - self.began
        return bar

    def close(self) -> None:
        """Take the bar away."""
        if self.bar is not None:
            self.bar.close()


def watched(study: Study) -> Study:
    """Decorate a function with an argument `progress`: a bar stands for None where one is seen, for
    True also in commands. False and studies inside a study have none.
    """

    @wraps(study)
    def shown(*arguments, progress=None, **options):
        wanted = progress is True or progress is None and not _state["command"]
        bar = ProgressBar(study.__name__) if wanted and seen() and not _state["study"] else None
        before, _state["study"] = _state["study"], True
        try:
            report = bar if progress is None or isinstance(progress, bool) else progress
            return study(*arguments, progress=report, **options)
        finally:
            _state["study"] = before
            if bar is not None:
                bar.close()

    return shown  # type: ignore[return-value]
