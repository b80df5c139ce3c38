"""Every number of a scenario as no person means it."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

import tomli_w

from support.processes import ROOT
from tests.robustness.case import ANY, Case, written

BASIC = tomllib.loads((ROOT / "scenarios" / "basic.toml").read_text(encoding="utf-8"))
HOSTILE: dict[str, Any] = {
    "1e300": 1e300,
    "-1e300": -1e300,
    "1e-300": 1e-300,
    "1e9": 1e9,
    "0": 0.0,
    "-1": -1.0,
    "text": "[red]many[/]",
    "empty": [],
}
RUN = (("check", "scenario.toml"), ("run", "scenario.toml", "--out", "out"))
MORE: dict[str, dict[str, Any]] = {
    "truth": {
        "inertia_kg_m2": [[0.022, 0.0, 0.0], [0.0, 0.022, 0.0], [0.0, 0.0, 0.027]],
        "mass_kg": 4.0,
        "rotor_momentum_N_m_s": 0.004714,
        "gimbal_axis_misalignment_rad": [[0.0, 0.0]] * 6,
    },
    "cabin": {"size_m": [3.0, 3.0, 3.0]},
    "gyro": {
        "extra_noise_rad_s": [0.0, 0.0, 0.0],
        "bias_rad_s": [0.0, 0.0, 0.0],
        "drift_rad_s2": [0.0, 0.0, 0.0],
        "bias_instability_rad_s": 1e-4,
        "bias_correlation_time_s": 100.0,
        "rate_random_walk_rad_s_per_sqrt_s": 0.0,
        "scale_factor_error": [0.0, 0.0, 0.0],
        "misalignment_rad": [0.0, 0.0, 0.0],
        "cross_axis_rad": [0.0, 0.0, 0.0],
        "bandwidth_hz": 50.0,
        "latency_s": 0.0,
        "quantization_rad_s": 0.0,
        "saturation_rad_s": 5.0,
    },
    "encoder": {"quantization_rad": 0.0, "zero_rad": [0.0] * 6, "dead_zone_rad": [0.0] * 6},
    "tachometer": {"scale_factor_error": [0.0] * 6},
    "controller": {"feedback_gain_1_s": 5.0},
    "simulation": {"settle_s": 0.0},
}
"""Keys that the shipped scenario leaves out."""


def cases() -> Iterator[Case]:
    """Give a case for every number and every hostile value."""
    whole = _merged(BASIC, MORE)
    whole["estimation"]["initial_momentum"] = "estimated"
    for number, place in enumerate(_numbers(whole)):
        for name, value in HOSTILE.items():
            text = tomli_w.dumps(_with(whole, place, value))
            yield Case(
                name=f"scenario: {'.'.join(place)} = {name}",
                prepare=written({"scenario.toml": text}),
                commands=RUN,
                codes=ANY,
                fast=name in {"1e300", "1e-300"} and number % 18 == 0,
            )


def _merged(one: dict[str, Any], other: dict[str, dict[str, Any]]) -> dict[str, Any]:
    return {**one, **{section: {**one.get(section, {}), **more} for section, more in other.items()}}


def _numbers(tree: dict[str, Any], above: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Give the place of every number or list of numbers."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from _numbers(value, (*above, key))
        elif (
            isinstance(value, (int, float, list))
            and not isinstance(value, bool)
            and key not in {"estimators", "failed"}
        ):
            yield (*above, key)


def _with(tree: dict[str, Any], place: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Return a tree with another value at a place; in a list of numbers, as its first."""
    head, *rest = place
    if rest:
        return {**tree, head: _with(tree[head], tuple(rest), value)}
    return {**tree, head: _replaced(tree[head], value)}


def _replaced(old: Any, value: Any) -> Any:
    if isinstance(old, list) and value != []:
        return [_replaced(old[0], value), *old[1:]]
    return value
