"""One script a figure or table of the four sources, and of the evidence; `clearance figures` runs
them.
"""
