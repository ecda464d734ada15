"""Status codes: of a run with a sentence for each, of a trial step, of a look for contacts."""

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

# of a trial step
MADE = 0  # its error may still be too large
TOO_LONG = 1  # its error is too large, or its equations could not be solved
NO_NUMBERS = 2  # it gives no finite numbers
OUT_OF_FILM = 3  # it takes a journal out of its film

# of a look for the start or end of a contact inside a step
NO_EVENT = 0
CUT = 1  # the step was made again, and ends on it
AT_START = 2  # it is where the step begins
MISSED = 3  # the step that should end on it failed

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
