"""Estimating the inertia from measured records."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from testbed.arrays import Matrix3
from testbed.assembly.description import write_mjcf, write_urdf
from testbed.assembly.platform import Body, nominal_body
from testbed.dynamics.inertia import PARAMETER_NAMES, inertia_of, theta_of
from testbed.errors import InputError
from testbed.estimation.combine import CombinedEstimate
from testbed.experiment.experiment import Estimation
from testbed.identification.identify import Identification, identify
from testbed.identification.result import identification_result
from testbed.library.arguments import AnyPath, Draws, GivenScenario, Seed, Text, checked
from testbed.library.notebook import Shown, parameter_frame
from testbed.library.records import GivenRecords, Records, require_runs, stamps_of
from testbed.library.saving import Saved
from testbed.library.scenarios import naming
from testbed.outputs.estimate_folder import write_estimates
from testbed.outputs.provenance import Provenance, provenance
from testbed.report.frame.blocks import Page
from testbed.report.measured import estimates_page, identification_verdict
from testbed.report.verdict import leading_estimator
from testbed.scenario.body import BodyScenario

if TYPE_CHECKING:
    import arviz
    import pandas as pd

_DRAWS = 4000
"""Of the posterior: quantiles at 2.5 % then scatter by 4 % of a standard deviation, below what a plot shows."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class InertiaEstimate(Shown, Saved):
    """The inertia from measured records.

    Attributes:
        scenario: the nominal model and the estimators.
        records: that were given.
        nominal: the scenario's platform.
        identification: the records that were used, and what they say.
        origin: what made the estimate.
    """

    scenario: BodyScenario
    records: Records
    nominal: Body
    identification: Identification
    origin: Provenance

    @property
    def by_record(self) -> Mapping[str, Estimation]:
        """Estimates of each record, by its name."""
        return self.identification.estimations

    @property
    def combined(self) -> Mapping[str, CombinedEstimate]:
        """The estimates of all records together, by estimator: their average, weighted by their covariances."""
        return self.identification.combined.by_name

    @property
    def verdict(self) -> str:
        """Whether the estimates hold, in a sentence."""
        return identification_verdict(self.identification, theta_of(self.nominal.inertia)).text

    @property
    def result(self) -> dict[str, Any]:
        """What estimates.json holds, without provenance."""
        return identification_result(self.identification, self.scenario, theta_of(self.nominal.inertia))

    def __str__(self) -> str:
        """Return the verdict."""
        names = ", ".join(self.identification.estimations)
        return f"Inertia from {names}, nominal model {self.scenario.name}. {self.verdict}"

    def to_pandas(self) -> pd.DataFrame:
        """Return nominal inertia and combined estimates with their standard deviations: a row a parameter, kg·m²."""
        columns = {"nominal": theta_of(self.nominal.inertia)}
        for name, estimate in self.combined.items():
            columns |= {name: estimate.theta, f"{name}_std": estimate.std}
        return parameter_frame(columns, PARAMETER_NAMES)

    @checked
    def to_arviz(self, *, draws: Draws = _DRAWS, seed: Seed = 0) -> arviz.InferenceData:
        """Return the posterior of the inertia parameters, kg·m², a variable for each estimator.

        With a flat prior and Gaussian errors it is normal about the combined estimate, with its covariance.

        Args:
            draws: how many samples.
            seed: of the samples.

        Raises:
            InputError: an argument is no such number.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)  # once a day it announces its next version
            import arviz as az  # noqa: PLC0415 - an optional extra

        rng = np.random.default_rng(seed)
        samples = {
            name: rng.multivariate_normal(estimate.theta, estimate.total_covariance, size=(1, draws))
            for name, estimate in self.combined.items()
        }
        posterior: arviz.InferenceData = az.from_dict(
            posterior=samples,
            coords={"parameter": list(PARAMETER_NAMES)},
            dims={name: ["parameter"] for name in samples},
        )
        return posterior

    @checked
    def to_mjcf(self, path: AnyPath, *, estimator: Text | None = None) -> Path:
        """Write the nominal platform with the estimated inertia as MJCF, which MuJoCo and a scenario read.

        Args:
            path: of the file; one that is there is replaced.
            estimator: whose combined estimate; by default the leading one of the verdict.

        Raises:
            InputError: there is no such estimate, no body has this inertia, or the file cannot be written.
        """
        return write_mjcf(self.scenario, self._inertia(estimator), Path(path))

    @checked
    def to_urdf(self, path: AnyPath, *, estimator: Text | None = None) -> Path:
        """Write the nominal platform with the estimated inertia as URDF; as `to_mjcf`, without motors.

        A link stands for the bus, each gimbal and each rotor; mass and inertia are those of the whole platform.
        """
        return write_urdf(self.scenario, self._inertia(estimator), Path(path))

    def _inertia(self, estimator: str | None) -> Matrix3:
        name = leading_estimator(self.combined) if estimator is None else estimator
        if name not in self.combined:
            raise InputError(f"there is no estimate by {name}; there are {', '.join(self.combined)}")
        return inertia_of(self.combined[name].theta)

    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the files of an estimate, as in `Saved`."""
        scenario, origin = self.scenario, self.origin.with_command(command)
        write_estimates(folder, scenario.file, origin, scenario, self.nominal, self.identification)
        return ()

    def _page(self) -> Page:
        return estimates_page(self.scenario, self.nominal, self.identification, self.origin.listed, {})


@checked
def estimate(scenario: GivenScenario, records: GivenRecords) -> InertiaEstimate:
    """Estimate the inertia from every record, and from all of them together.

    Args:
        scenario: the nominal model and the estimators.
        records: as from `read_records` or `records_from`.

    Raises:
        InputError: the records cannot be this platform's, or none gives an estimate.

    Example:
        >>> import testbed as tb
        >>> scenario = tb.read_scenario("basic")
        >>> records = tb.Records((tb.fly(scenario).record,))
        >>> list(tb.estimate(scenario, records).combined)
        ['ls', 'iv', 'iv_momentum', 'output_error']
    """
    require_runs("records", records)
    origin = provenance(scenario, scenario.file, "testbed.estimate", data=stamps_of(records))
    with naming(scenario):
        nominal = nominal_body(scenario)
    return InertiaEstimate(
        scenario=scenario,
        records=records,
        nominal=nominal,
        identification=identify(scenario, nominal, records.runs),
        origin=origin,
    )
