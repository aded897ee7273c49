"""Manufactured solutions on the coarsest cells of every kind, at rest and driven."""

from itertools import product

from approved import described

from tactgen.geometry.device.steel_law import TEAM20, linear
from tactgen.validation.checks.cases import manufactured
from tactgen.validation.checks.cases.magnetics.manufactured_fields import cube_error, rings_error

CELLS = ("straight", "curved", "hexahedra")


def test_errors_on_the_coarsest_cells(approved):
    """Orders are measured on finer ones; here every kind has its error, of values and slopes."""
    found = {
        "bricks": {(degree, driven): manufactured.bricks_error(degree, 2, driven)
                   for degree, driven in product((1, 2, 3), (False, True))},
        "cells": {(kind, driven): manufactured.solid_error(kind, 2, driven)
                  for kind, driven in product(CELLS, (False, True))},
        "plate": {kind: manufactured.plate_error(kind, 2) for kind in CELLS},
        "rings": {(curve.name, order): rings_error(curve, order, 2)
                  for curve, order in product((linear(1000.0), TEAM20), (2, 4))},
        "cube": {(potential, kind): cube_error(potential, kind, 2)
                 for potential, kind in product(("A", "phi"), CELLS[:2])},
    }  # fmt: skip
    approved(described(found))
