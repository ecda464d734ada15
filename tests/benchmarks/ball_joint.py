"""Models of ball-joint friction beside their source: `python tests/benchmarks/ball_joint.py
[--update]`.

Prints the tables of `clearance.identify.studies` on the synthetic bench; with the extra `learn`
also of the lstm. Times are of whatever machine runs this, in one process.
"""

from publishing import publish

from clearance.identify import studies

BEGIN, END = "<!-- ball-joint:begin -->", "<!-- ball-joint:end -->"


def tables():
    return studies.tables(studies.study(progress_of=print))


if __name__ == "__main__":
    publish(__doc__, tables, BEGIN, END)
