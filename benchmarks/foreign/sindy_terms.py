"""In an environment of its own: pysindy's STLSQ of residual torques on candidate torques, for every npz of a folder.

python sindy_terms.py FOLDER prints a line `CASE LABEL` for each; the files are written by benchmarks/blind_sindy.py.
"""

import sys
from pathlib import Path

import numpy as np
import pysindy

WINDOW, ORDER = 7, 3
"""Of the Savitzky-Golay filter that smooths before differences are taken: samples, and degree."""
THRESHOLD, RIDGE = 0.1, 0.05
"""Of STLSQ: coefficients below this are dropped, all being shares of the residual torque's own size; its ridge."""
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


def label(case):
    """Return the candidate whose terms stay in the regression and are the largest."""
    response, library = torques(case, "residual")[:, 0], torques(case, "columns")
    size, scale = np.linalg.norm(response), np.linalg.norm(library, axis=0)
    usable = scale > 0.0
    if size == 0.0 or not usable.any():
        return NONE
    optimizer = pysindy.STLSQ(threshold=THRESHOLD, alpha=RIDGE)
    optimizer.fit(library[:, usable] / scale[usable], response[:, None] / size)
    share = np.zeros(len(scale))
    share[usable] = np.abs(np.asarray(optimizer.coef_).ravel())
    terms = case["terms"]
    weight = {term: float(np.linalg.norm(share[terms == term])) for term in dict.fromkeys(terms.tolist())}
    best = max(weight, key=weight.get)
    return best if weight[best] > 0.0 else NONE


if __name__ == "__main__":
    for path in sorted(Path(sys.argv[1]).glob("*.npz")):
        with np.load(path) as case:
            print(path.stem, label(case), flush=True)
