"""What a stepper may answer, and the sentence for each answer."""

RUNNING = 0  # the call's budget is spent or a buffer is full: call again
DONE = 1
STEP_TOO_SMALL = 2
NOT_FINITE = 3
FILM_LEFT = 4
TOO_MANY_STEPS = 5

MESSAGES = {
    STEP_TOO_SMALL: (
        "the step size fell below what the clock resolves: a loop at its dead centre, or equations too stiff or "
        "discontinuous here"
    ),
    NOT_FINITE: "the equations gave no finite number at any trial step: a loop cannot close here or a force overflows",
    FILM_LEFT: "the journal reached the bearing wall and the joint has no contact law to carry it",
    TOO_MANY_STEPS: "the step limit is reached",
}
