"""Records as other people's loggers write them, and as no logger does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from support.diagnosed_records import SCENARIO, records
from testbed.records.writing import write_record
from tests.robustness.case import ANY, COMPLETED, REFUSED, Case

Columns: TypeAlias = dict[str, np.ndarray]

RATES = tuple(f"body_rate_{axis}_rad_s" for axis in "xyz")
ANGLES = tuple(f"gimbal_angle_{unit}_rad" for unit in range(1, 7))
ESTIMATE = (("estimate", str(SCENARIO), "--data", "data", "--out", "out"),)
DIAGNOSE = (("diagnose", str(SCENARIO), "--data", "data", "--out", "out"),)


def cases() -> Iterator[Case]:
    """Give a case for every way in which a record can be wrong."""
    yield from _columns()
    yield from _texts()
    yield from _bytes()
    yield from _details()
    yield from _folders()


def good_records(folder: Path) -> None:
    """Write two runs that nothing is wrong with."""
    for record in records(2, seconds=4.0):
        write_record(record, folder / f"{record.details.name}.csv")


@cache
def good_table() -> Columns:
    """Return a good run of 4 s, by column."""
    record = records(1, seconds=4.0)[0]
    rates = dict(zip(RATES, record.channels["body_rate"].T, strict=True))
    return {"time_s": record.time} | rates | dict(zip(ANGLES, record.channels["gimbal_angle"].T, strict=True))


def as_csv(columns: Columns) -> bytes:
    """Return a table as a CSV file."""
    out = BytesIO()
    pyarrow.csv.write_csv(pa.table(dict(columns)), out)
    return out.getvalue()


def as_parquet(columns: Columns) -> bytes:
    """Return a table as a Parquet file."""
    out = BytesIO()
    pyarrow.parquet.write_table(pa.table(dict(columns)), out)
    return out.getvalue()


def _filled(content: Callable[[], dict[str, bytes]]) -> Callable[[Path], None]:
    """Return what fills data/; made when the case runs, as a good run takes a second to make."""

    def prepare(folder: Path) -> None:
        (folder / "data").mkdir()
        for name, written in content().items():
            (folder / "data" / name).write_bytes(written)

    return prepare


def _columns() -> Iterator[Case]:
    """Numbers that are wrong: each as CSV for `estimate`, the gravest as Parquet for `diagnose`."""
    for name, (change, codes, says) in _CHANGES.items():
        for suffix, written, commands in (("csv", as_csv, ESTIMATE), ("parquet", as_parquet, DIAGNOSE)):
            if suffix == "parquet" and COMPLETED in codes:
                continue  # a diagnosis that runs through takes a minute, and has tests of its own
            yield Case(
                name=f"records: {name} ({suffix})",
                prepare=_filled(
                    lambda change=change, suffix=suffix, written=written: {
                        f"{number}.{suffix}": written(change(dict(good_table()))) for number in (1, 2)
                    }
                ),
                commands=commands,
                codes=codes,
                says=says,
                fast=suffix == "csv" and name in _FAST,
            )


def _scaled(names: tuple[str, ...], factor: float) -> Callable[[Columns], Columns]:
    return lambda columns: columns | {name: factor * columns[name] for name in names}


def _with(name: str, row: int, value: float) -> Callable[[Columns], Columns]:
    def change(columns: Columns) -> Columns:
        changed = columns[name].copy()
        changed[row] = value
        return columns | {name: changed}

    return change


def _all(name: str, value: float) -> Callable[[Columns], Columns]:
    return lambda columns: columns | {name: np.full_like(columns[name], value)}


def _rows(choose: Callable[[Columns], object]) -> Callable[[Columns], Columns]:
    return lambda columns: {name: values[choose(columns)] for name, values in columns.items()}


def _without(*names: str) -> Callable[[Columns], Columns]:
    return lambda columns: {name: values for name, values in columns.items() if name not in names}


def _renamed(old: str, new: str) -> Callable[[Columns], Columns]:
    return lambda columns: {new if name == old else name: values for name, values in columns.items()}


_CHANGES: dict[str, tuple[Callable[[Columns], Columns], tuple[int, ...], tuple[str, ...]]] = {
    "time in ms": (_scaled(("time_s",), 1e3), (REFUSED,), ("divide it by 1e3",)),
    "time in us": (_scaled(("time_s",), 1e6), (REFUSED,), ("1e6 (us)",)),
    "time in hours": (_scaled(("time_s",), 1 / 3600), (REFUSED,), ("multiply it by 3600",)),
    "time since 1970": (lambda columns: columns | {"time_s": columns["time_s"] + 1.8e9}, ANY, ()),
    "time backwards": (_scaled(("time_s",), -1.0), (REFUSED,), ("time_s",)),
    "time stands still": (_all("time_s", 1.0), (REFUSED,), ("time_s",)),
    "time has a jump back": (_with("time_s", 20, 0.1), (REFUSED,), ("time_s",)),
    "time has a gap": (_rows(lambda columns: np.r_[:20, 40 : len(columns["time_s"])]), ANY, ()),
    "time is NaN once": (_with("time_s", 7, np.nan), (REFUSED,), ("time_s",)),
    "time is infinite": (_with("time_s", -1, np.inf), (REFUSED,), ("time_s",)),
    "time 1e300": (_scaled(("time_s",), 1e300), (REFUSED,), ("time_s",)),
    "time 1e-300": (_scaled(("time_s",), 1e-300), (REFUSED,), ("time_s",)),
    "rates in deg/s": (_scaled(RATES, 57.29578), (REFUSED,), ("deg/s",)),
    "rates in mrad/s": (_scaled(RATES, 1e3), (REFUSED,), ("body_rate", "gyro")),
    "rates 1e300": (_scaled(RATES, 1e300), (REFUSED,), ("body_rate",)),
    "rates 1e-300": (_scaled(RATES, 1e-300), (REFUSED,), ()),
    "rates negated": (_scaled(RATES, -1.0), (REFUSED,), ("sign",)),
    "rates are zero": (_scaled(RATES, 0.0), (REFUSED,), ("determined",)),
    "rates are constant": (lambda columns: columns | dict.fromkeys(RATES, np.full(65, 0.1)), (REFUSED,), ()),
    "rates are NaN": (_scaled(RATES, np.nan), (REFUSED,), ("body_rate",)),
    "one rate infinite": (_with(RATES[1], 9, np.inf), (REFUSED,), ("body_rate",)),
    "one axis NaN for a while": (_with(RATES[2], 11, np.nan), ANY, ()),
    "a spike of 5 rad/s": (_with(RATES[0], 30, 5.0), (COMPLETED,), ("spike", "left out")),
    "a spike of 1e6 rad/s": (_with(RATES[0], 30, 1e6), (REFUSED,), ("body_rate",)),
    "axes exchanged": (
        lambda columns: columns | {RATES[0]: columns[RATES[1]], RATES[1]: columns[RATES[0]]},
        ANY,
        (),
    ),
    "angles in degrees": (_scaled(ANGLES, 57.29578), (REFUSED,), ("degree", "deg", "momentum")),
    "angles negated": (_scaled(ANGLES, -1.0), (REFUSED,), ("sign", "momentum")),
    "angles are zero": (_scaled(ANGLES, 0.0), (REFUSED,), ()),
    "angles 1e300": (_scaled(ANGLES, 1e300), (REFUSED,), ()),
    "one angle infinite": (_with(ANGLES[3], 5, -np.inf), (REFUSED,), ("gimbal_angle",)),
    "one angle NaN": (_with(ANGLES[3], 5, np.nan), ANY, ()),
    "one angle turns once more": (_with(ANGLES[3], 40, 2 * np.pi), ANY, ()),
    "rotor speed in rpm": (
        lambda columns: columns | {f"rotor_speed_{unit}_rad_s": np.full(65, 471.4 * 9.5493) for unit in range(1, 7)},
        (REFUSED,),
        ("rpm", "rotor"),
    ),
    "one rotor speed of six": (
        lambda columns: columns | {"rotor_speed_1_rad_s": np.full(65, 471.4)},
        (REFUSED,),
        ("rotor_speed",),
    ),
    "no rows": (_rows(lambda _: slice(0, 0)), (REFUSED,), ()),
    "one row": (_rows(lambda _: slice(0, 1)), (REFUSED,), ()),
    "nine rows": (_rows(lambda _: slice(0, 9)), (REFUSED,), ()),
    "every row twice": (
        _rows(lambda columns: np.repeat(np.arange(len(columns["time_s"])), 2)),
        (REFUSED,),
        ("time_s",),
    ),
    "rows shuffled": (
        _rows(lambda columns: np.random.default_rng(3).permutation(len(columns["time_s"]))),
        (REFUSED,),
        ("time_s",),
    ),
    "no time": (_without("time_s"), (REFUSED,), ("time_s",)),
    "no rates": (_without(*RATES), (REFUSED,), ("body_rate",)),
    "one rate missing": (_without(RATES[1]), (REFUSED,), ("body_rate_y",)),
    "no actuators": (_without(*ANGLES), (REFUSED,), ("gimbal_angle",)),
    "one angle missing": (_without(ANGLES[5]), (REFUSED,), ("gimbal_angle_6",)),
    "rates called otherwise": (_renamed(RATES[0], "wx"), (REFUSED,), ("body_rate_x",)),
    "unit of rates in the name": (_renamed(RATES[0], "body_rate_x_deg_s"), (REFUSED,), ("body_rate_x",)),
    "name in capitals": (_renamed("time_s", "Time_s"), (REFUSED,), ("time_s",)),
    "name with a space": (_renamed("time_s", " time_s"), ANY, ()),
    "another column": (lambda columns: columns | {"temperature_K": np.full(65, 290.0)}, (COMPLETED,), ()),
    "another column of text": (lambda columns: columns | {"mode": np.array(["[red]on[/]"] * 65)}, (COMPLETED,), ()),
    "time as text": (lambda columns: columns | {"time_s": columns["time_s"].astype(str)}, ANY, ()),
    "rates as words": (lambda columns: columns | {RATES[0]: np.array(["fast"] * 65)}, (REFUSED,), ("body_rate_x",)),
    "angles as yes and no": (
        lambda columns: columns | {ANGLES[0]: np.arange(65) % 2 == 0},
        (REFUSED,),
        ("gimbal_angle_1",),
    ),
    "rates as whole numbers": (lambda columns: columns | {RATES[0]: np.arange(65)}, (REFUSED,), ()),
    "rates in single precision": (
        lambda columns: {name: values.astype(np.float32) for name, values in columns.items()},
        (COMPLETED,),
        (),
    ),
}
_FAST = {"time in ms", "rates in deg/s", "a spike of 5 rad/s", "rotor speed in rpm", "no rows", "rates as words"}


def _texts() -> Iterator[Case]:
    """CSV as programs and countries write it."""
    changes: dict[str, tuple[Callable[[str], str | bytes], tuple[int, ...], tuple[str, ...]]] = {
        "semicolons": (lambda text: text.replace(",", ";"), (REFUSED,), ("semicolon", ";")),
        "semicolons and decimal commas": (
            lambda text: text.replace(",", ";").replace(".", ","),
            (REFUSED,),
            ("semicolon", ";"),
        ),
        "tabs": (lambda text: text.replace(",", "\t"), (REFUSED,), ("tab", "comma")),
        "carriage returns": (lambda text: text.replace("\n", "\r\n"), (COMPLETED,), ()),
        "old carriage returns": (lambda text: text.replace("\n", "\r"), ANY, ()),
        "no line end": (str.rstrip, (COMPLETED,), ()),
        "empty lines at the end": (lambda text: text + "\n\n\n", ANY, ()),
        "a comment above": (lambda text: "# my log\n" + text, (REFUSED,), ()),
        "units below the names": (_with_units, (REFUSED,), ()),
        "no names": (lambda text: text.partition("\n")[2], (REFUSED,), ("time_s",)),
        "names twice": (lambda text: text.partition("\n")[0] + "\n" + text, (REFUSED,), ()),
        "a name twice": (lambda text: text.replace("body_rate_y", "body_rate_x", 1), (REFUSED,), ("body_rate_x",)),
        "a row too short": (lambda text: text.replace("\n0.5,", "\n", 1), (REFUSED,), ("row", "column")),
        "a row too long": (lambda text: text.replace("\n0.5,", "\n0.5,7,", 1), (REFUSED,), ("row", "column")),
        "cut in a row": (lambda text: text[: len(text) // 2], (REFUSED,), ("row", "column")),
        "quotes that do not end": (lambda text: text.replace("\n0.5,", '\n"0.5,', 1), (REFUSED,), ()),
        "NUL": (lambda text: text.replace("\n0.5,", "\n\0,", 1), (REFUSED,), ()),
        "words for NaN": (lambda text: _field(text, "n/a"), ANY, ()),
        "dashes for NaN": (lambda text: _field(text, "--"), ANY, ()),
        "a number of 5,000 digits": (lambda text: _field(text, "9" * 5000), (REFUSED,), ()),
        "a formula": (lambda text: _field(text, "=1+1"), (REFUSED,), ()),
        "markup": (lambda text: _field(text, "[red]1[/]"), (REFUSED,), ("[red]1[/]", "body_rate")),
        "a name of a megabyte": (lambda text: text.replace('"time_s"', '"time_s","' + "x" * 10**6 + '"', 1), ANY, ()),
        "100,000 columns": (lambda _: ",".join(f"c{number}" for number in range(100_000)) + "\n", (REFUSED,), ()),
        "UTF-16": (lambda text: text.encode("utf-16"), (REFUSED,), ()),
        "a byte order mark": (lambda text: text.encode("utf-8-sig"), ANY, ()),
        "Latin-1": (lambda text: text.replace('"time_s"', '"Größe","time_s"', 1).encode("latin-1"), (REFUSED,), ()),
    }
    for name, (change, codes, says) in changes.items():
        yield Case(
            name=f"records: CSV with {name}",
            prepare=_filled(
                lambda change=change: {
                    f"{number}.csv": _as_bytes(change(as_csv(good_table()).decode())) for number in (1, 2)
                }
            ),
            commands=ESTIMATE,
            codes=codes,
            says=says,
            fast=name in {"semicolons", "cut in a row", "UTF-16"},
        )


def _as_bytes(text: str | bytes) -> bytes:
    return text if isinstance(text, bytes) else text.encode()


def _with_units(text: str) -> str:
    names, _, rest = text.partition("\n")
    return f"{names}\ns,{','.join(['rad/s'] * 3 + ['rad'] * 6)}\n{rest}"


def _field(text: str, value: str) -> str:
    """Return the text with another first body rate of the tenth row."""
    lines = text.split("\n")
    fields = lines[10].split(",")
    lines[10] = ",".join([fields[0], value, *fields[2:]])
    return "\n".join(lines)


def _bytes() -> Iterator[Case]:
    """Files that are no tables."""
    contents: dict[str, Callable[[], bytes]] = {
        "empty": lambda: b"",
        "one byte": lambda: b"\xff",
        "zeros": lambda: bytes(10_000),
        "noise": lambda: np.random.default_rng(5).bytes(10_000),
        "cut Parquet": lambda: as_parquet(good_table())[:-20],
        "Parquet with flipped bytes": lambda: _flipped(as_parquet(good_table())),
        "a page": lambda: b"<!doctype html><title>Not found</title>",
        "JSON": lambda: b'{"time_s": [1, 2]}',
        "zip": lambda: b"PK\x03\x04" + bytes(100),
    }
    for name, content in contents.items():
        for suffix in ("csv", "parquet"):
            yield Case(
                name=f"records: {name} as {suffix}",
                prepare=_filled(lambda content=content, suffix=suffix: {f"1.{suffix}": content()}),
                commands=ESTIMATE,
                fast=name in {"zeros", "cut Parquet"},
            )


def _flipped(content: bytes) -> bytes:
    flipped = bytearray(content)
    for place in range(4, len(flipped), 97):
        flipped[place] ^= 0xFF
    return bytes(flipped)


def _details() -> Iterator[Case]:
    """What is known of a run as a whole, in NAME.toml."""
    contents: dict[str, tuple[str | bytes, tuple[int, ...], tuple[str, ...]]] = {
        "no TOML": ("{", (REFUSED,), ("1.toml",)),
        "noise": (np.random.default_rng(6).bytes(300), (REFUSED,), ("1.toml",)),
        "an unknown key": ("mass_kg = 0.1", (REFUSED,), ("1.toml",)),
        "nesting 5,000 deep": ("a = " + "[" * 5000 + "]" * 5000, (REFUSED,), ("1.toml",)),
        "5,000 digits": ("gyro_noise_rad_s = " + "9" * 5000, (REFUSED,), ("1.toml",)),
        "no noise": ("gyro_noise_rad_s = 0.0", ANY, ()),
        "negative noise": ("gyro_noise_rad_s = -1.0", (REFUSED,), ("gyro_noise_rad_s",)),
        "infinite noise": ("gyro_noise_rad_s = inf", (REFUSED,), ("gyro_noise_rad_s",)),
        "noise that is not a number": ("gyro_noise_rad_s = nan", (REFUSED,), ("gyro_noise_rad_s",)),
        "noise 1e300": ("gyro_noise_rad_s = 1e300", (REFUSED,), ()),
        "noise 1e-300": ("gyro_noise_rad_s = 1e-300", (REFUSED,), ()),
        "noise as text": ('gyro_noise_rad_s = "little"', (REFUSED,), ("gyro_noise_rad_s",)),
        "two megabytes": ("# " + "x" * 2_000_000, (REFUSED,), ("1.toml",)),
    }
    for name, (content, codes, says) in contents.items():
        yield Case(
            name=f"records: details with {name}",
            prepare=_filled(lambda content=content: {"1.csv": as_csv(good_table()), "1.toml": _as_bytes(content)}),
            commands=ESTIMATE,
            codes=codes,
            says=says,
            fast=name in {"an unknown key", "nesting 5,000 deep", "noise 1e-300"},
        )


def _folders() -> Iterator[Case]:
    """Folders of records."""

    def empty(folder: Path) -> None:
        (folder / "data").mkdir()

    def a_file(folder: Path) -> None:
        (folder / "data").write_text("time_s\n")

    def a_loop(folder: Path) -> None:
        (folder / "data").symlink_to("data")

    def devices(folder: Path) -> None:
        empty(folder)
        (folder / "data" / "1.csv").symlink_to("/dev/zero")

    def folders(folder: Path) -> None:
        (folder / "data" / "1.csv").mkdir(parents=True)

    def twice(folder: Path) -> None:
        empty(folder)
        (folder / "data" / "1.csv").write_bytes(as_csv(good_table()))
        (folder / "data" / "1.parquet").write_bytes(as_parquet(good_table()))

    def good_and_bad(folder: Path) -> None:
        good_records(folder / "data")
        (folder / "data" / "bad.csv").write_text("time_s\n1\n")

    def named_as_markup(folder: Path) -> None:
        empty(folder)
        (folder / "data" / "[red]1[%s].csv").write_bytes(as_csv(good_table()))

    for name, prepare, codes, says in (
        ("is empty", empty, (REFUSED,), ("data",)),
        ("is a file", a_file, (REFUSED,), ("data",)),
        ("is a link to itself", a_loop, (REFUSED,), ("data",)),
        ("is not there", lambda _: None, (REFUSED,), ("data",)),
        ("holds a device", devices, (REFUSED,), ("1.csv",)),
        ("holds folders", folders, (REFUSED,), ("1.csv", "data")),
        ("holds a run twice", twice, (REFUSED,), ("more than one run is called 1",)),
        ("holds a bad run beside good ones", good_and_bad, ANY, ("bad.csv",)),
        ("holds a name with markup", named_as_markup, (COMPLETED,), ("[red]1[%s]",)),
    ):
        for commands in (ESTIMATE, DIAGNOSE):
            if COMPLETED in codes and commands is DIAGNOSE:
                continue
            yield Case(
                name=f"records: folder {name} ({commands[0][0]})",
                prepare=prepare,
                commands=commands,
                codes=codes,
                says=says,
                fast=name == "holds a device",
            )
