"""Results of several runs, or of several campaigns, side by side."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from testbed.arrays import Theta
from testbed.dynamics.inertia import PARAMETER_NAMES
from testbed.errors import InputError, words_of
from testbed.files import FileStamp, read_text, readable, require_folder
from testbed.formats.campaign import CampaignResult
from testbed.formats.parts import Part, first_fault
from testbed.formats.run import RunResult
from testbed.library.arguments import AnyPath, AnyPaths, checked
from testbed.library.notebook import Shown
from testbed.library.saving import Saved
from testbed.outputs.comparison_folder import write_comparison
from testbed.outputs.provenance import provenance_of_files
from testbed.report.comparison import ComparedFigures, comparison_page
from testbed.report.frame.blocks import Page

if TYPE_CHECKING:
    import pandas as pd

_LARGEST = 100_000_000
"""Bytes of a result; that of a million runs with a thousand failures takes 1 MB."""
_RESULTS: Mapping[str, Literal["run", "campaign"]] = {"result.json": "run", "montecarlo.json": "campaign"}
_FORMS: Mapping[str, type[Part]] = {"run": RunResult, "campaign": CampaignResult}
_FEWEST = 2


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Comparison(Shown, Saved):
    """Runs or campaigns side by side.

    Attributes:
        kind: which of them.
        results: what the JSON file of each folder holds, by the folder's name.
        figures: of each estimator, a row for each result.
        inputs: the JSON files, as they were read.
    """

    kind: Literal["run", "campaign"]
    results: Mapping[str, Mapping[str, Any]]
    figures: tuple[ComparedFigures, ...]
    inputs: tuple[FileStamp, ...]

    def __str__(self) -> str:
        """Return what is compared."""
        estimators = list(dict.fromkeys(each.estimator for each in self.figures))
        return f"{len(self.results)} {self.kind}s compared: {', '.join(self.results)}; {', '.join(estimators)}."

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each result, estimator and figure, a column for each inertia parameter, SI."""
        import pandas as pd  # noqa: PLC0415 - an optional extra

        rows = {
            (each.estimator, each.figure, name): theta for each in self.figures for name, theta in each.rows.items()
        }
        frame = pd.DataFrame.from_dict(rows, orient="index", columns=list(PARAMETER_NAMES))
        frame.index = pd.MultiIndex.from_tuples(rows, names=["estimator", "figure", "result"])
        return frame

    def write(self, folder: Path, command: str) -> tuple[str, ...]:
        """Write the files of a comparison, as in `Saved`."""
        origin = provenance_of_files("comparison", self.inputs, command)
        write_comparison(folder, origin, self.kind, self.results, self.figures)
        return ()

    def _page(self) -> Page:
        return comparison_page(self.kind, self.results, self.figures)


@checked
def compare(folders: AnyPaths) -> Comparison:
    """Compare the results of runs, or of campaigns.

    Args:
        folders: two or more run folders, or two or more campaign folders.

    Raises:
        InputError: a folder holds no result, or runs are mixed with campaigns.

    Example:
        >>> import tempfile, testbed as tb
        >>> with tempfile.TemporaryDirectory() as place:
        ...     runs = [tb.fly(tb.read_scenario("basic"), seed=seed).save(f"{place}/{seed}") for seed in (1, 2)]
        ...     print(tb.compare(runs))
        2 runs compared: 1, 2; ls, iv, iv_momentum, output_error.
    """
    if len(folders) < _FEWEST:
        raise InputError("a comparison takes two folders or more")
    found = [_read(Path(folder)) for folder in folders]
    kinds = {kind for kind, _, _ in found}
    if len(kinds) > 1:
        raise InputError("runs and campaigns cannot be compared with each other: name folders of one kind")
    kind = kinds.pop()
    results = dict(zip(_distinct_names(folders), (content for _, content, _ in found), strict=True))
    figures = tuple(_run_figures(results) if kind == "run" else _campaign_figures(results))
    return Comparison(kind=kind, results=results, figures=figures, inputs=tuple(stamp for _, _, stamp in found))


def _read(folder: Path) -> tuple[Literal["run", "campaign"], Mapping[str, Any], FileStamp]:
    require_folder(folder)
    for name, kind in _RESULTS.items():
        path = folder / name
        if path.is_file():
            file = read_text(path, f"the result of a {kind}", _LARGEST)
            try:
                content = json.loads(file.text)
                fault = first_fault(_FORMS[kind], content)
                if fault is None:
                    _require_compared(content, kind)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
                fault = words_of(error)
            if fault:
                raise InputError(f"{path}: is not as testbed wrote it ({fault}); run that command again")
            return kind, content, file.stamp
    raise InputError(f"{folder}: holds neither {' nor '.join(_RESULTS)}: name the folder of a run or of a campaign")


def _require_compared(content: Mapping[str, Any], kind: Literal["run", "campaign"]) -> None:
    """Look up all that is compared.

    Raises:
        KeyError: it is not there.
    """
    for each in content["estimates"].values():
        for key in ("theta_kg_m2", "std_kg_m2") if kind == "run" else ("mean_kg_m2", "std_kg_m2", *_CAMPAIGN_FIGURES):
            each[key]
    if kind == "run":
        content["truth"]["theta_kg_m2"]


def _distinct_names(folders: Sequence[AnyPath]) -> list[str]:
    """Return the folders' last names where these differ, else all of their paths."""
    names = [readable(Path(folder).resolve().name) for folder in folders]
    if len(set(names)) == len(names):
        return names
    return [f"{number}: {readable(str(folder))}" for number, folder in enumerate(folders, start=1)]


def _run_figures(results: Mapping[str, Mapping[str, Any]]) -> Iterator[ComparedFigures]:
    for estimator in _estimators(results):
        given = {name: each["estimates"][estimator] for name, each in results.items() if estimator in each["estimates"]}
        yield ComparedFigures(
            estimator=estimator,
            figure="estimate",
            rows={name: _theta(each["theta_kg_m2"]) for name, each in given.items()},
            stds={name: _theta(each["std_kg_m2"]) for name, each in given.items()},
        )
        yield ComparedFigures(
            estimator=estimator,
            figure="error in stated standard deviations",
            rows={
                name: (_theta(each["theta_kg_m2"]) - _theta(results[name]["truth"]["theta_kg_m2"]))
                / _theta(each["std_kg_m2"])
                for name, each in given.items()
            },
        )


_CAMPAIGN_FIGURES = {
    "scatter_over_bound": "scatter over the Cramér-Rao bound",
    "bias_in_standard_errors": "bias in standard errors",
    "coverage_95": "share of 95 % intervals that hold the truth",
}


def _campaign_figures(results: Mapping[str, Mapping[str, Any]]) -> Iterator[ComparedFigures]:
    for estimator in _estimators(results):
        given = {name: each["estimates"][estimator] for name, each in results.items() if estimator in each["estimates"]}
        yield ComparedFigures(
            estimator=estimator,
            figure="mean",
            rows={name: _theta(each["mean_kg_m2"]) for name, each in given.items()},
            stds={name: _theta(each["std_kg_m2"]) for name, each in given.items()},
        )
        for key, figure in _CAMPAIGN_FIGURES.items():
            yield ComparedFigures(
                estimator=estimator, figure=figure, rows={name: _theta(each[key]) for name, each in given.items()}
            )


def _estimators(results: Mapping[str, Mapping[str, Any]]) -> list[str]:
    return list(dict.fromkeys(estimator for each in results.values() for estimator in each["estimates"]))


def _theta(values: Sequence[float | None]) -> Theta:
    return np.array([np.nan if value is None else value for value in values])
