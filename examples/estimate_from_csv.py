"""Estimate the inertia from CSV files: two flights, read with pandas, tested against each other and combined."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
NOISE = 1.7e-3  # rad/s, of a sample of the gyro

INERTIA = [[0.0212, 0.0004, -0.0003], [0.0004, 0.0226, 0.0002], [-0.0003, 0.0002, 0.0275]]  # kg m²

nominal = tb.read_scenario("basic", {"gyro.noise_rad_s": NOISE})
flown = tb.read_scenario("basic", {"gyro.noise_rad_s": NOISE, "truth.inertia_kg_m2": INERTIA})
for number in (1, 2):  # stands for your platform: what it sent, without what only a simulation knows
    run = tb.fly(flown, seed=number)
    tb.frame_of(run.record).filter(regex="^(?!true|reference)").to_csv(FOLDER / f"flight_{number}.csv", index=False)
tables = {f"flight {number}": pd.read_csv(FOLDER / f"flight_{number}.csv") for number in (1, 2)}
estimate = tb.estimate(nominal, tb.records_from(tables, gyro_noise_rad_s=NOISE))
print(estimate)
table = estimate.to_pandas() * 1e3
table.to_csv(FOLDER / "estimate_from_csv.csv")

figure, axes = plt.subplots(1, 6, figsize=(11, 3.6), layout="constrained")
for name, truth, panel in zip(table.index, run.truth * 1e3, axes, strict=True):
    panel.axhline(table["nominal"][name], color="0.5", ls=":", label="nominal")
    panel.axhline(truth, color="black", lw=1, label="true")
    for place, (estimator, colour) in enumerate({"iv": "#E69F00", "output_error": "#0072B2"}.items()):
        value, std = table[estimator][name], table[f"{estimator}_std"][name]
        panel.errorbar(place, value, 1.96 * std, fmt="o", capsize=4, color=colour, label=estimator)
    panel.set(title=name, xticks=[], xlim=(-0.7, 1.7))
axes[0].set_ylabel("inertia, 1e-3 kg·m², ± 95 %")
figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
figure.savefig(FOLDER / "estimate_from_csv.png", dpi=120)
