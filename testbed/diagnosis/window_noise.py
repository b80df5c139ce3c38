"""Noise of samples and of a torque over windows: windows of one length side by side, as there are hundreds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Series
from testbed.estimation.torque_noise import covariance


@dataclass(frozen=True, kw_only=True, eq=False)
class _OfLength:
    """Windows of N samples.

    Attributes:
        which: of all windows, W of them.
        factor: Cholesky factors of the covariance of each and axis, shape (W, 3, N, N), rad/s.
        inverse: of these.
    """

    which: list[int]
    factor: Array
    inverse: Array


class WindowNoise:
    """Noise as `estimation.torque_noise` has it, over many windows."""

    def __init__(self, times: Sequence[Series], noise: Array) -> None:
        """Take the times of the samples of every window, shapes (N,), s, and the noise, shape (3, 5)."""
        lengths = np.array([len(time) for time in times])
        self._count, self._groups = len(times), []
        for length in np.unique(lengths):
            which = np.flatnonzero(lengths == length).tolist()
            factor = np.asarray(np.linalg.cholesky(covariance(np.stack([times[window] for window in which]), noise)))
            self._groups.append(_OfLength(which=which, factor=factor, inverse=np.asarray(np.linalg.inv(factor))))

    def whitened(self, blocks: Sequence[Array]) -> list[Array]:
        """Return every window's values without the noise, shapes (N, 3) or (N, 3, C).

        Args:
            blocks: in rad/s, alike; further ones are left out.
        """
        white: list[Array] = [np.empty(0)] * self._count
        for group in self._groups:
            values = np.stack([blocks[window] for window in group.which])
            by_axis = values.reshape(*values.shape[:3], -1).transpose(0, 2, 1, 3)
            found = (group.inverse @ by_axis).transpose(0, 2, 1, 3).reshape(values.shape)
            for window, own in zip(group.which, found, strict=True):
                white[window] = own
        return white

    def colored(self, white: Sequence[Array]) -> list[Array]:
        """Return what is white in each window, shapes (N, 3), in rad/s with its colour: `whitened` the other way."""
        colored: list[Array] = [np.empty(0)] * self._count
        for group in self._groups:
            found = np.einsum("wanm,wma->wna", group.factor, np.stack([white[window] for window in group.which]))
            for window, own in zip(group.which, found, strict=True):
                colored[window] = own
        return colored

    @property
    def deviance(self) -> Array:
        """Return ln det C + ln 1ᵀ C⁻¹ 1 of each window and axis, shape (R, 3): the second for the initial rate."""
        deviance = np.zeros((self._count, 3))
        for group in self._groups:
            logarithms = np.log(np.diagonal(group.factor, axis1=-2, axis2=-1)).sum(axis=-1)
            constants = (group.inverse.sum(axis=-1) ** 2).sum(axis=-1)
            deviance[group.which] = 2.0 * logarithms + np.log(constants)
        return deviance
