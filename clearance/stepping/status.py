"""Status codes of steppers, and a sentence for each."""

RUNNING = 0  # the call's budget is spent or a buffer is full: call again
DONE = 1
STEP_TOO_SMALL = 2
NOT_FINITE = 3
FILM_LEFT = 4
TOO_MANY_STEPS = 5
LEDGER_BROKEN = 6
DEAD_CENTRE = 8  # a loop that can be opened came to its dead centre
CRAWLING = 9  # so many of its steps would be needed that it will not end
STIFF = 7  # an explicit method is held up by stability; an implicit one may go on

MESSAGES = {
    STEP_TOO_SMALL: (
        "the step size fell below what the clock resolves: a loop at its dead centre, a contact "
        "that is stuck, or "
        "equations too stiff or discontinuous here"
    ),
    NOT_FINITE: (
        "no trial step gives finite numbers: a loop cannot close beyond this position, or a law is "
        "not finite here"
    ),
    FILM_LEFT: "the journal reached the bearing wall and the joint has no contact law to carry it",
    LEDGER_BROKEN: ("the energy ledger does not close and the rows are not to be trusted"),
    TOO_MANY_STEPS: "the step limit is reached",
    CRAWLING: "the steps have become so short that the rest of the run needs more than 1e9 of them",
}
