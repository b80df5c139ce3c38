"""Design to a target precision: the shortest maneuver whose standard deviations all stay below their targets."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
TARGET = np.array([2.2, 2.2, 2.2, 1.6, 1.6, 1.6]) * 1e-4  # kg m², of J11, J22, J33, J23, J13, J12
MARKS = "osD^v<"

shares = {}
for duration in (3.0, 3.5, 4.0, 4.5, 5.0):
    changed = {"maneuver.duration_s": duration, "simulation.duration_s": duration, "maneuver.starts": 1}
    scenario = tb.read_scenario("gimbal_weighted", changed | {"maneuver.target_std_kg_m2": TARGET.tolist()})
    maneuver = tb.design(scenario)
    bound = tb.fly(scenario, maneuver, seed=1).bound  # standard deviations of the Cramér-Rao bound, as flown
    shares[duration] = bound / TARGET
    print(f"{duration:g} s: the worst parameter has {shares[duration].max():.2f} of its target")
    if shares[duration].max() <= 1.0:
        break

table = pd.DataFrame.from_dict(shares, orient="index", columns=["J11", "J22", "J33", "J23", "J13", "J12"])
table.to_csv(FOLDER / "design_to_precision.csv", index_label="duration_s")
figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
for name, mark, colour in zip(table, MARKS, plt.colormaps["cividis"](np.linspace(0, 0.9, 6)), strict=True):
    axes.plot(table.index, table[name], f"{mark}-", color=colour, label=name)
axes.axhline(1.0, color="#D55E00", ls="--", label="target")
axes.set(xlabel="duration of the maneuver, s", ylabel="standard deviation at the bound / target", ylim=(0, None))
axes.legend(ncols=2)
figure.savefig(FOLDER / "design_to_precision.png", dpi=120)
