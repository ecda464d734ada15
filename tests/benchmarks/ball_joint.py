"""Models of ball-joint friction beside their source: `python tests/benchmarks/ball_joint.py [--update README.md]`.

Prints the tables of `clearance.identify.studies` on the synthetic bench; with the extra `learn` also of the lstm.
Times are of whatever machine runs this, in one process.
"""

import argparse
from pathlib import Path

from clearance.identify import studies

BEGIN, END = "<!-- ball-joint:begin -->", "<!-- ball-joint:end -->"


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--update", metavar="FILE", help=f"put the tables into FILE, between {BEGIN} and {END}")
    path = options.parse_args().update
    lines = studies.tables(studies.study(progress_of=print))
    print("\n".join(lines))
    if path:
        text = Path(path).read_text()
        if text.count(BEGIN) != 1 or text.count(END) != 1:
            raise SystemExit(f"{path} must have {BEGIN} and {END} once each")
        head, _, rest = text.partition(BEGIN)
        Path(path).write_text(f"{head}{BEGIN}\n\n" + "\n".join(lines) + f"\n\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
