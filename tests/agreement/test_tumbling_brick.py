"""A tumbling brick without and with damping, against NASA's published simulations: atmospheric cases 02 and 03."""

import numpy as np

from support.tumbling_brick import damping_of, predicted, published, rates, tumbled

LAST = 30.0


def test_undamped_brick_agrees_with_nasa_in_mujoco():
    table = published("case02")
    table = table[table["simulation"] == 1]
    worst = np.abs(tumbled(table["time_s"], 0.00125) - rates(table)).max()
    print(f"case 02 in MuJoCo: {worst:.1e} rad/s in 30 s")
    assert worst < 1e-10  # the published numbers have as many digits


def test_undamped_brick_agrees_with_nasa_in_the_law_that_estimators_integrate():
    table = published("case02")
    table = table[table["simulation"] == 1]
    time = np.linspace(0.0, LAST, 301)
    worst = np.abs(predicted(time)[np.rint(10.0 * table["time_s"]).astype(int)] - rates(table)).max()
    print(f"case 02 by dynamics.gyrostat: {worst:.1e} rad/s in 30 s")
    assert worst < 1e-8  # steps of 31 ms


def test_damped_brick_agrees_with_nasa_in_mujoco():
    """The damping follows the published air, a table of a row a second: its interpolation is what is left."""
    table, step = published("case03"), 0.0025
    table = table[table["simulation"] == 4]
    half_steps = np.arange(2 * round(table["time_s"][-1] / step) + 3) * step / 2.0
    worst = np.abs(tumbled(table["time_s"], step, damping_of(table, half_steps)) - rates(table)).max()
    print(f"case 03 in MuJoCo: {worst:.1e} rad/s in {table['time_s'][-1]:g} s")
    assert worst < 3e-8
    undamped = tumbled(table["time_s"], step)
    assert np.abs(undamped - rates(table)).max() > 0.1


def test_nasa_simulations_differ_by_more_among_themselves():
    """Five simulations of the one case, two of the other."""
    first, second = published("case02"), published("case03")
    ends = rates(first[first["time_s"] == LAST])
    apart = np.abs(ends - ends[0]).max()
    alike = [rates(second[(second["simulation"] == number) & (second["time_s"] <= 7.0)]) for number in (1, 4)]
    print(f"apart: {apart:.1e} and {np.abs(alike[0] - alike[1]).max():.1e} rad/s")
    assert 1e-5 < apart < 1e-4
    assert 1e-3 < np.abs(alike[0] - alike[1]).max() < 2e-3
