"""The folder of a run: scenario, record, recording, report, result, provenance."""

from __future__ import annotations

from pathlib import Path

from testbed.assembly.platform import shown_model
from testbed.experiment.experiment import Experiment
from testbed.experiment.result import result_of
from testbed.files import TextFile, write_json
from testbed.outputs.provenance import Provenance
from testbed.outputs.recording import recording_content
from testbed.plant.fingerprint import model_sha256
from testbed.plant.scene import scene_of
from testbed.records.writing import write_record
from testbed.report.run import write_run_report


def write_run(folder: Path, file: TextFile, origin: Provenance, experiment: Experiment) -> None:
    """Write the results of a run; of a diverged flight, what was recorded and marked so.

    Args:
        folder: to write into.
        file: the scenario that was flown, as it was read.
        origin: what made the run; the hash of the flown model is added here.
        experiment: the run.

    Raises:
        OSError: the folder cannot be written.
    """
    origin = _with_model(origin, experiment)
    result = result_of(experiment) | {"provenance": origin.reproducible}
    record = experiment.flown.record
    (folder / "scenario.toml").write_bytes(file.content)
    write_record(record, folder / "record.parquet")
    write_json(folder / "result.json", result)
    write_json(folder / "provenance.json", origin.content)
    write_run_report(folder / "report.html", experiment, origin.listed | {"scenario.toml": file.text}, result)
    write_run_recording(folder / "recording.rrd", origin, experiment)


def write_run_recording(path: Path, origin: Provenance, experiment: Experiment) -> None:
    """Write the recording of a run, whole or not at all.

    Args:
        path: of the .rrd file.
        origin: what made the run; the hash of the flown model is added here.
        experiment: the run.
    """
    from testbed.recording.writer import write_recording  # noqa: PLC0415 - rerun takes half a second, which only a recording needs

    record, origin = experiment.flown.record, _with_model(origin, experiment)
    write_recording(
        path,
        recording_id=origin.recording_id,
        time=record.time,
        channels=record.channels,
        scene=scene_of(shown_model(experiment.scenario)),
        content=recording_content(experiment, origin.listed),
    )


def _with_model(origin: Provenance, experiment: Experiment) -> Provenance:
    return origin.with_deciding(model_sha256=model_sha256(experiment.truth.model))
