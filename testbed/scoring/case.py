"""Cases read from two folders: what was hidden, and what a diagnosis said of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from testbed.errors import InputError
from testbed.files import read_bytes, read_text, stamped
from testbed.scoring.formats import AnswerFile, DiagnosisFile

ANSWER, DIAGNOSIS, SEAL = "answer.json", "diagnosis.json", "sealed.sha256"
_CASES = "case_*"
_LARGEST, _LARGEST_SEAL = 100_000_000, 1000
"""Bytes; a diagnosis of fifty runs takes 2 MB, a seal 64 digits."""

_File = TypeVar("_File", bound=BaseModel)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One data set.

    Attributes:
        name: of its folder.
        answer: what was hidden.
        diagnosis: what was said of it; None where nothing was, which counts as a miss everywhere.
        failure: why there is no diagnosis.
        sealed: whether the answer was held against the hash in the data folder.
    """

    name: str
    answer: AnswerFile
    diagnosis: DiagnosisFile | None
    failure: str = ""
    sealed: bool = False


def read_cases(diagnoses: Path, answers: Path) -> tuple[Case, ...]:
    """Read DIAGNOSES/case_*/diagnosis.json and ANSWERS/case_*/answer.json, or one case whose files lie in the folders.

    Args:
        diagnoses: what was said.
        answers: what was hidden; where a folder `data` lies beside either, its seals are checked.

    Raises:
        InputError: there are no answers, one cannot be read, or one is not what was sealed.
    """
    cases = tuple(_read_case(diagnoses, answers, name) for name in _names(answers))
    if not cases:
        raise InputError(f"{answers}: holds no {_CASES}/{ANSWER} and no {ANSWER}: name the folder of the answers")
    if all(case.diagnosis is None for case in cases):
        raise InputError(f"{diagnoses}: holds no diagnosis of any case: {cases[0].failure}")
    return cases


def _names(answers: Path) -> Iterator[str]:
    if (answers / ANSWER).exists():
        yield "."
    yield from sorted(path.parent.name for path in answers.glob(f"{_CASES}/{ANSWER}"))


def _read_case(diagnoses: Path, answers: Path, name: str) -> Case:
    path = answers / name / ANSWER
    sealed = _checked_seal(path, [place.parent / "data" / name / SEAL for place in (answers, diagnoses)])
    answer = _read(path, AnswerFile)
    try:
        diagnosis = _read(diagnoses / name / DIAGNOSIS, DiagnosisFile)
    except InputError as error:
        return Case(name=name, answer=answer, diagnosis=None, failure=str(error), sealed=sealed)
    if not diagnosis.complete:
        return Case(name=name, answer=answer, diagnosis=None, failure="the diagnosis is not complete", sealed=sealed)
    return Case(name=name, answer=answer, diagnosis=diagnosis, sealed=sealed)


def _checked_seal(answer: Path, seals: list[Path]) -> bool:
    """Return whether there is a seal.

    Raises:
        InputError: the answer is not the one that was sealed.
    """
    found = next((seal for seal in seals if seal.exists()), None)
    if found is None:
        return False
    if stamped(answer, "an answer").sha256 != read_text(found, "a seal", _LARGEST_SEAL).text.strip():
        raise InputError(f"{answer}: is not the answer that {found} was made for: it was changed, or is of another set")
    return True


def _read(path: Path, kind: type[_File]) -> _File:
    try:
        return kind.model_validate_json(read_bytes(path, "a diagnosis or an answer", _LARGEST))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(each) for each in first["loc"])
        raise InputError(f"{path}: {place or 'the file'}: {first['msg']}") from error
