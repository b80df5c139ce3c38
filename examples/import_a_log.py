"""Import a log of your own: a table with other names, units, axes and clock, by a map that begins as a proposal."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import testbed as tb

plt.switch_backend("Agg")  # no display is needed
FOLDER = Path(*sys.argv[1:2])
FOLDER.mkdir(parents=True, exist_ok=True)

scenario = tb.read_scenario("basic", {"gyro.noise_rad_s": 1.7e-3})
sent = tb.frame_of(tb.fly(scenario, seed=1).record)  # stands for your platform, whose gyro is turned by 90° about z
rates = {"x": sent["body_rate_y_rad_s"], "y": -sent["body_rate_x_rad_s"], "z": sent["body_rate_z_rad_s"]}
log = pd.DataFrame({"t_us": (1e6 * sent["time_s"]).round().astype(int)})
log = log.assign(**{f"gyro_{axis}_dps": np.degrees(rate) for axis, rate in rates.items()})
log = log.assign(**{f"gimbal_{n}_angle_deg": np.degrees(sent[f"gimbal_angle_{n}_rad"]) for n in range(1, 7)})
log.to_csv(FOLDER / "bench.csv", index=False)

proposed = tb.guess_map(FOLDER / "bench.csv")  # units by the names of columns; the axes only you know
mounted = proposed.replace("[channels.body_rate]", '[channels.body_rate]\naxes = ["-y", "x", "z"]')
(FOLDER / "bench.map.toml").write_text(mounted)
records = tb.import_log(FOLDER / "bench.csv", FOLDER / "bench.map.toml")
print(mounted, records, *records.channels["body_rate"].converted, sep="\n")
estimate = tb.estimate(scenario, records)
print(estimate)
estimate.to_urdf(FOLDER / "platform.urdf")

figure, (above, below) = plt.subplots(2, figsize=(8, 5), layout="constrained", sharex=True)
above.plot(log["t_us"] * 1e-6, log.filter(like="gyro"), ".-")
above.set(title="the log: gyro axes", ylabel="deg/s")
below.plot(records.runs[0].time, records.runs[0].channels["body_rate"], ".-", label=[*"xyz"])
below.set(title="the record: body axes", ylabel="rad/s", xlabel="s")
below.legend(loc="upper right")
figure.savefig(FOLDER / "import_a_log.png", dpi=120)
