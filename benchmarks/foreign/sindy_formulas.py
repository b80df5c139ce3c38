"""In an environment of its own: an ensemble of pysindy's STLSQ of residual torques on laws, for every npz of a folder.

python sindy_formulas.py FOLDER prints a line of JSON for each: `set`, and the `weights` of the terms that stay. The
files are written by benchmarks/formula_baselines.py.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pysindy
from sindy_terms import RIDGE, THRESHOLDS, regressed, sparse, torques

MODELS, KEPT = 20, 0.6
"""Regressions of an ensemble, each on samples drawn with replacement; share of them in which a term has to stay.

Source: Fasel, Kutz, Brunton & Brunton, "Ensemble-SINDy", Proc. R. Soc. A (2022): inclusion probabilities of 0.6.
"""


def weights(case):
    """Return what each term that stays makes up of the torque."""
    response, library = torques(case, "residual")[:, 0], torques(case, "columns")
    size, scale = np.linalg.norm(response), np.linalg.norm(library, axis=0)
    usable = scale > 1e-9 * scale.max()
    library, response, terms = library[:, usable] / scale[usable], response / size, case["terms"][usable]
    threshold, _ = sparse(library, response, THRESHOLDS[::2])
    if threshold is None:
        return {}
    optimizer = pysindy.EnsembleOptimizer(
        pysindy.STLSQ(threshold=threshold, alpha=RIDGE), bagging=True, n_models=MODELS
    )
    coefficients = regressed(optimizer, library, response)
    every = np.array(optimizer.coef_list).reshape(MODELS, -1)
    stays = (np.count_nonzero(every, axis=0) >= KEPT * MODELS) & (coefficients != 0.0)
    return {str(term): float(abs(each)) for term, each in zip(terms[stays], coefficients[stays], strict=True)}


if __name__ == "__main__":
    np.random.seed(0)  # noqa: NPY002 - pysindy draws its samples from the global generator
    for path in sorted(Path(sys.argv[1]).glob("*.npz")):
        with np.load(path) as case:
            print(json.dumps({"set": path.stem, "weights": weights(case)}), flush=True)
