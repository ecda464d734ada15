"""Many runs of one structure side by side in vector registers: a lane each, with its own time and step."""
