"""Array types named after their shapes; every one holds float64.

A trailing shape is what the name promises; functions that broadcast say so in their docstring.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
"""Any shape."""
Series: TypeAlias = NDArray[np.float64]
"""Shape (N,): one number per sample."""
Vector3: TypeAlias = NDArray[np.float64]
"""Shape (3,)."""
Vectors3: TypeAlias = NDArray[np.float64]
"""Shape (N, 3): one vector per sample."""
Matrix3: TypeAlias = NDArray[np.float64]
"""Shape (3, 3)."""
Matrices3: TypeAlias = NDArray[np.float64]
"""Shape (N, 3, 3)."""
Quaternion: TypeAlias = NDArray[np.float64]
"""Shape (4,), scalar first."""
Quaternions: TypeAlias = NDArray[np.float64]
"""Shape (N, 4), scalar first."""
Units: TypeAlias = NDArray[np.float64]
"""Shape (6,): one number per CMG unit."""
UnitSeries: TypeAlias = NDArray[np.float64]
"""Shape (N, 6): one number per sample and CMG unit."""
Axes: TypeAlias = NDArray[np.float64]
"""Shape (6, 3): one unit vector per CMG unit."""
Theta: TypeAlias = NDArray[np.float64]
"""Shape (6,): inertia parameters J11, J22, J33, J23, J13, J12, kg·m²."""
Covariance: TypeAlias = NDArray[np.float64]
"""Shape (6, 6): covariance of Theta, kg²·m⁴."""
Regressor: TypeAlias = NDArray[np.float64]
"""Shape (3N, 6): rows grouped by sample, axes x, y, z within a sample."""
Response: TypeAlias = NDArray[np.float64]
"""Shape (3N,): rows as in Regressor."""
Flags: TypeAlias = NDArray[np.bool_]
"""Boolean, any shape."""
Indices: TypeAlias = NDArray[np.intp]
"""Indices, shape (N,)."""
