"""Points of grids and lists of starts: measured, judged, their attractors counted, shared out and bounded."""
