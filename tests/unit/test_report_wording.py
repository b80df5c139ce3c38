"""How numbers are written on the pages."""

import numpy as np
import pytest

from testbed.report.wording import figures_to


@pytest.mark.parametrize(
    ("value", "std", "written"),
    [
        (4.0031e-6, 2.2e-9, "4.0031e-06"),
        (0.029951, 2.3e-5, "0.029951"),
        (-2.18e-5, 1.1e-6, "-2.18e-05"),
        (1.0, 0.0, "1"),
        (0.0, 0.1, "0"),
        (123.456, 1e-12, "123.456"),
        (np.nan, 1.0, "nan"),
    ],
)
def test_as_many_digits_as_the_standard_deviation_allows(value, std, written):
    assert figures_to(value, std) == written
