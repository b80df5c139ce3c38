"""Whether an effect has one size in all runs: what is missing acts alike in each; what stands in for it does not.

The final model is linearised, and the effect's parameters are freed in every run; all else stays shared, and is
estimated jointly. Of R runs and K parameters, χ² then falls by a χ² of K (R - 1) degrees of freedom if they agree;
where the residual exceeds the noise, it counts in units of the residual variance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from testbed.arrays import Array, Flags, Indices
from testbed.diagnosis.data import Runs
from testbed.diagnosis.findings import hidden_parameters
from testbed.diagnosis.fitting import fitted_initial_rates
from testbed.diagnosis.model import UNDETERMINED, Fit, Hypothesis, orthonormal, projected_out
from testbed.diagnosis.p_values import p_value
from testbed.diagnosis.settings import SETTINGS
from testbed.diagnosis.state import Diagnosis
from testbed.effects.contract import Quantity


@dataclass(frozen=True, kw_only=True, eq=False)
class Agreement:
    """The size of an effect in every run by itself.

    Attributes:
        placed: the effect, which acts in every run.
        runs: names, the fitted ones first.
        heldout: which were held out, shape (R,).
        values: of the parameters in each run, shape (R, K).
        std: their standard errors, shape (R, K); infinite where a run does not show them.
        p_value: of sizes that differ as much, if there is but one.
        hidden: names of parameters that no sample shows, such as those of axes that a bearing holds.
    """

    placed: Hypothesis
    runs: tuple[str, ...]
    heldout: Flags
    values: Array
    std: Array
    p_value: float
    hidden: frozenset[str] = frozenset()

    @property
    def disagrees(self) -> bool:
        """Whether the sizes differ by more than chance."""
        return self.p_value < SETTINGS.disagreement_p_value

    def quantities(self, run: int) -> tuple[Quantity, ...]:
        """Return the effect as one run shows it."""
        every = self.placed.effect.quantities(self.values[run], self.std[run])
        return tuple(quantity for quantity in every if quantity.name not in self.hidden)


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """What one record says of (θ, effects), its initial rates projected out: normal matrix (C, C) and slope (C,)."""

    normal: Array
    slope: Array


def agreements(diagnosis: Diagnosis) -> tuple[Agreement, ...]:
    """Return how the runs agree on every effect that acts in all of them; nothing where there is but one run."""
    model, heldout = diagnosis.model, diagnosis.heldout
    fitted = seen_by_record(diagnosis.runs, model)
    others = {} if heldout is None else seen_by_record(heldout, fitted_initial_rates(heldout, model))
    if not all(each.effect.recurs for each in model.placed) or len(fitted) + len(others) < 2:
        return ()
    names, seen = (*fitted, *others), (*fitted.values(), *others.values())
    held_out = np.arange(len(names)) >= len(fitted)
    return tuple(_agreement(diagnosis, step.placed, names, held_out, seen) for step in diagnosis.steps)


def seen_by_record(runs: Runs, fit: Fit) -> dict[str, Seen]:
    """Return what every record says; windows of one record together."""
    seen: dict[str, Seen] = {}
    common = 6 + len(fit.effect_values)
    for name, rows in zip(runs.windowed or runs.names, rows_of_runs(runs), strict=True):
        jacobian = fit.jacobian[rows]
        own = orthonormal(jacobian[:, common:][:, np.any(jacobian[:, common:] != 0.0, axis=0)])
        columns = projected_out(jacobian[:, :common], own)
        normal, slope = columns.T @ columns, columns.T @ fit.residual[rows]
        before = seen.get(name)
        seen[name] = Seen(
            normal=normal if before is None else before.normal + normal,
            slope=slope if before is None else before.slope + slope,
        )
    return seen


def rows_of_runs(runs: Runs) -> Iterator[Indices]:
    """Yield which of the whitened numbers belong to each run, its gimbals' channels with its gyro's."""
    run_of_block = np.arange(len(runs.measured) + len(runs.inner)) % len(runs.measured)
    sizes = [*runs.sizes, *(block.size for block in runs.inner)]
    run_of_row = np.repeat(run_of_block, sizes)
    for run in range(len(runs.measured)):
        yield np.flatnonzero(run_of_row == run)


def _agreement(
    diagnosis: Diagnosis, placed: Hypothesis, names: Sequence[str], heldout: Flags, seen: Sequence[Seen]
) -> Agreement:
    model = diagnosis.model
    own = np.arange(6 + len(model.effect_values))[6:][model.own(placed)]
    values = model.effect_values[model.own(placed)]
    typical = np.abs([parameter.typical for parameter in placed.effect.parameters])
    size = np.abs(values - [parameter.absent for parameter in placed.effect.parameters])
    loose = SETTINGS.run_by_run_looseness * np.maximum(typical, size)
    change, std, apart = _freed(seen, own, loose)
    _, _, together = _freed(seen, own[:0], typical[:0])
    freed = int(model.shown[own].sum()) or placed.size
    freedom, spread = freed * (len(names) - 1), max(1.0, model.chi_square / model.freedom)
    return Agreement(
        placed=placed,
        runs=tuple(names),
        heldout=heldout,
        values=values + change,
        std=np.where(std > SETTINGS.run_by_run_uninformed * loose, np.inf, std),
        p_value=p_value(max(apart - together, 0.0) / spread, freedom, diagnosis.runs.noise_freedom),
        hidden=hidden_parameters(model, placed),
    )


def _freed(seen: Sequence[Seen], own: Indices, loose: Array) -> tuple[Array, Array, float]:
    """Return the changes of freed parameters in every run and their standard errors, (R, K), and by how much χ² falls.

    Args:
        seen: what every record says.
        own: which of the parameters are freed, shape (K,).
        loose: standard deviations to which they are held, shape (K,).
    """
    count, freed = len(seen[0].slope), len(own)
    shared = np.setdiff1d(np.arange(count), own)
    order, size = np.concatenate([shared, own]), len(shared) + freed * len(seen)
    normal, slope = np.zeros((size, size)), np.zeros(size)
    for run, each in enumerate(seen):
        places = np.concatenate([np.arange(len(shared)), len(shared) + freed * run + np.arange(freed)])
        normal[np.ix_(places, places)] += each.normal[np.ix_(order, order)]
        slope[places] += each.slope[order]
    held = np.arange(len(shared), size)
    normal[held, held] += np.tile(loose**-2.0, len(seen))
    inverse = determined_inverse(normal)
    step, std = inverse @ slope, np.sqrt(np.diag(inverse))
    shape = (len(seen), freed)
    return step[held].reshape(shape), std[held].reshape(shape), float(slope @ step)


def determined_inverse(normal: Array) -> Array:
    """Return the inverse of a normal matrix where it is determined, zero elsewhere."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), np.finfo(float).tiny))
    scaled = np.linalg.pinv(normal * np.outer(scale, scale), rcond=UNDETERMINED, hermitian=True)
    return np.asarray(scaled * np.outer(scale, scale))
