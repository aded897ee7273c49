"""Which points of a study are wanted: a small language of conditions and goals, and its answers."""
