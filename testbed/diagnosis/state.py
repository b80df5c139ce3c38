"""What is known in the course of a diagnosis: gaps, steps, and the verdict that follows from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, sqrt
from typing import Literal

import numpy as np

from testbed.arrays import Theta
from testbed.diagnosis.candidates import UNKNOWN, Candidate, Screening, accepted, by_class, probabilities_of
from testbed.diagnosis.data import Runs
from testbed.diagnosis.latent import LatentTorque
from testbed.diagnosis.misfit import Misfit
from testbed.diagnosis.model import AtComponent, Fit, Hypothesis
from testbed.diagnosis.noise import NoiseHypothesis
from testbed.diagnosis.noise_level import NoiseLevel
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.testable import Untestable
from testbed.diagnosis.torque_shapes import TorqueShape, most_probable

Verdict = Literal["none", "named", "ambiguous", "unexplained"]
_SAME_SIZE = 0.1
"""Share by which an effect on the noise may differ from that of healthy records and be the same.

Source: chosen: as well as a noise is taken to be known, `gyro.noise_uncertainty`."""
_SURELY = 3.0
"""Standard errors of their difference that it may differ by besides.

Source: convention: chance alone makes three in one of 370 data sets."""


_BY_CHANCE = 1e-3
"""p-value above which a residual's one failed test may be chance: of the three tests one fails in 3 % of data sets.

