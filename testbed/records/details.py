"""NAME.toml: what is known of a run as a whole, read and written."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError, model_validator
from pydantic_core import ErrorDetails

from testbed.errors import InputError
from testbed.files import TextFile, parsed_toml, read_text, readable
from testbed.quantities import RateNoise
from testbed.records.checks import listing
from testbed.records.record import RunDetails

_LARGEST = 100_000
"""Bytes of NAME.toml; its seven keys take a few hundred."""
_Seconds = Annotated[float, Field(allow_inf_nan=False)]


class _DetailsFile(BaseModel):
    """The keys of NAME.toml, each optional."""

    model_config = ConfigDict(extra="forbid", strict=True, validate_by_name=True, validate_by_alias=True)

    name: str | None = Field(default=None, min_length=1)
    source: Literal["measured", "simulated"] = "measured"
    gyro_noise: RateNoise | None = Field(default=None, alias="gyro_noise_rad_s")
    usable_from: _Seconds | None = Field(default=None, alias="usable_from_s")
    usable_to: _Seconds | None = Field(default=None, alias="usable_to_s")
    role: Literal["fit", "heldout"] | None = None
    axes: Annotated[tuple[Literal["x", "y", "z"], ...], Strict(False), Field(min_length=1)] | None = None

    @model_validator(mode="after")
    def _usable_span_is_ordered(self) -> Self:
        if self.usable_from is not None and self.usable_to is not None and self.usable_from >= self.usable_to:
            raise ValueError("usable_from_s has to be smaller than usable_to_s")
        return self


def read_details(path: Path) -> RunDetails:
    """Read NAME.toml; a run without one has its file's name and nothing else.

    Raises:
        InputError: the file cannot be read, or has unknown keys or wrong values; the message lists them all.
    """
    file = details_file(path)
    return RunDetails(name=readable(path.stem)) if file is None else details_of(file)


def details_file(path: Path) -> TextFile | None:
    """Return NAME.toml as it is; None where a run has none.

    Raises:
        InputError: it cannot be read.
    """
    return read_text(path, "what is known of a run", _LARGEST) if path.exists() else None


def details_of(file: TextFile) -> RunDetails:
    """Return what NAME.toml says.

    Raises:
        InputError: it is not TOML, or has unknown keys or wrong values; the message lists them all.
    """
    return stated_details(file.path, parsed_toml(file))


def stated_details(path: Path, keys: Mapping[str, Any]) -> RunDetails:
    """Return what the keys of a NAME.toml say, whoever states them.

    Args:
        path: that stands before what is wrong; its stem is the run's name where no key gives one.
        keys: with their values.

    Raises:
        InputError: there are unknown keys or wrong values; the message lists them all.
    """
    try:
        said = _DetailsFile.model_validate(keys, by_name=False)
    except ValidationError as error:
        raise InputError(listing(path, [_problem(problem) for problem in error.errors()])) from error
    return RunDetails(**{"name": readable(path.stem), **said.model_dump(exclude_none=True)})


def details_text(details: RunDetails, stem: str) -> str:
    """Return the text of NAME.toml, empty where there is nothing to say that a reader would not assume.

    Args:
        details: of the run.
        stem: NAME.
    """
    said = details_keys(details).items()
    return "".join(f"{key} = {_toml(value)}\n" for key, value in said if (key, value) != ("name", stem))


def details_keys(details: RunDetails) -> dict[str, Any]:
    """Return the keys of NAME.toml, less those that say what a reader would assume."""
    return _DetailsFile.model_validate(asdict(details)).model_dump(by_alias=True, exclude_defaults=True)


def _problem(error: ErrorDetails) -> str:
    place = ".".join(str(part) for part in error["loc"])
    if error["type"] == "extra_forbidden":
        known = ", ".join(field.alias or name for name, field in _DetailsFile.model_fields.items())
        return f"{place}: unknown key; known are {known}"
    if not place:
        return str(error["ctx"]["error"])
    return f"{place} = {error['input']!r}: {error['msg'].lower()}"


def _toml(value: str | float | Sequence[str]) -> str:
    if not isinstance(value, str | float | int):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")  # JSON leaves DEL, TOML refuses it
    return repr(float(value))
