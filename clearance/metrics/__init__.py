"""Numbers about a record: of its window, turn by turn, with intervals; estimates of what a run
leaves out.
"""
