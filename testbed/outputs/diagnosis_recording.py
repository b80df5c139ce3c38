"""What the recording of a diagnosis shows: each run measured, and as both models predict it, on one time line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from testbed.arrays import Array, Indices, Series
from testbed.assembly.platform import nominal_body, shown_model
from testbed.diagnosis.findings import additions
from testbed.diagnosis.run_residuals import RunResiduals
from testbed.diagnosis.state import Diagnosis
from testbed.outputs.lean_scene import box_scene, frame_of, lean_scene
from testbed.palette import SHADES, Color
from testbed.plant.scene import scene_of
from testbed.recording.diagnosis import DiagnosisContent, ShownMotion, ShownRun
from testbed.recording.palette import EXTENDED_COLOR, LIMIT_COLOR, MEASURED_COLOR, NOMINAL_COLOR, pale
from testbed.recording.reproduction_content import ShownPanel, ShownTab
from testbed.recording.traces import Style, Trace
from testbed.report.diagnosis.prediction import MEAN_OVER, NOISE_REACH, running_mean, turned_apart, was_extended
from testbed.report.diagnosis.verdict import addition_words, diagnosis_verdict, effect_name
from testbed.rotation.kinematics import integrate_attitude
from testbed.scenario.body import BodyScenario
from testbed.scene import SceneBody
from testbed.signals import AXES

_APART = 0.27
"""m between platforms that stand beside each other: their cubes have an edge of 0.18 m and turn."""
_FRAME_TIME = 1.0 / 30.0
"""s between two poses; a screen shows no more."""


def diagnosis_content(
    scenario: BodyScenario, diagnosis: Diagnosis, residuals: Sequence[RunResiduals], provenance: Mapping[str, str]
) -> DiagnosisContent:
    """Return a tab for each run: the platform and the verdict, body rates of each axis, residuals in sigma."""
    scene = platform_scene(scenario)
    return DiagnosisContent(
        runs=tuple(shown_run(f"run_{number}", run, scene) for number, run in enumerate(residuals, start=1)),
        verdict="\n\n".join(_verdict_lines(diagnosis)),
        provenance="\n".join(f"- **{what}**: `{value}`" for what, value in provenance.items()),
    )


def platform_scene(scenario: BodyScenario) -> tuple[SceneBody, ...]:
    """Return the platform without the cabin that it may fly in; one that nobody drew as the box of its inertia."""
    if not scenario.stores_momentum:
        return box_scene(nominal_body(scenario).inertia)
    scene = [body for body in scene_of(shown_model(scenario)) if body.name == "bus" or body.parent]
    return lean_scene(scene)


def shown_run(root: str, run: RunResiduals, scene: Sequence[SceneBody]) -> ShownRun:
    """Return the tab of a run.

    Args:
        root: first part of its paths.
        run: against both models.
        scene: bodies of the platform, parents before children.
    """
    rates = tuple(_rates(f"{root}/body_rate_{name}", run, axis) for axis, name in enumerate(AXES))
    left = tuple(_left(f"{root}/residual_{name}", run, axis) for axis, name in enumerate(AXES))
    tab = ShownTab(
        name=f"{run.name}{', held out' if run.held_out else ''}", columns=((_attitude(root, run),), rates, left)
    )
    return ShownRun(root=root, tab=tab, motions=tuple(_motions(run, scene)))


def _verdict_lines(diagnosis: Diagnosis) -> Iterator[str]:
    yield f"## {(diagnosis.verdict or 'not reached').capitalize()}"
    yield diagnosis_verdict(diagnosis).text
    for addition in additions(diagnosis):
        words = "\n".join(f"- {line}" for line in addition_words(addition))
        yield f"**{effect_name(addition.effect, addition.component)}**\n\n{words}"
    yield (
        "Grey: measured. Amber: predicted by the nominal model, its inertia and initial rates re-estimated. Violet: "
        f"with all effects added. Residuals: samples as points, their mean over {MEAN_OVER:g} s as a line."
    )


def _rates(origin: str, run: RunResiduals, axis: int) -> ShownPanel:
    traces = (
        _trace(f"{origin}/measured", run.time, run.measured[:, axis], MEASURED_COLOR, "dots"),
        *_predicted(origin, run.time, run.nominal[:, axis], run.extended[:, axis], ("reference", "wide")),
    )
    return ShownPanel(origin=origin, title=f"Body rate {AXES[axis]}, B [rad/s]", traces=traces)


def _left(origin: str, run: RunResiduals, axis: int) -> ShownPanel:
    before, after = (values[:, axis : axis + 1] for values in (run.before, run.after))
    means = running_mean(run.time, before)[:, 0], running_mean(run.time, after)[:, 0]
    band = Trace(
        path=f"{origin}/noise",
        time=run.time[[0, -1]],
        values=np.tile([NOISE_REACH, -NOISE_REACH], (2, 1)),
        names=(f"{NOISE_REACH:g} sigma",) * 2,
        colors=(LIMIT_COLOR,) * 2,
        style="limit",
    )
    traces = (
        _trace(f"{origin}/nominal", run.time, before[:, 0], pale(NOMINAL_COLOR), "dots"),
        _trace(f"{origin}/extended", run.time, after[:, 0], pale(EXTENDED_COLOR), "dots"),
        *_predicted(f"{origin}/mean", run.time, *means),
        band,
    )
    return ShownPanel(origin=origin, title=f"Measured - predicted, {AXES[axis]} [sigma]", traces=traces)


def _attitude(root: str, run: RunResiduals) -> ShownPanel:
    origin = f"{root}/attitude"
    nominal, extended = (turned_apart(run.time, run.measured, rates) for rates in (run.nominal, run.extended))
    return ShownPanel(
        origin=origin,
        title="Angle from the measured attitude [rad]",
        traces=tuple(_predicted(origin, run.time, nominal, extended)),
    )


def _predicted(
    origin: str, time: Series, nominal: Series, extended: Series, styles: tuple[Style, Style] = ("line", "reference")
) -> Iterator[Trace]:
    """Yield both models' lines: a viewer draws them in the order of their paths, the wide one below."""
    yield _trace(f"{origin}/nominal", time, nominal, NOMINAL_COLOR, styles[0])
    yield _trace(f"{origin}/extended", time, extended, EXTENDED_COLOR, styles[1])


