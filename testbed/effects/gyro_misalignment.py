"""The gyro's axes do not stand along the body's: turned together, or oblique to each other."""

from __future__ import annotations

from typing import final

import numpy as np
from typing_extensions import override

from testbed.arrays import Array, Series
from testbed.effects.contract import Effect, Extension, Parameter
from testbed.prediction.hooks import Hooks
from testbed.prediction.kernels import cross
from testbed.scenario.scenario import Scenario

TURNED, OBLIQUE = "gyro", "gyro_cross_axis"


class _Turned(Hooks):
    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        turn = np.broadcast_to(value[:, None], reading.shape)
        across = cross(turn, reading)
        # sin θ / θ and (1 - cos θ) / θ² of Rodrigues' formula, to 1e-8 at the largest plausible θ
        square = np.einsum("pk,pk->p", value, value)[:, None, None]
        first = 1.0 - square / 6.0 * (1.0 - square / 20.0)
        second = 0.5 - square / 24.0 * (1.0 - square / 30.0)
        return np.asarray(reading - first * across + second * cross(turn, across))


class _Oblique(Hooks):
    @override
    def gyro_reading(self, reading: Array, value: Array, time: Series, run: int) -> Array:
        x, y, z = np.moveaxis(reading, -1, 0)
        yz, xz, xy = (value[:, index, None] for index in range(3))
        return np.asarray(reading + np.stack((xy * y + xz * z, xy * x + yz * z, xz * x + yz * y), axis=-1))


@final
class GyroMisalignment(Effect):
    """ω̄ = exp(-v×) ω of the gyro turned by the vector v; or ω̄ = (1 + E) ω, E symmetric with zero diagonal.

    A turn of 2 deg without its square is 6e-4 of the rate off, as another inertia would make it. The two are hypotheses
    of their own: at zero total momentum E is the same as products of inertia, v is not.
    """

    id = "gyro_misalignment"
    components = (TURNED, OBLIQUE)
    parameters = tuple(
        Parameter(name=f"{pair}_rad", unit="rad", typical=0.01, plausible=(-0.2, 0.2)) for pair in ("yz", "xz", "xy")
    )
    sentence = "The axes of the gyro do not stand along those of the body."
    look_alikes = ("gimbal_misalignment", "inertia", "gyro_scale")
    confirm = "A release with a spin about each axis in turn: what an axis reads of the others is then seen alone."

    @override
    def hooks(self, component: str) -> Hooks:
        return _Turned() if component == TURNED else _Oblique()

    @override
    def extension(self, component: str, values: Array, scenario: Scenario) -> Extension:
        key = "misalignment_rad" if component == TURNED else "cross_axis_rad"
        return Extension(scenario={"gyro": {key: (np.array(getattr(scenario.gyro, key)) + values).tolist()}})
