"""In an environment of its own: pyoperon's symbolic regression of smoothed torques, for every npz of a folder.

python operon_torques.py FOLDER prints a line of JSON for each: `set`, and the `torque` (M, 3) that the expressions of
the three axes make at the knots, N·m; zero where an expression is constant. The files are written by
benchmarks/formula_baselines.py.
"""

import json
import sys
from pathlib import Path

import numpy as np
from pyoperon.sklearn import SymbolicRegressor

SETTINGS = {
    "allowed_symbols": "add,sub,mul,sin,abs,square,constant,variable",
    "max_length": 15,
    "population_size": 500,
    "generations": 100,
    "max_evaluations": 50_000,
    "optimizer_iterations": 5,
    "model_selection_criterion": "minimum_description_length",
    "n_threads": 1,
    "random_state": 1,
}
"""What the grammar has but its memories, in expressions long enough for three factors with their coefficients; of those
on the front of length and error, the one of minimum description length, which the package chooses."""


def fitted(features, torque):
    """Return what expressions of the features make of a torque, shape (M, 3)."""
    parts = []
    for axis in torque.T:
        size = float(np.abs(axis).max())
        if size == 0.0:
            parts.append(np.zeros(len(axis)))
            continue
        regressor = SymbolicRegressor(**SETTINGS).fit(features, axis / size)
        made = np.asarray(regressor.predict(features)).ravel() * size
        parts.append(made if np.ptp(made) > 0.0 else np.zeros(len(axis)))
    return np.stack(parts, axis=-1)


if __name__ == "__main__":
    for path in sorted(Path(sys.argv[1]).glob("*.npz")):
        with np.load(path) as case:
            print(
                json.dumps({"set": path.stem, "torque": fitted(case["features"], case["torque"]).tolist()}), flush=True
            )
