"""A first flight: design a maneuver, fly it, and estimate the inertia from what the sensors sent."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
COLOURS = ("#0072B2", "#E69F00", "#009E73")

scenario = tb.read_scenario("zero_g", {"maneuver.starts": 1})
run = tb.fly(scenario, seed=1)
print(run)
if not (FOLDER / "first_flight").exists():  # nothing is ever overwritten
    run.save(FOLDER / "first_flight")  # `testbed view` opens it

sent = tb.frame_of(run.record)
table = run.to_pandas() * 1e3
error = table["output_error"] - table["true"]

figure, (motion, errors) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for axis, colour in zip("xyz", COLOURS, strict=True):
    motion.plot(sent["time_s"], sent[f"body_rate_{axis}_rad_s"], ".", ms=3, color=colour)
    motion.plot(sent["time_s"], sent[f"true_body_rate_{axis}_rad_s"], lw=1, color=colour, label=axis)
motion.set(title="Gyro samples (dots) and true body rate", xlabel="time, s", ylabel="body rate, rad/s")
motion.legend(title="body axis", loc="upper right")
errors.errorbar(table.index, 0.0 * error, 1.96 * table["bound_std"], fmt="none", elinewidth=16, ecolor="0.85")
errors.errorbar(table.index, error, 1.96 * table["output_error_std"], fmt="o", color=COLOURS[0], capsize=4)
errors.axhline(0.0, color="black", lw=0.8)
errors.set(title="Output error; grey: 95 % at the Cramér-Rao bound", ylabel="estimate minus truth, 1e-3 kg·m²")
figure.savefig(FOLDER / "first_flight.png", dpi=120)
