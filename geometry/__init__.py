"""Device geometry: parameters, materials, CAD solids and meshes.

Imports none of the other packages.  SI units throughout; the only place where
units are read is :mod:`geometry.units`.
"""
