"""A function of a motion at many instants, with its Jacobian by the motion's free parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca


class Instants(NamedTuple):
    """What a function gives at N instants, one instant's R outputs below the other's.

    Attributes:
        values: a column of N R entries.
        jacobian: of these by n free parameters, shape (N R, n), sparse.
    """

    values: ca.MX
    jacobian: ca.MX


def at_instants(function: ca.Function, curves: Sequence[ca.MX], free: ca.MX) -> Instants:
    """Evaluate a function at each instant of its inputs' curves.

    CasADi differentiates a function of many instants by some thirty sweeps through all of them, as many as control
    points bend one instant. One instant's own Jacobian by its inputs takes the work of seven evaluations, and the
    curves' by the control points are constants: a fifth of the time on the six-unit platform.

    Args:
        function: of scalars and columns, with scalars or columns as outputs.
        curves: each input's values, of N columns.
        free: the motion's parameters, a column.
    """
    count = curves[0].shape[1]
    inputs = [ca.SX.sym(f"input_{index}", curve.shape[0]) for index, curve in enumerate(curves)]
    outputs = ca.vertcat(*function(*inputs))
    slopes = ca.Function("slopes", inputs, [ca.jacobian(outputs, each) for each in inputs]).map(count)(*curves)
    jacobian = ca.MX(outputs.numel() * count, free.numel())
    for slope, curve in zip(slopes, curves, strict=True):
        jacobian += ca.diagcat(*ca.horzsplit(slope, curve.shape[0])) @ _slope(ca.vec(curve), free)
    values = ca.MX(ca.vertcat(*function.map(count)(*curves)))
    return Instants(values=ca.vec(values), jacobian=jacobian)


def _slope(curve: ca.MX, free: ca.MX) -> ca.MX:
    """Return a curve's Jacobian, as numbers where it is one of constants."""
    slope = ca.jacobian(curve, free)
    return ca.MX(ca.evalf(slope)) if ca.is_linear(curve, free) else slope
