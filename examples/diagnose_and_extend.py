"""Find what a model is missing, add it to the model, and fly that: the gyro of the platform is 12.5 ms late."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
SCENARIO, RATE = {"maneuver.starts": 1}, "body_rate_x_rad_s"

nominal = tb.read_scenario("diagnose", SCENARIO)
maneuver = tb.design(nominal)
platform = tb.read_scenario("diagnose", SCENARIO | {"gyro.latency_s": 0.0125})  # stands for yours
measured = tb.Records(tuple(tb.fly(platform, maneuver, seed=seed).record for seed in (1, 2)))

diagnosis = tb.diagnose(nominal, measured, propose=False)
print(diagnosis)
for step in diagnosis.steps:
    print(step.effect.id, *(f"{each.name} {each.value:.5f} ± {each.std:.5f} {each.unit}" for each in step.quantities))
diagnosis.to_pandas().to_csv(FOLDER / "diagnose_and_extend.csv")
extended = tb.read_scenario(diagnosis.extended_model.save(FOLDER / "extended"))

figure, (motion, misfit) = plt.subplots(1, 2, figsize=(10, 4), width_ratios=(2, 1), layout="constrained")
flown = tb.frame_of(measured.runs[0])
for scenario, colour, label in ((nominal, "#D55E00", "nominal model"), (extended, "#0072B2", "extended model")):
    predicted = tb.frame_of(tb.fly(scenario, maneuver, seed=4).record)
    motion.plot(flown["time_s"], (flown[RATE] - predicted[RATE]) * 1e3, ".", color=colour, label=label)
motion.set(xlabel="time, s", ylabel="about x, mrad/s", title="Gyro: platform minus flight of the model")
motion.legend()
for place, key, colour in ((-0.2, "before", "#D55E00"), (0.2, "after", "#0072B2")):
    sizes = [diagnosis.result["misfit"][prefix + key]["sigma"] for prefix in ("", "heldout_")]
    misfit.bar([place, 1 + place], sizes, 0.4, color=colour, label=f"{key} the addition")
misfit.set(ylabel="misfit beyond noise, σ", xticks=[0, 1], xticklabels=["fitted run", "held-out run"])
misfit.margins(y=0.3)  # the legend stands above the bars
misfit.legend()
figure.savefig(FOLDER / "diagnose_and_extend.png", dpi=120)
