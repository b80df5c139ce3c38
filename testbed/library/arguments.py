"""Arguments of the public functions: what their annotations ask for, checked by pydantic before anything is done.

Of what does not fit, the user reads which argument it is, what was given and what to give.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cache, wraps
from os import PathLike
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, Literal, ParamSpec, TypeVar, get_type_hints

import numpy as np
from pydantic import BeforeValidator, Field, GetPydanticSchema, Strict, TypeAdapter, ValidationError, WrapValidator
from pydantic_core import PydanticCustomError, core_schema

from testbed.errors import InputError, OwnEffectError
from testbed.limits import LARGEST_SEED, MOST_RUNS, MOST_WORKERS
from testbed.scenario.body import BodyScenario

_P = ParamSpec("_P")
_R = TypeVar("_R")

_LONGEST_SHOWN = 60
_SHOWN = (str, int, float, complex, bytes, PathLike, list, tuple, dict, set, np.generic, type(None))
"""Types of which a message shows the value; of others, such as tables, the name of the type says more."""


def give(words: str) -> WrapValidator:
    """Return what has a message say what to give in place of what does not fit an annotation.

    Args:
        words: what to give.
    """

    def check(value: object, handler: Callable[[object], object]) -> object:
        try:
            return handler(value)
        except ValidationError as error:
            raise PydanticCustomError("argument", "give {words}", {"words": words}) from error

    return WrapValidator(check)


def _plain(value: object) -> object:
    """Return a number of NumPy as Python's own."""
    return value.item() if isinstance(value, np.generic) else value


def _one_is_a_list(value: object) -> object:
    """Return a single text, or path, as a list of it: its letters are no items."""
    return (value,) if isinstance(value, str | PathLike) else value


AN_INSTANCE = GetPydanticSchema(lambda source, _: core_schema.is_instance_schema(source))
"""Lets only objects of the annotated class pass, and these as they are."""
UNCHECKED = GetPydanticSchema(lambda _, __: core_schema.any_schema())
"""Lets all pass: the function itself tells what it is."""
_A_PATH = GetPydanticSchema(lambda _, __: core_schema.is_instance_schema((str, PathLike)))

Switch = Annotated[bool, Strict(), give("True or False")]
Text = Annotated[str, Strict(), give("a text")]
Texts = Annotated[Sequence[Text], BeforeValidator(_one_is_a_list), give("texts, such as ['panel_drive']")]
AnyPath = Annotated[str | Path, _A_PATH, give("a path, as a text or a pathlib.Path")]
AnyPaths = Annotated[Sequence[AnyPath], BeforeValidator(_one_is_a_list), give("folders, such as ['runs/a', 'runs/b']")]
Whole = Annotated[int, BeforeValidator(_plain), Strict(), give("a whole number")]
Number = Annotated[float, BeforeValidator(_plain), Strict(), give("a number")]
Seed = Annotated[Whole, Field(ge=0, le=LARGEST_SEED), give("a whole number from 0 to 2**63 - 1")]
Draws = Annotated[Whole, Field(ge=1), give("a whole number, 1 or more")]
Runs = Annotated[
    Whole, Field(ge=2, le=MOST_RUNS), give(f"a whole number from 2, as one run has no scatter, to {MOST_RUNS:,}")
]
Checks = Annotated[Whole, Field(ge=0, le=MOST_RUNS), give(f"a whole number from 1 to {MOST_RUNS:,}, or 0 for none")]
Workers = Annotated[Whole, Field(ge=1, le=MOST_WORKERS), give(f"a whole number from 1 to {MOST_WORKERS:,}")]
Format = Annotated[Literal["parquet", "mcap"], give("'parquet' or 'mcap'")]
Overrides = Annotated[
    Mapping[Annotated[str, Strict()], object],
    give("values by dotted key, such as {'gyro.noise_rad_s': 0.01}"),
]
GivenScenario = Annotated[
    BodyScenario, AN_INSTANCE, give('a scenario, not a text or a path: tb.read_scenario("basic") reads one')
]


def checked(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Have the arguments of a function checked against its annotations before it is called.

    Args:
        function: whose parameters pydantic can check; one without annotation, such as self, is passed on.

    Returns:
        The function; what it is called with is as its annotations say, or it raises an InputError.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        given = signature.bind(*args, **kwargs)
        known = _adapters(function)  # at the first call: the import of the library builds none
        for name, value in given.arguments.items():
            if name in known:
                given.arguments[name] = fitting(name, value, known[name])
        try:
            return function(*given.args, **given.kwargs)
        except OwnEffectError as error:
            raise InputError(str(error)) from error

    return call


def fitting(name: str, value: object, adapter: TypeAdapter[_R]) -> _R:
    """Return a value as an annotation asks for it.

    Args:
        name: of the argument.
        value: of it.
        adapter: of the annotation.

    Raises:
        InputError: it does not fit; the message says what to give.
    """
    try:
        return adapter.validate_python(value)
    except ValidationError as error:
        what = error.errors(include_url=False)[0]["msg"].removeprefix("Input ")
        raise InputError(f"{name} = {_shown(value)}: {what}") from None


@cache
def _adapters(function: Callable[..., object]) -> Mapping[str, TypeAdapter[Any]]:
    # Without what it returns: such types may be imported for a type checker only.
    annotations = {name: each for name, each in function.__annotations__.items() if name != "return"}
    hints = get_type_hints(
        SimpleNamespace(__annotations__=annotations),
        globalns=inspect.unwrap(function).__globals__,
        include_extras=True,
    )
    return {name: TypeAdapter(hint) for name, hint in hints.items()}


def _shown(value: object) -> str:
    if not isinstance(value, _SHOWN):
        return f"<{type(value).__name__}>"
    try:
        text = repr(value)
    except ValueError:  # Python writes no integer of more than 4,300 digits
        return "an integer of thousands of digits"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}..."
