"""One script a figure or table of the four sources, and of the evidence; the studies behind them.

`clearance figures` draws them.
"""
