"""Models of ball-joint friction beside their source: `python tests/benchmarks/ball_joint.py
[--update]`.

Prints the tables of `clearance.paper_figures.ball_joint_studies` on the synthetic bench; with the
extra `learn` also of the lstm. Times are of whatever machine runs this, in one process.
"""

from clearance.paper_figures import ball_joint_studies as studies
from publishing import publish

BEGIN, END = "<!-- ball-joint:begin -->", "<!-- ball-joint:end -->"


def tables():
    return studies.tables(studies.study(progress_of=print))


if __name__ == "__main__":
    publish(__doc__, tables, BEGIN, END)
