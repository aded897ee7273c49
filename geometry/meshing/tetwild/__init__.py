"""Tetrahedra from CAD solids: fTetWild and what makes its output conform, faithful and well shaped."""
