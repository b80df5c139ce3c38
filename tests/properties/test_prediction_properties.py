"""The two implementations of a gyrostat's motion, the compiled loop and the arrays, are one law."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from support.synthetic_telemetry import nominal_flight, pyramid_cluster, sample_times
from testbed.dynamics.inertia import theta_of
from testbed.estimation.motion import LONGEST_STEP, drive_of, simulate
from testbed.estimation.telemetry import GimbalTelemetry, Telemetry
from testbed.prediction.grid import grid_of
from testbed.prediction.integration import Values, node_rates
from testbed.rotation.quaternion import exponential, matrix_of

TIMES = sample_times(16.0)
ROUNDING = 1e-13
"""rad/s, of up to 5 rad/s: 160 steps of four slopes each; the worst of 25 examples is 2e-15."""


@given(
    principal=st.tuples(st.floats(0.5, 1.0), st.floats(0.6, 1.0), st.floats(1.01, 1.4)),
    turn=st.tuples(*[st.floats(-1.5, 1.5)] * 3),
    momentum=st.tuples(*[st.floats(-0.03, 0.03)] * 3),
    torque=st.tuples(*[st.floats(-1e-3, 1e-3)] * 3),
    swing=st.floats(0.0, 1.0),
    sets=st.integers(1, 2),
)
@settings(max_examples=25, deadline=None)
def test_the_compiled_loop_and_the_arrays_predict_the_same_motion(principal, turn, momentum, torque, swing, sets):
    axes = matrix_of(exponential(np.array(turn)))
    theta = theta_of(axes @ np.diag(np.array(principal) * 0.025) @ axes.T)
    angle = swing * nominal_flight().gimbals.angle(TIMES)
    run = Telemetry(
        gyro_time=TIMES,
        body_rate=np.zeros((len(TIMES), 3)),
        gyro_noise=1e-3,
        actuator_time=TIMES,
        gimbals=GimbalTelemetry(cluster=pyramid_cluster(), angle=angle),
        applied_torque=np.sin(TIMES)[:, None] * np.array(torque),
    )
    loop = simulate(drive_of(run), theta, np.array(momentum))
    # A second parameter set that differs has the arrays step along; a single one is solved for all steps together.
    thetas = theta * (1.0 + 0.1 * np.arange(sets))[:, None]
    values = Values(theta=thetas, initial_rate=loop.node_rate[:1][None], effects=())
    arrays = node_rates(grid_of([run], LONGEST_STEP), [], values)[0, 0]
    assert np.abs(loop.node_rate).max() < 5.0
    np.testing.assert_allclose(arrays, loop.node_rate, atol=ROUNDING)
