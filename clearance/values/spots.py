"""Kinds of contact spots, for elements and for the compiled time loop."""

#: never beyond the wall; with a first touch; with neither
FILM, CONTACT, BLENDED = range(3)
