"""Conforming tetrahedra from CAD solids by fTetWild."""
