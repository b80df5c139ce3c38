"""docs/effects.md says what the registry says, and its example is an effect."""

import re
from pathlib import Path

import numpy as np

from testbed.effects.contract import Effect
from testbed.effects.published import published
from testbed.prediction.hooks import Instant

PAGE = Path(__file__).parents[2] / "docs" / "effects.md"


def test_the_table_is_current():
    """If this fails: python -m testbed.effects.published."""
    assert PAGE.read_text(encoding="utf-8") == published(PAGE)


def test_the_example_is_an_effect_in_forty_lines():
    code = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[-1]  # the one in the library
    assert len([line for line in code.splitlines() if line.strip()]) <= 40
    namespace: dict = {"__name__": "rate_product"}
    exec(compile(code, "rate_product.py", "exec"), namespace)
    effect = namespace["RateProduct"]()
    assert isinstance(effect, Effect)
    rates = np.array([2.0, 3.0, 5.0])[None, None]
    at = Instant(time=np.zeros((1, 1)), body_rate=rates, attitude=np.eye(3), state=np.zeros((1, 1, 0)))
    torque_B = effect.hooks("platform").torque(np.array([[1e-4]]), at)
    np.testing.assert_allclose(torque_B[0, 0], [0.0, 0.0, 6e-4])
