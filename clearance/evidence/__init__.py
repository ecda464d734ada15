"""Evidence about the package itself: what a scene compiled to and what was left out."""
