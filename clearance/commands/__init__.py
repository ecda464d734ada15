"""Commands that need a file of their own: their options, and what they print."""
