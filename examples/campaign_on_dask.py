"""A campaign on a Dask cluster: here two workers on this machine, elsewhere the address of your scheduler."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from distributed import LocalCluster

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
NAMES = ("J11", "J22", "J33", "J23", "J13", "J12")


def main():
    """Fly fifty runs and draw how often their errors are smaller than so many standard deviations."""
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        campaign = tb.monte_carlo(tb.read_scenario("basic"), runs=50, seed=1, scheduler=cluster.scheduler_address)
    print(campaign)
    table = campaign.to_pandas()
    table.to_csv(FOLDER / "campaign_on_dask.csv", index=False)

    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for estimator, colour in {"ls": "#D55E00", "iv": "#E69F00", "output_error": "#0072B2"}.items():
        error = np.array([table[f"{estimator}_{name}_kg_m2"] - table[f"true_{name}_kg_m2"] for name in NAMES])
        shares = np.sort(np.abs(error / [table[f"{estimator}_std_{name}_kg_m2"] for name in NAMES]).ravel())
        axes.step(shares, np.linspace(0, 1, shares.size), color=colour, label=estimator)
    half = np.abs(np.random.default_rng(1).normal(size=100_000))
    axes.plot(np.sort(half)[::100], np.linspace(0, 1, 1000), "k--", lw=1, label="normal errors")
    axes.set(xlabel="|error| / stated standard deviation", ylabel="share of errors below", xlim=(0, 6))
    axes.legend(loc="lower right")
    figure.savefig(FOLDER / "campaign_on_dask.png", dpi=120)


if __name__ == "__main__":  # worker processes import this file
    main()
