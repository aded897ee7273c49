"""Piezoelectric solid on a mesh: weak form, elements, modes, reduction to ports."""