Source: chosen: a tenth of `unexplained_p_value`; nine in ten of the residuals of noise that fail a test lie above."""


@dataclass(frozen=True, kw_only=True)
class Gap:
    """Residual of a model: root mean square after whitening, 1 is the noise floor, and misfit beyond noise.

    Attributes:
        fit: of the runs that are fitted.
        heldout: of those that are not, only their initial rates fitted; NaN where there are none.
        misfit: of the runs that are fitted; None where the model's motion leaves the finite numbers.
        heldout_misfit: of those that are not; None likewise, and where there are none.
    """

    fit: float
    heldout: float
    misfit: Misfit | None
    heldout_misfit: Misfit | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Step(AtComponent):
    """An effect that was added to the model.

    Attributes:
        candidate: the effect, and the model with it.
        screening: all that it was compared with.
        before: gap without it.
        after: gap with it.
    """

    candidate: Candidate
    screening: Screening
    before: Gap
    after: Gap

    @property
    def placed(self) -> Hypothesis:
        """Effect and component."""
        return self.candidate.placed

    @property
    def look_alikes(self) -> tuple[Hypothesis, ...]:
        """Effects that the data cannot distinguish from it."""
        return tuple(other.placed for other in self.screening.close if other.placed.key != self.placed.key)


@dataclass(frozen=True, kw_only=True)
class OwnSizes:
    """That an effect in the model, or the inertia, is another in each run.

    Attributes:
        placed: the effect; None of the inertia.
        odds: twice the logarithm of the posterior odds of own sizes against one of all runs.
        record: that differs the most from all.
        explains_most: whether that is most of what is more than noise.
        as_healthy: whether it is an effect that healthy records have, whose sizes scatter as there, and which leaves
            nothing but noise then.
    """

    placed: Hypothesis | None
    odds: float
    record: str
    explains_most: bool
    as_healthy: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """What is known so far.

    Attributes:
        runs: that were fitted.
        heldout: that were not; None where there are none.
        nominal_theta: the nominal model's inertia, kg·m².
        baseline: the nominal model with inertia and initial rates re-estimated.
        model: with all effects added.
        gap_before: of the baseline.
        gap: of the model.
        noise: the gyro's noise against what is stated.
        noise_candidates: every hypothesis on the gyro's noise, against the baseline.
        scatter: effects on the gyro's noise, re-estimated with every model; the runs have that noise.
        steps: effects in the order in which they were added.
        retracted: effects that were added, and explain less than an unmodelled torque does.
        given_up: effects that were added on the way, and do not stand out beside what was found later.
        remaining: the hypotheses against the final model; None until they were looked at.
        latent: unmodelled torque beside the final model; None until it was estimated.
        latent_before: beside the nominal model; None where the final one has no effect on the motion.
        shapes: of unmodelled torques, against the final model, the one with the most evidence first.
        unmodelled: evidence of any such torque against the baseline.
        explained: odds of all effects together against the baseline; 0 without any.
        differing: what is more probable than any further effect, so that none is added; None where nothing is.
        rivals: formulas that explain as much as effects of the library that leave nothing, the best one first.
        goodness: p-value of the χ² of the final model's gyro residual in all runs.
        untestable: effects for which a channel is missing.
        alone: whether all runs are of one record, which gets no name.
        ended_early: whether numbers that left the finite ones ended it before the final model's residual was tested.
        complete: whether nothing follows.
        notices: what a reader has to know of how it came there.
    """

    runs: Runs
    heldout: Runs | None
    nominal_theta: Theta
    baseline: Fit
    model: Fit
    gap_before: Gap
    gap: Gap
    noise: NoiseLevel
    noise_candidates: tuple[NoiseHypothesis, ...] = ()
    scatter: tuple[NoiseHypothesis, ...] = ()
    steps: tuple[Step, ...] = ()
    retracted: tuple[Hypothesis, ...] = ()
    given_up: tuple[Hypothesis, ...] = ()
    remaining: Screening | None = None
    latent: LatentTorque | None = None
    latent_before: LatentTorque | None = None
    shapes: tuple[TorqueShape, ...] = ()
    unmodelled: float = -inf
    explained: float = 0.0
    differing: OwnSizes | None = None
    rivals: tuple[str, ...] = ()
    goodness: float = 1.0
    untestable: tuple[Untestable, ...] = ()
    alone: bool = False
    ended_early: bool = False
    complete: bool = False
    notices: tuple[str, ...] = ()

    def begins_again(self, before: Diagnosis) -> bool:
        """Return whether it is the first stage with other runs fitted, or with trims of records after one of all."""
        own_trims = bool(before.runs.trim_group) and not self.runs.trim_group
        return own_trims or self.runs.record_names != before.runs.record_names

    @property
    def step_keys(self) -> tuple[str, ...]:
        """Names of its effects, in the order in which they were added."""
        return tuple(step.key for step in self.steps)

    @property
    def walks(self) -> bool:
        """Whether a gyro's bias that walks is in its noise."""
        return any(each.walks for each in self.scatter)

    @property
    def differing_odds(self) -> float:
        """Twice the logarithm of the posterior odds of what differs from run to run; 0 where nothing does."""
        return 0.0 if self.differing is None else self.differing.odds

    @property
    def left_over(self) -> bool:
        """Whether the model's residual is more than noise, or could not be tested."""
        if self.ended_early or (self.differing is not None and self.differing.as_healthy):
            return self.ended_early
        missed = self.actuators_missed > SETTINGS.channel_missed
        return missed or self.goodness < SETTINGS.unexplained_p_value or self.structure_left

    @property
    def hardly_left_over(self) -> bool:
        """Whether but one of the tests of the residual fails, and by no more than chance lets it of some data sets."""
        walking = 1.0 if self.latent is None else self.latent.p_value
        shape = 1.0 if self.shape_left is None else self.shape_left.p_value
        failed = [each for each in (self.goodness, walking, shape) if each < SETTINGS.unexplained_p_value]
        sure = self.ended_early or self.unnamed or self.actuators_missed > SETTINGS.channel_missed
        return not sure and len(failed) == 1 and failed[0] > _BY_CHANCE

    @property
    def actuators_missed(self) -> float:
        """Root mean square of what the model misses of the actuators' channel that it misses most, in its noise."""
        by_run = self.runs.gimbals_by_run(self.model.residual)
        channels = [np.concatenate([block.ravel() for block in blocks]) for blocks in zip(*by_run, strict=True)]
        return max((sqrt(float(np.mean(each**2))) for each in channels if each.size), default=0.0)

    @property
    def structure_left(self) -> bool:
        """Whether the model's residual has structure, however large it is."""
        walks = self.latent is not None and self.latent.p_value < SETTINGS.unexplained_p_value
        return walks or self.shape_left is not None or bool(self.unnamed)

    @property
    def unnamed(self) -> tuple[Candidate, ...]:
        """The significant effect that was not added, or was retracted, and its equivalence class."""
        if self.differing is not None or self.remaining is None or accepted(self.remaining) is None:
            return ()
        return self.remaining.close

    @property
    def nearest(self) -> Fit:
        """The model that explains the most: of a single record, which gets no name, that of a hypothesis."""
        compared = self.remaining.candidates if self.alone and self.remaining is not None else ()
        return min([self.model, *(each.fit for each in compared)], key=lambda fit: fit.root_mean_square)

    @property
    def shape_left(self) -> TorqueShape | None:
        """The significant unmodelled torque of a known shape; None where there is none."""
        return most_probable(self.shapes, SETTINGS.unexplained_p_value)

    @property
    def torque_explained(self) -> float | None:
        """Share of what a torque of any shape would explain that the effects do; None where none stood out before.

        Nor where it stands out in noise of another level alone, as may be that which few records show: it explains
        nothing then in the noise as the model has it.
        """
        before, after = self.latent_before, self.latent
        if before is None or after is None or before.p_value >= SETTINGS.unexplained_p_value:
            return None
        if before.likelihood_ratio == 0.0:
            return None
        return max(1.0 - after.likelihood_ratio / before.likelihood_ratio, 0.0)

    @property
    def verdict(self) -> Verdict | None:
        """The answer in a word; None until the diagnosis is complete, as what was not looked at yet may be missing."""
        if not self.complete:
            return None
        if self.left_over:
            return "unexplained"
        if not self.added:
            return "none"
        confounded = any(each.look_alikes for each in self.steps or self.added)
        return "ambiguous" if confounded or self.unmodelled_is_more_probable else "named"

    @property
    def unmodelled_is_more_probable(self) -> bool:
        """Whether something unknown is more probable than the names, though not clearly enough to retract them."""
        return bool(self.steps) and max(self.probabilities, key=self.probabilities.__getitem__, default="") == UNKNOWN

    @property
    def added(self) -> tuple[Step | NoiseHypothesis, ...]:
        """All effects in the model: on the motion and what is read of it as they were found, then those on the noise.

        The latter are re-estimated with every model, from its residual.
        """
        return *self.steps, *(each for each in self.scatter if not self.as_in_reference(each))

    def as_in_reference(self, noise: NoiseHypothesis) -> bool:
        """Return whether healthy records have an effect on the noise of the same size, so that it is nothing new."""
        known = () if self.runs.belief is None else self.runs.belief.noise
        size, error = noise.size
        return any(
            key == noise.key and abs(size - own) <= _SAME_SIZE * abs(own) + _SURELY * float(np.hypot(error, std))
            for key, own, std in known
        )

    @property
    def new_noise(self) -> tuple[NoiseHypothesis, ...]:
        """Hypotheses on the gyro's noise, less those that are nothing new."""
        return tuple(each for each in self.noise_candidates if not self.as_in_reference(each))

    @property
    def unmodelled_beside_steps(self) -> float:
        """Evidence of an unmodelled torque, less what further effects explain beside the first one."""
        first = self.steps[0].screening.odds(self.steps[0].candidate) if self.steps else 0.0
        return self.unmodelled - (self.explained - first)

    def untested(self, screening: Screening | None) -> Mapping[str, float]:
        """Return the evidence of effects for which a channel is missing: that of what was added and looks like them.

        Nothing was compared, so that the data say as much for them as for what is confounded with them.

        Args:
            screening: of the hypotheses that were compared.
        """
        candidates = () if screening is None or accepted(screening) is None else screening.close
        found: dict[str, float] = {}
        for each in self.untestable:
            alike = [other.log_bayes_factor for other in candidates if each.looks_like(other.effect)]
            if each.keeps_share and alike:
                found[each.key] = max(alike)
        return found

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Of none, of every class that is in question, and of something unknown."""
        screening = self.steps[0].screening if self.steps else self.remaining
        on_noise = () if self.steps else self.new_noise
        others = {each.key: each.log_bayes_factor for each in on_noise}
        others |= self.untested(screening)
        probabilities = probabilities_of(screening, self.unmodelled_beside_steps, others)
        if not probabilities or not self.added:
            return probabilities
        first = self.added[0]
        return by_class(probabilities, [first.key, *(each.key for each in first.look_alikes)])
