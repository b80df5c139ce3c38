"""Compare estimators over many flights: their errors beside the Cramér-Rao bound."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
NAMES = ("J11", "J22", "J33", "J23", "J13", "J12")
COLOURS = {"ls": "#D55E00", "iv": "#E69F00", "iv_momentum": "#009E73", "output_error": "#0072B2"}


def main():
    """Fly fifty runs and draw the errors of every estimator in units of the bound."""
    campaign = tb.monte_carlo(tb.read_scenario("basic", {"gyro.noise_rad_s": 0.01}), runs=50, seed=1)
    print(campaign)
    table = campaign.to_pandas()
    table.to_csv(FOLDER / "compare_estimators.csv", index=False)

    figure, axes = plt.subplots(figsize=(9, 4.5), layout="constrained")
    axes.axhspan(-1.96, 1.96, color="0.9", label="95 % at the bound")
    for place, (estimator, colour) in enumerate(COLOURS.items()):
        errors = [table[f"{estimator}_{name}_kg_m2"] - table[f"true_{name}_kg_m2"] for name in NAMES]
        shares = [error / table[f"bound_std_{name}_kg_m2"] for name, error in zip(NAMES, errors, strict=True)]
        at = np.arange(6) + 0.2 * (place - 1.5)
        style = {"boxprops": {"facecolor": colour}, "medianprops": {"color": "black"}, "flierprops": {"ms": 3}}
        axes.boxplot(shares, positions=at, widths=0.16, patch_artist=True, label=estimator, manage_ticks=False, **style)
    axes.set(xticks=range(6), xticklabels=NAMES, ylabel="error / standard deviation of the bound")
    figure.legend(loc="outside lower center", ncols=5)
    figure.savefig(FOLDER / "compare_estimators.png", dpi=120)


if __name__ == "__main__":  # worker processes import this file
    main()
