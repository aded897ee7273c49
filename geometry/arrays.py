"""Names for the kinds of array that signatures speak of; shapes are said in docstrings."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.floating[Any]]
Complex: TypeAlias = NDArray[np.complexfloating[Any, Any]]
#: Real or complex, as a lossless or a lossy model has it.
Numbers: TypeAlias = NDArray[np.inexact[Any]]
Ints: TypeAlias = NDArray[np.integer[Any]]
Bools: TypeAlias = NDArray[np.bool_]
#: A SciPy sparse matrix; SciPy carries no type information.
Sparse: TypeAlias = Any
