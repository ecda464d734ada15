"""The compiled time loop: steps, events, extremes, integrals, steppers."""
