"""Complete runs of every case against stored results."""
