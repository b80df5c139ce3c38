"""The folder of a run: scenario, record, recording, report, result, provenance."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from testbed.assembly.platform import shown_model
from testbed.delivery.folder import whole_folder
from testbed.delivery.provenance import recording_id_of, run_provenance
from testbed.delivery.recording import recording_content
from testbed.experiment.experiment import Experiment
from testbed.experiment.result import result_of
from testbed.plant.scene import scene_of
from testbed.recording.writer import write_recording
from testbed.records.writing import write_record
from testbed.report.run import write_run_report


def write_run(folder: Path, scenario_path: Path, experiment: Experiment) -> None:
    """Write a run folder, whole or not at all; of a diverged flight, what was recorded and marked so.

    Args:
        folder: new or empty.
        scenario_path: the file that was flown; copied as it is.
        experiment: the run.

    Raises:
        InputError: the folder is taken, or cannot be written.
    """
    scenario_text = scenario_path.read_text(encoding="utf-8")
    provenance = run_provenance(experiment, scenario_text)
    result = result_of(experiment)
    record = experiment.flown.record
    with whole_folder(folder) as part:
        shutil.copyfile(scenario_path, part / "scenario.toml")
        write_record(record, part / "record.parquet")
        write_json(part / "result.json", result)
        write_json(part / "provenance.json", provenance)
        write_run_report(part / "report.html", experiment, provenance | {"scenario.toml": scenario_text}, result)
        write_recording(
            part / "recording.rrd",
            recording_id=recording_id_of(provenance),
            time=record.time,
            channels=record.channels,
            scene=scene_of(shown_model(experiment.scenario)),
            content=recording_content(experiment, provenance),
        )


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write JSON that a person can read too; numbers with all their digits.

    Raises:
        ValueError: a number is not finite, which JSON cannot say.
    """
    path.write_text(json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")
