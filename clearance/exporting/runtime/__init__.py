"""C that is the same for all scenes."""
