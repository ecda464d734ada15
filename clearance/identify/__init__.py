"""Ball-joint friction: models, test-bench records and the estimation of their parameters."""
