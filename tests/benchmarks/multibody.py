"""Exudyn beside `clearance work-precision`: `python tests/benchmarks/multibody.py CASE [OPTIONS]`.

The same command with the same options and all peers, and Exudyn among these (install the extras
`peers` and `oracles`). Its row of a table states the time of the cheapest step that is small
enough.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent.parent))

from clearance.paper_figures.peers import PEERS  # noqa: E402

from clearance.cli import main  # noqa: E402
from tests.oracles.exudyn import Exudyn  # noqa: E402

if __name__ == "__main__":
    PEERS["Exudyn generalized-alpha"] = ("exudyn", Exudyn)
    sys.exit(main(["work-precision", *sys.argv[1:], "--peers"]))