def _trace(path: str, time: Series, values: Series, color: Color, style: Style) -> Trace:
    name = path.rpartition("/")[2]
    return Trace(path=path, time=time, values=values[:, None], names=(name,), colors=(color,), style=style)


def _motions(run: RunResiduals, scene: Sequence[SceneBody]) -> Iterator[ShownMotion]:
    """Yield the platform as measured in the middle, and the frames of the predictions, in their colours, beside it."""
    shown = _frames(run.time)
    measured = {} if run.gimbal_angle is None else {"true_gimbal_angle": run.gimbal_angle[shown]}
    yield _motion("measured", run, run.measured, shown, scene, 0.0, measured)
    bus = tuple(body for body in scene if not body.parent)
    predictions = [("nominal", run.nominal, -_APART), ("extended", run.extended, _APART)]
    for name, rates, aside in predictions[: 1 + was_extended(run)]:
        yield _motion(name, run, rates, shown, tuple(frame_of(body, SHADES[name].dark_rgb) for body in bus), aside, {})


def _motion(
    name: str,
    run: RunResiduals,
    rates: Array,
    shown: Indices,
    scene: Sequence[SceneBody],
    aside: float,
    joints: Mapping[str, Array],
) -> ShownMotion:
    attitude = integrate_attitude(run.time, rates)[shown]
    position = np.tile([0.0, aside, 0.0], (len(shown), 1))
    return ShownMotion(
        name=name,
        color=SHADES[name].dark_rgb,
        scene=scene,
        time=run.time[shown],
        channels={"true_attitude": attitude, "true_position": position, **joints},
    )


def _frames(time: Series) -> Indices:
    """Return the samples that are shown as poses, shape (F,): the first of every frame."""
    _, first = np.unique(np.floor((time - time[0]) / _FRAME_TIME), return_index=True)
    return np.asarray(first)
