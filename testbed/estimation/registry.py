"""Every estimator by the name that scenarios and results use."""

from __future__ import annotations

from testbed.estimation.estimate import Estimator, EstimatorSideBySide
from testbed.estimation.instrumental_variable import instrumental_variable
from testbed.estimation.least_squares import least_squares
from testbed.estimation.momentum_form import momentum_form, momentum_forms
from testbed.estimation.output_error import output_error, output_errors

ESTIMATORS: dict[str, Estimator] = {
    "ls": least_squares,
    "iv": instrumental_variable,
    "iv_momentum": momentum_form,
    "output_error": output_error,
}
"""Least squares, instrumental variable, the same in momentum form, output error."""

SIDE_BY_SIDE: dict[str, EstimatorSideBySide] = {"iv_momentum": momentum_forms, "output_error": output_errors}
"""Those of them that take flights side by side, which campaigns have; of the others flights are estimated in turn."""
