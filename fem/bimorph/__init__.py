"""The piezoelectric solid: assembly, modes, ports."""
