"""How the flights of a campaign differ: what is drawn anew for each of them."""

from __future__ import annotations

from testbed.quantities import MomentSpread, RateSpread, ScaleSpread, VelocitySpread
from testbed.scenario.section import Section
from testbed.scenario.values import Six, Three

_NO_SPREAD = (0.0, 0.0, 0.0)


class Dispersion(Section):
    """Standard deviations of what each flight of a campaign draws anew; all normal about the scenario's own values.

    `testbed montecarlo` draws them for every run, `testbed run --dispersed` for one.
    """

    inertia_kg_m2: Six[MomentSpread] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """Of the true J11, J22, J33, J23, J13, J12."""
    rotor_momentum_relative: ScaleSpread = 0.0
    """Of each true rotor momentum on its own, as a share of it."""
    body_rate_rad_s: Three[RateSpread] = _NO_SPREAD
    """Of the initial body rate."""
    velocity_m_s: Three[VelocitySpread] = _NO_SPREAD
    """Of the initial velocity, inertial axes."""
    gyro_bias_rad_s: Three[RateSpread] = _NO_SPREAD
    """Of the gyro's constant bias."""
    gyro_scale_factor: Three[ScaleSpread] = _NO_SPREAD
    """Of the gyro's relative scale factor errors."""
