"""The code about itself: error against run time, extremes, costs of parts."""
