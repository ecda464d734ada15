"""Kinds of contact spots, for elements and for the compiled time loop; names of thresholds."""

#: never beyond the wall; with a first touch; with neither
FILM, CONTACT, BLENDED = range(3)
#: parameters of a transition law that are film thickness ratios between its states
THRESHOLDS = ("dry", "mixed", "full")
#: name, signs along and across the guide of each corner
CORNERS = (("1", -1.0, -1.0), ("2", 1.0, -1.0), ("3", -1.0, 1.0), ("4", 1.0, 1.0))
#: meaning of the values of the output `mode`
MODES = ("free", "one corner", "two on one side", "two across", "three corners", "four corners")
