"""diagnosis.json: where a nominal model and measured records disagree, and what explains it."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from testbed.formats.parts import Part, Provenance, Six, SixOrNull, ThreeOrNull


class PlacedEffect(Part):
    """An effect at a component."""

    effect: str
    """Its id, as in the list of effects; `inertia` for an inertia other than the nominal one."""
    component: str
    """Where it is: a unit such as `cmg3`, an axis `x`, `y`, `z`, or `platform`, `gyro`, `cluster`, `actuators`."""


class EstimatedParameter(Part):
    """A parameter of an effect as estimated."""

    value: float | None
    """The estimate, in `unit`; null where it is not finite."""
    std: float | None
    """Its standard deviation, in `unit`; null where the data do not show it."""
    unit: str
    """Of value and std; `1` for a pure number."""


class Size(Part):
    """A parameter at a certain size of its effect."""

    value: float | None
    """The size, in `unit`; null where it is not finite."""
    unit: str
    """Of the value; `1` for a pure number."""


class Misfit(Part):
    """What functions of any shape up to `bandwidth_hz` explain of a model's gyro residual."""

    sigma: float
    """Misfit beyond noise, in standard deviations: the root of χ² minus its expected value."""
    noise_limit_sigma: float
    """Misfit that noise alone exceeds with a chance of 1 %, in standard deviations."""
    p_value: float
    """Chance of as much from noise alone, 0 to 1."""
    chi_square: float
    """χ², a pure number."""
    expected: float
    """Mean of χ² if nothing is missing, a pure number."""
    variance: float
    """Variance of χ² if nothing is missing, a pure number."""
    gimbals_chi_square: float
    """χ² of the gimbals' own channels, a pure number; 0 without them."""


class MisfitChange(Part):
    """The misfit without and with what was added.

    What is explained is null where the misfit before was no more than noise.
    """

    bandwidth_hz: float
    """Functions of time up to here are considered, Hz."""
    before: Misfit | None
    """Of the fitted runs without; null where the model's motion leaves the finite numbers."""
    after: Misfit | None
    """Of the fitted runs with; null likewise."""
    explained: float | None
    """Share of the fitted runs' squared misfit that is gone, 0 to 1."""
    explained_std: float | None
    """Its standard deviation, a pure number."""
    heldout_before: Misfit | None
    """Of the held-out runs without; null where no run is held out."""
    heldout_after: Misfit | None
    """Of the held-out runs with; null likewise."""
    heldout_explained: float | None
    """Share of the held-out runs' squared misfit that is gone, 0 to 1."""
    heldout_explained_std: float | None
    """Its standard deviation, a pure number."""


class Step(PlacedEffect):
    """An effect that was added to the model, or the inertia where it differs from the nominal one.

    A gap is the root mean square of measured minus predicted over the channel's own noise: 1 is the noise floor.
    It is null where it is not finite, and that of held-out runs where there are none.
    """

    parameters: dict[str, EstimatedParameter]
    """By name, such as `delay_s`."""
    probability: float | None
    """Posterior probability of this effect at this component, 0 to 1."""
    j_theta_kg_m2: SixOrNull
    """Inertia J11, J22, J33, J23, J13, J12 estimated together with this effect and those before it, kg·m²; null where
    it is about axes that no run turns about."""
    j_std_kg_m2: SixOrNull
    """Its standard deviations, kg·m²; null where the data do not show a parameter."""
    indistinguishable_from: list[PlacedEffect]
    """Effects that these data cannot distinguish from it."""
    doubts: list[str]
    """Why it is to be doubted in spite of its probability: a value that no hardware has, or at the end of its search,
    or a confounded effect that these data cannot test."""
    gap_before: float | None
    """Gap of the fitted runs without it, a pure number."""
    heldout_gap_before: float | None
    """Gap of the held-out runs without it, a pure number."""
    gap_after: float | None
    """Gap of the fitted runs with it, a pure number."""
    heldout_gap_after: float | None
    """Gap of the held-out runs with it, a pure number."""
    misfit: MisfitChange
    """The misfit without and with it."""


class Gap(Part):
    """Root mean square of measured minus predicted over the channel's own noise; null where it is not finite."""

    noise_floor: float
    """Gap of a model that is right: 1."""
    before: float | None
    """Of the fitted runs, inertia and initial rates re-estimated, without any effect; a pure number."""
    heldout_before: float | None
    """Of the held-out runs likewise; null where no run is held out; a pure number."""
    after: float | None
    """Of the fitted runs with all effects that were added; a pure number."""
    heldout_after: float | None
    """Of the held-out runs likewise; null where no run is held out; a pure number."""


