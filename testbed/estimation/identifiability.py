"""Which combinations of the inertia parameters a run determines at all, said in words where it does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from testbed.arrays import Array, Regressor, Theta, Vector3, Vectors3
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.errors import UnidentifiableError

RELATIVE_RANK = 1e-5
"""Excitation this much weaker than the strongest is rounding and interpolation, not motion."""
SIGNIFICANCE = 3.0
"""Standard deviations that an excitation must stand out by."""
NEGLIGIBLE_TERM = 0.02
"""Terms of a named direction that are smaller than this share of the largest are left out."""
WEAK_AXIS = 1e-3
"""An axis about which the body turns less than this share of its strongest counts as not turned about."""
CONFOUNDED = "the motion does not tell the inertia from the initial momentum"
DROWNED = "the motion is too weak, or too short, for the gyro's noise"


def without_momentum(regressor: Regressor, unknowns: int = 6) -> Regressor:
    """Return the unknowns' columns, what the momentum's columns explain of them taken out, shape (..., 3N, P).

    Args:
        regressor: shape (..., 3N, P + M), the columns of unknown momenta last.
        unknowns: P, by default the inertia's parameters.
    """
    wanted, momentum = regressor[..., :unknowns], regressor[..., unknowns:]
    return np.asarray(wanted - momentum @ explaining(momentum, wanted))


def explaining(columns: Array, values: Array) -> Array:
    """Return the smallest X of the least squares of columns X - values, shape (..., M, P).

    Args:
        columns: shape (..., R, M), of any rank.
        values: shape (..., R, P).
    """
    smallest = np.zeros((*columns.shape[:-2], columns.shape[-1], values.shape[-1]))
    for flight in np.ndindex(columns.shape[:-2] if columns.shape[-1] else 0):
        smallest[flight] = np.linalg.lstsq(columns[flight], values[flight])[0]
    return smallest


def require_identifiable(regressor: Regressor, sigma: float, inertia_size: Array, body_rate: Vectors3) -> None:
    """Refuse a motion that leaves a direction of the inertia open.

    A direction is open where the motion does not excite it, or so little that a third of the inertia itself would lie
    within one standard deviation: such an excitation does not differ from zero at three standard deviations.

    Args:
        regressor: noise-free, shape (..., 3N, 6 + M), the columns of unknown momenta last.
        sigma: standard deviation of the noise on its rows.
        inertia_size: size of the inertia, shape (...), kg·m².
        body_rate: of the motion, shape (..., N, 3), rad/s, for the message.

    Raises:
        UnidentifiableError: names the open directions and what the motion lacks, of flights side by side the first's
            that lacks something.
    """
    triangle = np.linalg.qr(without_momentum(regressor), mode="r")  # has the same, in a handful of rows
    _, strength, directions = np.linalg.svd(triangle)
    unexcited = strength <= RELATIVE_RANK * strength[..., :1]
    drowned = strength * np.asarray(inertia_size)[..., None] <= SIGNIFICANCE * sigma
    opened = unexcited | drowned
    if not opened.any():
        return
    flight = tuple(np.argwhere(opened.any(axis=-1))[0])
    rates = np.broadcast_to(body_rate, (*opened.shape[:-1], *body_rate.shape[-2:]))
    names = ", ".join(
        named_direction(direction, PARAMETER_NAMES) for direction in sparse_basis(directions[flight][opened[flight]])
    )
    reason = _missing_axis(rates[flight], sigma) or (CONFOUNDED if unexcited[flight].any() else DROWNED)
    raise UnidentifiableError(
        f"{names} cannot be determined: {reason}; fly a maneuver whose actuators turn the body about three axes, "
        "or a longer one"
    )


def inertia_size(theta: Theta) -> Array:
    """Return the mean principal moment, shape (...), kg·m²."""
    return np.asarray(theta[..., :3].mean(axis=-1))


def named_direction(direction: Array, names: Sequence[str]) -> str:
    """Return a combination of parameters as text, such as `J12 - 0.5 J13`, its first term positive.

    Args:
        direction: weight of each parameter, shape (P,).
        names: of the parameters.
    """
    terms = np.flatnonzero(np.abs(direction) > NEGLIGIBLE_TERM * np.abs(direction).max())
    weights = direction * np.sign(direction[terms[0]])
    text = ""
    for term in terms.tolist():
        size = "" if np.isclose(abs(weights[term]), 1.0, atol=0.005) else f"{abs(weights[term]):.2g} "
        sign = " - " if weights[term] < 0 else " + " if text else ""
        text += sign + size + names[term]
    return text


def sparse_basis(directions: Array) -> Array:
    """Return the same subspace in reduced echelon form, pivots largest first, so that rows name few parameters."""
    rows = directions.copy()
    pivots = []
    for index in range(len(rows)):
        pivot = int(np.argmax(np.abs(rows[index:]).max(axis=0)))
        best = index + int(np.argmax(np.abs(rows[index:, pivot])))
        rows[[index, best]] = rows[[best, index]]
        rows[index] /= rows[index, pivot]
        others = np.arange(len(rows)) != index
        rows[others] -= np.outer(rows[others, pivot], rows[index])
        pivots.append(pivot)
    return rows[np.argsort(pivots)]


def _missing_axis(body_rate: Vectors3, sigma: float) -> str:
    """Say about which axes a motion turns the body too little; nothing where it turns it about three."""
    _, strength, axes = np.linalg.svd(body_rate, full_matrices=False)
    turning = int((strength > max(WEAK_AXIS * strength[0], SIGNIFICANCE * sigma)).sum())
    if turning == 0:
        return _drowned_rate(body_rate, sigma)
    if turning == 1:
        return f"the body hardly turns but about the axis {_axis(axes[0])} in body axes"
    if turning == 2:
        return f"the body hardly turns about the axis {_axis(axes[2])} in body axes"
    return ""


def _drowned_rate(body_rate: Vectors3, sigma: float) -> str:
    speed = float(np.sqrt(np.mean(np.sum(body_rate**2, axis=1))))
    if speed == 0.0:
        return "the body hardly turns"
    return f"its body rate, {speed:.2g} rad/s (rms), drowns in the gyro's noise of {sigma:.2g} rad/s per sample"


def _axis(axis: Vector3) -> str:
    upright = (axis * np.sign(axis[np.argmax(np.abs(axis))])).round(2)
    return "[" + ", ".join(f"{component + 0.0:.2g}" for component in upright) + "]"
