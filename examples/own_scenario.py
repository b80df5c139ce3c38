"""A scenario of your own: the shipped one with another platform, another gyro and a faster maneuver."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)
OWN = {
    "name": "heavier",
    "description": "A platform twice as heavy, with a better gyro.",
    "platform.mass_kg": 8.0,
    "platform.inertia_kg_m2": [[0.044, 0.001, 0.0], [0.001, 0.044, 0.0], [0.0, 0.0, 0.054]],
    "gyro.noise_rad_s": 0.005,
    "maneuver.scale": 1.5,  # the basic profile, half as fast again
}

shipped = tb.read_scenario("basic")
own = tb.read_scenario("basic", OWN)  # a key that no scenario has is refused, with the key that was probably meant
(FOLDER / "own_scenario.toml").write_text(own.file.text, encoding="utf-8")  # `testbed run own_scenario.toml` flies it

figure, (motion, shares) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for scenario, colour, shift in ((shipped, "#0072B2", -0.2), (own, "#D55E00", 0.2)):
    run = tb.fly(scenario, seed=1)
    print(run)
    flown, table = tb.frame_of(run.record), run.to_pandas()
    motion.plot(flown["time_s"], flown["true_body_rate_x_rad_s"], color=colour, label=scenario.name)
    places = [place + shift for place in range(6)]
    shares.bar(places, table["output_error_std"] * 1e3, 0.4, color=colour, label=scenario.name)
motion.set(title="Motion as flown", xlabel="time, s", ylabel="body rate about x, rad/s")
shares.set(title="Output error, from one flight", ylabel="standard deviation, 1e-3 kg·m²")
shares.set_xticks(range(6), table.index)
shares.legend(title="scenario")
figure.savefig(FOLDER / "own_scenario.png", dpi=120)