class Segment(Part):
    """A stretch of one axis of one run in which the nominal model's residual is large."""

    signal: str
    """Such as `body_rate_y`."""
    run: str
    """Name of the run."""
    from_s: float
    """First sample of the stretch, s."""
    to_s: float
    """Last sample of the stretch, s."""
    share: float
    """Share of the whole residual's power, 0 to 1."""
    depends_on: str | None
    """What the residual of this axis goes along with, such as `gimbal_rate_3`; null where with nothing."""
    enters_as: Literal["reading", "torque"] | None
    """Whether it enters as a reading of the gyro, or as a torque; null where `depends_on` is."""
    correlation: float
    """Of residual and what it depends on, -1 to 1."""


class Untestable(Part):
    """An effect that these data could not show."""

    effect: str
    """Its id."""
    component: str | None = Field(default=None)
    """Where it is; absent where it could be tested at none of its components."""
    needs: str
    """What it would take to test for it: a channel, a size, or another motion."""


class SizeAtFrequency(Part):
    """The smallest size of an effect that these data would have shown at one frequency."""

    smallest: dict[str, Size]
    """Its parameters at that size, its frequency among them; empty where this motion shows nothing of it."""
    multiple_of_typical: float | None
    """That size over the typical one, a pure number; null where this motion shows nothing of it."""


class DetectableSize(PlacedEffect):
    """The smallest size of an effect that these data would have shown, whatever its frequency."""

    smallest: dict[str, Size]
    """Its parameters at that size, by name; empty where this motion shows nothing of it."""
    typical: dict[str, Size]
    """Its parameters at their typical size, by name."""
    multiple_of_typical: float | None
    """The smallest size over the typical one, a pure number; null where this motion shows nothing of it."""
    by_frequency: list[SizeAtFrequency]
    """The same at each frequency that was looked at, about the axis that shows the least; empty of effects without."""


class Pair(Part):
    """Two effects that these data hardly distinguish."""

    pair: Annotated[list[PlacedEffect], Field(min_length=2, max_length=2)]
    """The two."""
    distance: float
    """Sine of the smallest angle between what both can do, 0 to 1."""


class RunByRun(PlacedEffect):
    """An effect that was added, estimated from every run alone."""

    p_value: float
    """Chance of differences as large between the runs, if they agree, 0 to 1."""
    runs: dict[str, dict[str, EstimatedParameter]]
    """Its parameters by name of the run, each by the parameter's name; held-out runs included."""


class Differing(Part):
    """What differs from run to run, more probably than any further effect is there."""

    effect: str
    """Id of the effect that was added, or of the nominal model's; `inertia` of the inertia."""
    component: str
    """Where it is."""
    record: str
    """Name of the run that differs the most from all."""
    as_healthy: bool
    """Whether the healthy records differ as much, so that it is nothing new."""


class Theta(Part):
    """An estimated inertia."""

    theta_kg_m2: SixOrNull
    """J11, J22, J33, J23, J13, J12, kg·m²; null where no run turns about the axes that it takes."""
    std_kg_m2: SixOrNull
    """Standard deviations, kg·m²; null where the data do not show a parameter."""


class Inertia(Part):
    """The inertia without and with the effects that were added."""

    nominal_theta_kg_m2: Six
    """Of the nominal model: J11, J22, J33, J23, J13, J12, kg·m²."""
    before: Theta
    """Estimated without any effect."""
    after: Theta
    """Estimated together with all effects that were added."""
    differs_p_value: float
    """Chance of an estimate as far from the nominal inertia, if that is right, 0 to 1."""
    healthy_theta_kg_m2: Six | None = Field(default=None)
    """Of the healthy records, likewise, kg·m²; absent where the diagnosis was made without any."""
    differs_from_healthy_p_value: float | None = Field(default=None)
    """Chance of an estimate as far from that, if nothing has changed, 0 to 1; absent likewise."""


class Noise(Part):
    """The gyro's noise in the records against what they state.

    Of records that state none (`gyro_noise_rad_s`), against what the fourth differences of all their samples show.
    """

    by_record: dict[str, float]
    """Measured over stated standard deviation in every record, a pure number; without records too short to tell."""
    ratio_to_stated: ThreeOrNull
    """Measured over stated standard deviation about each body axis, a pure number; null where no run turns about it."""
    std: ThreeOrNull
    """Standard deviation of the ratio, a pure number; null likewise."""
    level: ThreeOrNull
    """Standard deviation in the final model over the stated one about each body axis, a pure number; null likewise."""
    correlation: ThreeOrNull
    """Correlation of neighbouring samples in the final model, a pure number: 0 for white noise; null likewise."""
    persistence: ThreeOrNull = Field(default=[0.0, 0.0, 0.0])
    """Factor by which the autocorrelation goes from each sample to the next one in the final model, a pure number: the
    correlation itself in an autoregression; null likewise."""
    degrees_of_freedom: float | None
    """A pure number: with how many the noise is known at low frequencies; null where what is stated is certain."""


