"""A small campaign for tests: flights of 1 s that differ in truth, start, gyro, noise; and a stand-in for workers."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from testbed.assembly.platform import nominal_platform
from testbed.campaign.columns import parameter_columns
from testbed.campaign.executor import BlockRows, Notify
from testbed.campaign.plan import Block, CampaignPlan
from testbed.campaign.rows import Row
from testbed.experiment.planning import plan_maneuver
from testbed.scenario.reader import read_scenario

ROOT = Path(__file__).resolve().parents[1]

_CHANGES = (
    ('name = "basic"', 'name = "small"'),
    ('kind = "basic"\nduration_s = 5.0', 'kind = "basic"\nduration_s = 1.0'),
    ("step_s = 0.00125", "step_s = 0.003125"),  # coarse and short: what is tested is not how well it flies
    ("duration_s = 5.0\ncontrol_rate_hz", "duration_s = 1.0\ncontrol_rate_hz"),
    ('estimators = ["ls", "iv", "iv_momentum", "output_error"]', 'estimators = ["ls", "output_error"]'),
    ("noise_rad_s = 0.025", "noise_rad_s = 0.002"),
    ('initial_momentum = "zero"', 'initial_momentum = "estimated"'),
)
DISPERSION = """
[dispersion]
inertia_kg_m2 = [1e-4, 1e-4, 1e-4, 5e-5, 5e-5, 5e-5]
rotor_momentum_relative = 0.01
body_rate_rad_s = [0.01, 0.01, 0.01]
velocity_m_s = [0.0, 0.0, 0.0]
gyro_bias_rad_s = [1e-3, 1e-3, 1e-3]
gyro_scale_factor = [1e-3, 1e-3, 1e-3]
"""


def small_scenario(folder: Path, *changes: tuple[str, str], dispersion: str = DISPERSION) -> Path:
    """Write the small scenario into a folder."""
    text = (ROOT / "scenarios" / "basic.toml").read_text(encoding="utf-8")
    for old, new in (*_CHANGES, *changes):
        assert old in text, f"{old} is not in the scenario"
        text = text.replace(old, new)
    path = folder / "small.toml"
    path.write_text(text + dispersion, encoding="utf-8")
    return path


def plan_of(path: Path, runs: int, seed: int = 5) -> CampaignPlan:
    """Return the campaign of a scenario file."""
    scenario = read_scenario(path)
    maneuver = plan_maneuver(scenario, nominal_platform(scenario)).maneuver
    return CampaignPlan(scenario=scenario, maneuver=maneuver, seed=seed, runs=runs)


@dataclass(kw_only=True)
class Pretended:
    """An executor that flies nothing: its rows are drawn from their seeds.

    Attributes:
        flown: indices of the blocks that it was given, as they were finished.
        backwards: whether the last block is finished first.
        most: blocks after which it is interrupted.
    """

    flown: list[int] = field(default_factory=list)
    backwards: bool = False
    most: int | None = None

    def finished(self, plan: CampaignPlan, blocks: Sequence[Block], notify: Notify) -> Generator[BlockRows]:  # noqa: ARG002
        for block in reversed(blocks) if self.backwards else blocks:
            if len(self.flown) == self.most:
                raise KeyboardInterrupt
            rows = [drawn_row(plan, block.first + index, seed) for index, seed in enumerate(block.seeds)]
            self.flown.append(block.index)
            yield BlockRows(block=block, rows=rows)


def drawn_row(plan: CampaignPlan, run: int, seed: int) -> Row:
    """Return a completed run whose estimates scatter by 1e-4 about its truth."""
    rng = np.random.default_rng(seed)
    truth = np.array([0.02, 0.02, 0.025, 0.0, 0.0, 0.001])
    row: Row = {"run": run, "seed": seed, "outcome": "completed", "message": ""}
    values = {"true": truth, "bound_std": np.full(6, 1e-4)}
    for name in plan.scenario.estimation.estimators:
        values |= {name: truth + 1e-4 * rng.standard_normal(6), f"{name}_std": np.full(6, 1e-4)}
    for prefix, theta in values.items():
        row |= dict(zip(parameter_columns(prefix), theta.tolist(), strict=True))
    return row
