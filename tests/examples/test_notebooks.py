"""The notebooks run from top to bottom in a fresh kernel, and show what is stored with them."""

from __future__ import annotations

import nbformat
import pytest

from support.notebooks import NOTEBOOKS, WIDGET, executed, stored, texts_of
from support.printed import require_same
from support.processes import ROOT

LARGEST = 300_000
"""Bytes of a notebook with its outputs."""
TOLERANCE = 1e-3
"""A tenth of the standard deviations that are printed, in 1e-3 kg·m²; machines differ in the last digits."""
VERDICTS = {
    "first_flight": "The flight was completed; all 18 of the estimators",
    "diagnose_and_extend": "gyro_latency (gyro) from gyro_averaging (gyro), gyro_bandwidth (gyro) and telemetry_skew",
}
ASSET = "RERUN_NOTEBOOK_ASSET"
CHOSEN = "http://127.0.0.1:9/widget.js"
"""A place of the reader's choice: the kernel fetches nothing from there, and has nothing to compress and serve."""


@pytest.fixture(scope="module", params=NOTEBOOKS, ids=lambda path: path.stem)
def both(request, tmp_path_factory):
    """A notebook as it is stored, and executed now."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(ROOT))
        patch.setenv("OMP_NUM_THREADS", "1")
        patch.delenv(ASSET, raising=False)
        if request.param.stem == "diagnose_and_extend":
            patch.setenv(ASSET, CHOSEN)
        made = executed(request.param, tmp_path_factory.mktemp("notebook"))
    return request.param, nbformat.read(request.param, as_version=4), made


def outputs_of(notebook, mime):
    return [
        output["data"][mime]
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if mime in output.get("data", {})
    ]


def test_there_are_two_of_them():
    assert {path.stem for path in NOTEBOOKS} == set(VERDICTS)


def test_a_notebook_shows_verdict_tables_picture_and_viewer(both):
    path, _, made = both
    (frame,) = [shown for shown in outputs_of(made, "text/html") if shown.startswith("<iframe")]
    assert VERDICTS[path.stem].replace("'", "&#39;") in frame
    assert "class=&#34;framed&#34;" in frame
    assert len(outputs_of(made, WIDGET)) == 1
    assert len(outputs_of(made, "image/png")) == 1
    assert any('class="dataframe"' in shown for shown in outputs_of(made, "text/html"))
    assert any(VERDICTS[path.stem] in text for text in texts_of(made))
    assert not [output for cell in made.cells for output in cell.get("outputs", ()) if output.get("name") == "stderr"]


def test_a_notebook_is_stored_with_the_outputs_that_it_has(both):
    """If this fails: python -m support.notebooks."""
    _, kept, made = both
    assert [cell.source for cell in kept.cells] == [cell.source for cell in made.cells]
    require_same("\n".join(texts_of(kept)), "\n".join(texts_of(made)), TOLERANCE)
    shown = [[sorted(output.get("data", {})) for output in cell.get("outputs", ())] for cell in kept.cells]
    again = [[sorted(output.get("data", {})) for output in cell.get("outputs", ())] for cell in stored(made).cells]
    assert shown == again


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_small_and_valid(path):
    assert path.stat().st_size < LARGEST
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    assert notebook.metadata.keys() == {"kernelspec", "language_info"}
    assert any("input scenarios/" in shown for shown in outputs_of(notebook, "text/html")), "no place on a machine"
    assert not outputs_of(notebook, WIDGET), "a widget without its kernel shows an error"
