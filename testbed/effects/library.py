"""The user's own library: formulas of earlier diagnoses as effects, kept as data and never as code."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import tomli_w
from pydantic import BaseModel, ConfigDict, ValidationError

from testbed.effects.formula import Formula
from testbed.errors import InputError, OutputError
from testbed.files import parsed_toml, read_text, whole_file
from testbed.formulas.pattern import pattern_of

FOLDER_VARIABLE = "TESTBED_EFFECTS"
"""Environment variable that names another folder than the usual one."""
_NAME = re.compile(r"[a-z][a-z0-9_]{1,39}")
_LARGEST = 100_000
"""Bytes of a kept effect; one has 300."""


class KeptFormula(BaseModel):
    """A file of the library.

    Attributes:
        name: id under which diagnoses know it.
        formula: what the torque follows, and where it points.
        constants: values from which the formula's constants are searched, SI.
        sizes: size of each law's coefficient as it was found, SI; typical of it from then on.
        mean_inertia_kg_m2: mean moment of inertia of the platform that it was found on.
        source: the diagnosis.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str
    formula: str
    constants: tuple[float, ...] = ()
    sizes: tuple[float, ...]
    mean_inertia_kg_m2: float
    source: str = ""

    @property
    def effect(self) -> Formula:
        """The effect.

        Raises:
            InputError: the formula is none, or numbers are missing.
        """
        pattern = pattern_of(self.formula)
        if len(self.sizes) != len(pattern.laws) or not all(size > 0.0 for size in self.sizes):
            raise InputError(f"sizes: give {len(pattern.laws)} numbers above zero, one for each law")
        if len(self.constants) != len(pattern.names):
            raise InputError(f"constants: give {len(pattern.names)}, of {', '.join(pattern.names) or 'none'}")
        if not self.mean_inertia_kg_m2 > 0.0:
            raise InputError("mean_inertia_kg_m2: give a number above zero")
        return Formula.of_size(
            pattern,
            sizes=np.array(self.sizes),
            moment=self.mean_inertia_kg_m2,
            start=np.array(self.constants),
            name=self.name,
        )


def library_folder() -> Path:
    """Return the folder of the user's own effects; it need not be there."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named) if named else Path.home() / ".config" / "testbed" / "effects"


def kept_effects() -> Mapping[Path, Formula]:
    """Return the effects of the user's library by their files, in the order of these.

    Raises:
        InputError: as `kept_formulas`.
    """
    return {path: kept.effect for path, kept in kept_formulas().items()}


def kept_formulas() -> Mapping[Path, KeptFormula]:
    """Return the files of the user's library and what they hold, in their order.

    Raises:
        InputError: there is a file in the place of the folder, one of its files cannot be used, or two hold effects of
            one name; the message names them.
    """
    folder = library_folder()
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is no folder, and your own effects are kept in one; name it in {FOLDER_VARIABLE}")
    held: dict[Path, KeptFormula] = {}
    for path in sorted(folder.glob("*.toml")):
        kept = _read(path)
        for other, known in held.items():
            if known.name == kept.name:
                raise InputError(
                    f"{other} and {path}: both are called {kept.name}; change name in one, or take it away"
                )
        held[path] = kept
    return held


def keep(kept: KeptFormula, taken: Sequence[str]) -> Path:
    """Write an effect to the user's library, and return its file.

    Args:
        kept: the effect.
        taken: ids that diagnoses know already.

    Raises:
        InputError: the name is none, or is taken, or the same law is kept by another name: no data distinguish the two.
        OutputError: the file cannot be written.
    """
    if not _NAME.fullmatch(kept.name):
        raise InputError(
            f"{kept.name!r}: a name has 2 to 40 small letters, digits and _, a letter first; choose another"
        )
    path = library_folder() / f"{kept.name}.toml"
    if kept.name in taken or path.exists():
        raise InputError(f"{kept.name}: an effect of this name is there already; choose another name")
    for other, known in kept_formulas().items():
        if known.formula == kept.formula:
            raise InputError(
                f"{kept.name}: the same law, {kept.formula}, is kept in {other}: diagnoses could "
                "not distinguish the two"
            )
    kept.effect.hooks("platform")  # it can be used as it is written
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            part.write_text(tomli_w.dumps(kept.model_dump(mode="json")), encoding="utf-8")
    except OSError as error:
        raise OutputError(
            f"{path}: cannot be written ({error.strerror}); name another folder in {FOLDER_VARIABLE}"
        ) from error
    return path


def _read(path: Path) -> KeptFormula:
    tree = parsed_toml(read_text(path, "an effect", _LARGEST))
    try:
        kept = KeptFormula.model_validate(tree)
        kept.effect.hooks("platform")
    except (ValidationError, InputError) as error:
        said = _listed(error) if isinstance(error, ValidationError) else str(error)
        raise InputError(f"{path}: is no effect of `testbed effects save`: {said}; mend it or take it away") from error
    return kept


def _listed(error: ValidationError) -> str:
    return "; ".join(f"{'.'.join(map(str, each['loc']))}: {each['msg']}" for each in error.errors())
