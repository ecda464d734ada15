"""Kinds of contact spots, for elements and for the compiled time loop; names of thresholds."""

#: never beyond the wall; with a first touch; with neither
FILM, CONTACT, BLENDED = range(3)
#: parameters of a transition law that are film thickness ratios between its states
THRESHOLDS = ("dry", "mixed", "full")
