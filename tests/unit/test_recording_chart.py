from dataclasses import replace

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from support.flights import THETA, content
from testbed.recording.chart import BAND, HALF_HEIGHT, log_estimates

SAMPLES = 3


def lines(path, name):
    """Return the strips of a drawing, shape (strips, 2, 2): from and to, x and y downwards."""
    (chunk,) = (c for c in RrdReader(path).stream().to_chunks() if c.entity_path == f"/estimates/{name}")
    return np.array(chunk.to_record_batch().column("LineStrips2D:strips")[0].as_py())


@pytest.fixture
def drawn(tmp_path):
    def draw(shown):
        stream = rr.RecordingStream("testbed", recording_id="chart", send_properties=False)
        stream.save(tmp_path / "chart.rrd")
        log_estimates(stream, shown)
        stream.disconnect()
        return tmp_path / "chart.rrd"

    return draw


def test_error_bars_stand_at_the_errors_with_their_bands(drawn):
    shown = content(SAMPLES)
    path = drawn(shown)
    least_squares, output_error = shown.estimates
    # The largest reach of all, here that of least squares, fills the height but for a twentieth.
    scale = HALF_HEIGHT / (1.05 * (6e-4 + BAND * least_squares.std.max()))
    for estimate, error in ((least_squares, -6e-4), (output_error, 2e-5)):
        bars = lines(path, f"{estimate.name}/band")
        np.testing.assert_allclose(bars[:, :, 1].mean(axis=1), -error * scale, atol=1e-3)
        np.testing.assert_allclose(np.ptp(bars[:, :, 1], axis=1), 2 * BAND * estimate.std * scale, rtol=1e-5)
    bound = lines(path, "bound")
    np.testing.assert_allclose(bound[0, :, 1], np.array([-1, 1]) * BAND * shown.bound_std[0] * scale, rtol=1e-5)


def test_estimates_of_one_parameter_stand_beside_each_other(drawn):
    path = drawn(content(SAMPLES))
    first, second = (lines(path, f"{name}/band")[:, 0, 0] for name in ("ls", "output_error"))
    assert (second > first).all()
    assert (first[1:] > second[:-1]).all()


def test_without_a_truth_the_nominal_is_the_zero_line(drawn):
    path = drawn(replace(content(SAMPLES), true_theta=None, nominal_theta=THETA))
    assert "/estimates/nominal" in RrdReader(path).store().schema().entity_paths()
    bars = lines(path, "ls/band")
    assert (bars[:, :, 1].mean(axis=1) > 0.0).all()  # downwards: below the nominal
