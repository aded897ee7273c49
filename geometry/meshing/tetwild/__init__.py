"""Tetrahedra from CAD solids: fTetWild, and what makes its output conform to them."""
