"""Accuracy of numbers: companions, requested errors, sensitivities, horizon."""
