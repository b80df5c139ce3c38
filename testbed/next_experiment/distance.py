"""Distance between two models' predictions after one of them is fitted to the other.

With d the whitened difference of the predictions and X the imitator's derivatives, the distance is
min over δ of |d - X δ|, in sigma. Of each flight XᵀX, Xᵀd and dᵀd say all, and those of several flights add up; a
flight's initial rate is its own and projected out before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from testbed.arrays import Array

_SCARCE = 1e-11
"""Share of the best-known direction's information below which a direction is not known: above the rounding of a product
of columns, 1e-16 of some 1e4 samples; a direction as little known would take a parameter 3e5 times as large."""


class Contrast(NamedTuple):
    """Normal equations of the fit of a false model to a true one, for F flights side by side.

    X are the whitened derivatives of the false model's prediction, d is the whitened difference of the predictions.

    Attributes:
        information: XᵀX, shape (F, C, C).
        slope: Xᵀd, shape (F, C).
        square: dᵀd, shape (F,).
    """

    information: Array
    slope: Array
    square: Array

    def with_(self, other: Contrast, times: int = 1) -> Contrast:
        """Return what both say together, the other so many times."""
        return Contrast(*(mine + times * its for mine, its in zip(self, other, strict=True)))

    @property
    def distance(self) -> Array:
        """Distance in sigma, shape (F,)."""
        scale = np.sqrt(np.maximum(np.einsum("fcc->fc", self.information), np.finfo(float).tiny))
        scaled = self.information / (scale[:, :, None] * scale[:, None, :])
        slope = self.slope / scale
        explained = np.vecdot(slope, np.matvec(np.linalg.pinv(scaled, rcond=_SCARCE, hermitian=True), slope))
        return np.asarray(np.sqrt(np.maximum(self.square - explained, 0.0)))


def free_of(own: Array, columns: Array) -> Array:
    """Return columns of flights less what each flight's own ones explain, shape (F, S, C).

    Args:
        own: derivatives by what is a flight's own, shape (F, S, K).
        columns: shape (F, S, C).
    """
    basis, _ = np.linalg.qr(own)
    return np.asarray(columns - basis @ (np.swapaxes(basis, -1, -2) @ columns))


def contrast(difference: Array, columns: Array, common: int) -> Contrast:
    """Return what whitened predictions say of two models' difference.

    Args:
        difference: of the predictions, shape (F, S).
        columns: the imitator's derivatives, shape (F, S, common + K), the last K the initial rates'.
        common: parameters that all flights share.
    """
    both = np.concatenate([columns[..., :common], difference[..., None]], axis=-1)
    free = free_of(columns[..., common:], both)
    gram = np.swapaxes(free, -1, -2) @ free
    return Contrast(information=gram[:, :-1, :-1], slope=gram[:, :-1, -1], square=gram[:, -1, -1])
