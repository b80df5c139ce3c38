"""In an environment of its own: pysindy's STLSQ of residual torques on candidate torques, for every npz of a folder.

python sindy_terms.py FOLDER prints a line `CASE LABEL` for each; the files are written by benchmarks/blind_sindy.py.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
import pysindy

WINDOW, ORDER = 7, 3
"""Of the Savitzky-Golay filter that smooths before differences are taken: samples, and degree."""
THRESHOLDS, RIDGE = np.geomspace(0.02, 1.0, 18), 1.0
"""Of STLSQ: coefficients below a threshold are dropped, all being shares of the residual torque's own size; its ridge.

The threshold is the one whose regression has the best information criterion. The ridge is, of 0.001 to 3, that which
names most effects rightly: 8 of 18 at four detectable sizes, where 0.001 named 2.
"""
NONE = "none"


def derivative(values, time):
    """Return d/dt of values, shape (N, C), smoothed before."""
    method = pysindy.SmoothedFiniteDifference(smoother_kws={"window_length": WINDOW, "polyorder": ORDER})
    return method(values, t=time)


def torques(case, name):
    """Return J dr/dt of all runs, one row a sample and axis, shape (rows, C)."""
    parts = []
    runs = sum(key.startswith("time_") for key in case.files)
    for run in range(runs):
        values, time = case[f"{name}_{run}"], case[f"time_{run}"]
        flat = values.reshape(len(time), -1)
        slope = derivative(flat, time).reshape(len(time), 3, -1)
        parts.append(np.einsum("ij,njc->nic", case["inertia"], slope).reshape(3 * len(time), -1))
    return np.concatenate(parts)


def regressed(optimizer, library, response):
    """Return the coefficients of a sparse regression, or the mean ones of an ensemble of them, shape (C,)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a threshold has left no term
        optimizer.fit(library, response[:, None])
    return np.asarray(optimizer.coef_).ravel()


def sparse(library, response, thresholds=THRESHOLDS):
    """Return the threshold with the best information criterion, and the coefficients of its regression, shape (C,).

    None, and all zero, where no term is worth its place.
    """
    rows, best, chosen, kept = len(response), 0.0, None, np.zeros(library.shape[1])
    for threshold in thresholds:
        coefficients = regressed(pysindy.STLSQ(threshold=threshold, alpha=RIDGE), library, response)
        left = response - library @ coefficients
        used = np.count_nonzero(coefficients)
        worth = rows * np.log((response @ response) / (left @ left)) - used * np.log(rows)
        if worth > best:
            best, chosen, kept = worth, threshold, coefficients
    return chosen, kept


def label(case):
    """Return the candidate whose terms stay in the regression and make up the most of the torque."""
    response, library = torques(case, "residual")[:, 0], torques(case, "columns")
    size, scale = np.linalg.norm(response), np.linalg.norm(library, axis=0)
    usable = scale > 0.0
    if size == 0.0 or not usable.any():
        return NONE
    library, terms = library[:, usable] / scale[usable], case["terms"][usable]
    _, coefficients = sparse(library, response / size)
    parts = {term: terms == term for term in dict.fromkeys(terms.tolist())}
    weight = {term: float(np.linalg.norm(library[:, own] @ coefficients[own])) for term, own in parts.items()}
    best = max(weight, key=weight.get)
    return best if weight[best] > 0.0 else NONE


if __name__ == "__main__":
    for path in sorted(Path(sys.argv[1]).glob("*.npz")):
        with np.load(path) as case:
            print(path.stem, label(case), flush=True)
