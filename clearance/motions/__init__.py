"""Other ways to a motion: prescribed, periodic, chaotic."""