class LatentTorque(Part):
    """An unmodelled torque that changes slowly, beside the final model."""

    likelihood_ratio: float
    """Twice the logarithm of the likelihood ratio with and without it."""
    p_value: float
    """Chance of as large a ratio without it, 0 to 1."""


class TorqueLeft(Part):
    """A significant unmodelled torque of a known shape."""

    kind: Literal["growing", "product of rates", "oscillation", "oscillation of every run's own", "pulses"]
    """Kind of the shape."""
    words: str
    """The shape in words."""
    evidence: float
    """Twice the logarithm of the factor by which it makes the data more likely."""
    reduction: float
    """Reduction of chi square, linearised; a pure number."""
    p_value: float
    """Chance of as much evidence, times the number of shapes that were tried."""
    frequency_hz: float | None
    """Of one that oscillates or comes in pulses, Hz; null for others."""
    phase: int
    """Number of the phase of pulses, of twelve from 0; 0 for others. A pure number."""


class RunRoles(Part):
    """Which runs were used for what."""

    fit: list[str]
    """Names of the runs that were fitted."""
    heldout: list[str]
    """Names of the runs that were held out."""


class PairAfter(Part):
    """Two explanations, before and after the proposed flight."""

    pair: Annotated[list[str], Field(min_length=2, max_length=2)]
    """The two, each as `effect:component`, or `inertia`."""
    sigma_now: float
    """Their distance in the present data, in standard deviations."""
    sigma_after: float
    """Their distance with the proposed flight flown once and added, in standard deviations."""
    sigma_wanted: float
    """Distance at which they are distinguished in 95 of 100 cases, in standard deviations."""
    separable: bool
    """Whether any flight of this platform distinguishes them."""


class NextFlight(Part):
    """What to fly next."""

    scenario: str | None
    """Its scenario, relative to the folder of the diagnosis; null where no flight would help."""
    flights: int
    """How often it has to be flown."""
    enough: bool
    """Whether that distinguishes every separable pair."""
    pairs: list[PairAfter]
    """Every pair of explanations that these data cannot distinguish, the closest first."""


class DiagnosisFile(Part):
    """diagnosis.json: where a nominal model and measured records disagree, and what explains it."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of this format."""
    complete: bool
    """False where the diagnosis was interrupted: the file then says what was known."""
    verdict: Literal["none", "named", "ambiguous", "unexplained"] | None
    """`none`: the nominal model with a different inertia explains the records; `named`: one effect does; `ambiguous`:
    these data cannot distinguish several, or it from a torque that no effect gives; `unexplained`: a residual is left.
    Null of a diagnosis that is not complete."""
    steps: list[Step]
    """What was added to the model, in order; the inertia, where it differs from the nominal one, stands first."""
    gap: Gap
    """Residual over noise, before and after."""
    misfit: MisfitChange
    """Misfit beyond noise, before and after."""
    where: list[Segment]
    """Where the nominal model's residual is more than noise, the largest share first."""
    probabilities: dict[str, float]
    """Posterior probability, 0 to 1, of `none`, of each explanation as `effect:component`, and of `unknown`."""
    untestable: list[Untestable]
    """Effects that these data could not show."""
    detectable: list[DetectableSize]
    """The smallest size of each effect that these data would have shown."""
    look_alikes: list[Pair]
    """Effects that these data hardly distinguish, the closest first."""
    run_by_run: list[RunByRun]
    """Whether the runs agree on what was added."""
    differs: Differing | None
    """What differs from run to run; null where no further effect was weighed against that, or one is more probable."""
    inertia: Inertia
    """The inertia without and with the effects."""
    noise: Noise
    """The gyro's noise."""
    latent_torque: LatentTorque | None
    """An unmodelled torque beside the final model; null where it was not estimated."""
    torque_left: TorqueLeft | None
    """A significant unmodelled torque of a known shape; null where there is none."""
    retracted: Annotated[list[PlacedEffect], Field(alias="taken_back")]
    """Effects that were retracted: an unmodelled torque has higher posterior odds."""
    runs: RunRoles
    """The runs by name: fitted, and held out."""
    notices: list[str]
    """What a reader has to know, a sentence each."""
    model: str | None
    """The extended model's MJCF, relative to this folder; null where it cannot be built."""
    scenario: str | None
    """The scenario that flies it, relative to this folder; null likewise."""
    next: NextFlight | None = Field(default=None)
    """What to fly next; absent where nothing is ambiguous, or where no flight was proposed."""
    provenance: Provenance
    """What decides the result."""
