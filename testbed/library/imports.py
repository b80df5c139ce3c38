"""Logs of other programs, imported as records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from typing_extensions import override

from testbed.errors import InputError, made_of_each
from testbed.files import TextFile
from testbed.library.arguments import AnyPath, AnyPaths, Format, checked, give
from testbed.library.records import Records, require_runs
from testbed.logs.convert import Imported as Import
from testbed.logs.convert import ImportedChannel
from testbed.logs.guess import guessed_map, unchecked_lines
from testbed.logs.map import map_file, map_of
from testbed.logs.opening import opened
from testbed.logs.several import imported_together
from testbed.outputs.folder import reserved_folder
from testbed.outputs.import_folder import write_import
from testbed.outputs.provenance import provenance_of_files

GivenMap = Annotated[
    AnyPath | Mapping[str, Any], give("the path of MAP.toml, or its keys, such as {'schema': 1, ...}; see tb.guess_map")
]
GivenLogs = Annotated[AnyPath | AnyPaths, give("the path of a log, or of several, as a list")]
_PACKAGES = ("testbed", "numpy", "pyarrow", "pint", "pyulog", "mcap", "mcap-protobuf-support", "rosbags")
"""Whose versions decide what is read of a log."""


@dataclass(frozen=True, eq=False, repr=False)
class ImportedRecords(Records):
    """Runs from logs, and how they came about.

    Attributes:
        made: records with what was converted and left out.
        logs: their paths.
        file: the map.
    """

    made: Import
    logs: tuple[Path, ...]
    file: TextFile

    @property
    def channels(self) -> Mapping[str, ImportedChannel]:
        """How each channel came about: topic, fields, clock, what was converted, samples and their rate, by name."""
        return self.made.channels

    @property
    def dropped(self) -> tuple[str, ...]:
        """What was left out, or could not be read, in sentences."""
        return self.made.dropped

    @property
    def unused(self) -> tuple[str, ...]:
        """Topics, or columns of a table, that the map does not name."""
        return self.made.unused

    @property
    def pauses(self) -> tuple[str, ...]:
        """Where samples are missing within runs, and pauses of the gyro that may be two flights, in sentences."""
        return self.made.pauses

    @property
    def unchecked(self) -> tuple[str, ...]:
        """Lines of the map that `--guess` proposed without a statement of the log, and that nobody has confirmed."""
        return unchecked_lines(self.file.text)

    @override
    def __str__(self) -> str:
        said = {"dropped": self.dropped, "missing": self.pauses, "unchecked": self.unchecked}
        return "\n".join([super().__str__(), *(f"{what}: {each}" for what, texts in said.items() for each in texts)])

    @override
    @checked
    def save(self, folder: AnyPath, *, format: Format = "parquet") -> Path:
        """Write the runs and provenance.json, as `testbed import` does; with `format="mcap"` as `Records.save`.

        Args:
            folder: new or empty.
            format: of the runs.

        Raises:
            InputError: there are no runs, there is no such format, or the folder cannot be used.
        """
        if format == "mcap":
            return super().save(folder, format=format)
        require_runs("records", self)
        with reserved_folder(Path(folder), "import") as output:
            output.deliver(lambda place: self.write(place, "testbed.import_log"))
        return Path(folder)

    def write(self, folder: Path, command: str) -> None:
        """Write the data set into a folder that is reserved for it.

        Args:
            folder: to write into.
            command: that imported the logs, for their provenance.
        """
        name = self.logs[0].name if len(self.logs) == 1 else f"{len(self.logs)} logs"
        origin = provenance_of_files(name, self.made.inputs, command, _PACKAGES)
        write_import(folder, self.file, origin, self.made)


@checked
def import_log(
    log: GivenLogs,
    map: GivenMap,  # noqa: A002 - what it is called everywhere else
    out: AnyPath | None = None,
) -> ImportedRecords:
    r"""Return logs of another program as records: ULog, MCAP, ROS bag, CSV or Parquet.

    Each topic keeps its own times: a record has a row for every time of any topic, with NaN where a channel was not
    sampled. Nothing is interpolated. The libraries that it needs are the extra `testbed[logs]`.

    Args:
        log: path of the file; of a ROS 2 bag, its folder. Or of several that one map reads, each at least one run.
        map: path of MAP.toml, or its keys: topics, fields, units, axes, clock, and how the log is cut into runs.
        out: new or empty folder for the data set, which `read_records` and the commands read; None for none.

    Raises:
        InputError: a log or the map cannot be read, or the map names what the log does not hold; the message gives the
            nearest names.

    Example:
        >>> import pathlib, tempfile, testbed as tb
        >>> lines = [f"{5 * n},{n % 7},0,1,0,0,0.1" for n in range(200)]
        >>> rates = {"fields": ["gx", "gy", "gz"], "unit": "deg/s", "axes": ["-y", "x", "z"]}
        >>> torques = {"fields": ["mx", "my", "mz"], "unit": "mN*m"}
        >>> keys = {
        ...     "schema": 1,
        ...     "clock": {"field": "t", "unit": "ms"},
        ...     "channels": {"body_rate": rates, "applied_torque": torques},
        ... }
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "bench.csv")
        ...     _ = path.write_text("\n".join(["t,gx,gy,gz,mx,my,mz", *lines]))
        ...     records = tb.import_log(path, keys)
        >>> print(records)
        1 run
        bench: 200 rows over 0.995 s, body_rate, applied_torque
        >>> records.channels["body_rate"].converted
        ('deg/s to rad/s, times 0.0174532925', "body x, y, z from the sensor's -y, x, z")
    """
    file = map_file(map)
    log_map = map_of(file)
    paths = (Path(log),) if isinstance(log, str | Path) else tuple(Path(each) for each in log)
    if not paths:
        raise InputError("log = []: there is no log in it; give the path of a log, or of several, as a list")
    made = imported_together(made_of_each(opened, paths), log_map, file.stamp)
    records = ImportedRecords(made.records, made, paths, file)
    if out is not None:
        records.save(out)
    return records


@checked
def guess_map(log: AnyPath) -> str:
    r"""Return the text of a map for a log, proposed from names and units; each line says what it was taken from.

    Args:
        log: path of the file; of a ROS 2 bag, its folder.

    Raises:
        InputError: the log cannot be read, or nothing in it is called a gyro or a body rate.

    Example:
        >>> import pathlib, tempfile, testbed as tb
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "bench.csv")
        ...     _ = path.write_text("t_ms,gyro_x_dps,gyro_y_dps,gyro_z_dps\n0,1,2,3\n5,1,2,3\n")
        ...     print(tb.guess_map(path).partition("\n# CHECK: no channel")[0])
        # Map of bench.csv (CSV), proposed from names and units.
        # Check every line, above all units, axes and clock. Then:
        # testbed import LOG --map MAP.toml --out FOLDER
        schema = 1
        <BLANKLINE>
        [clock]
        field = "t_ms"
        unit = "ms"  # unit: stated
        <BLANKLINE>
        # From the name 'gyro'; unit: stated.
        [channels.body_rate]
        fields = ["gyro_x_dps", "gyro_y_dps", "gyro_z_dps"]
        unit = "deg/s"
    """
    return guessed_map(opened(Path(log)))
