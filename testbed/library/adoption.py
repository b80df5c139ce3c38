"""A scenario from a model of one's own."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from testbed.arrays import Matrix3
from testbed.assembly.adoption import scenario_name, scenario_text
from testbed.assembly.platform import each_wheel, nominal_platform
from testbed.errors import InputError, OutputError
from testbed.files import TextFile, whole_file
from testbed.library.arguments import AnyPath, Text, Texts, checked
from testbed.plant.adopted import AdoptedPlatform, adopted_platform
from testbed.plant.adopted_roles import Corrections
from testbed.plant.own_motion import motion_difference, softness_notes
from testbed.scenario.reader import scenario_of
from testbed.scenario.scenario import Scenario

_LINE = re.compile(r"^(\s*)line \d+, ", re.MULTILINE)
"""Of a scenario: one that is refused is not written, and no one sees its lines."""


@dataclass(frozen=True)
class Adoption:
    """A platform that was found in a user's model, and its scenario.

    Attributes:
        scenario: which flies it.
        text: of the scenario, with comments on what was not in the model.
        parts: name of every joint of the platform, what it was taken for, and why.
        notes: what of the model a scenario cannot say.
        difference: largest difference of body rates, rad/s, between the user's model and what is flown, over 10 s in
            which both are moved by the same torques.
    """

    scenario: Scenario
    text: str
    parts: tuple[tuple[str, str, str], ...]
    notes: tuple[str, ...]
    difference: float
    _found: AdoptedPlatform = field(repr=False)

    def __str__(self) -> str:
        parts = "\n".join(f"{name}: {role}, {reason}" for name, role, reason in self.parts)
        return f"{parts}\nbody rate within {self.difference:.1e} rad/s of the model's over 10 s"

    @property
    def inertia(self) -> Matrix3:
        """J about the centre of mass, everything locked as drawn, shape (3, 3), kg·m², body axes."""
        return self._found.inertia

    @property
    def mass(self) -> float:
        """Mass of the whole platform, kg."""
        return self._found.mass

    @checked
    def save(self, path: AnyPath) -> Path:
        """Write the scenario, and return its path.

        Raises:
            InputError: the file is there already, or cannot be written.
        """
        target = Path(path)
        if target.exists():
            raise InputError(f"{target}: exists; choose another name")
        try:
            with whole_file(target) as part:
                part.write_text(self.text, encoding="utf-8")
        except OSError as error:
            raise OutputError(f"{target}: cannot be written ({error.strerror}); choose another file") from error
        return target


@checked
def adopt(
    model: AnyPath,
    *,
    name: Text | None = None,
    wheel: Texts = (),
    rotor: Texts = (),
    ignore: Texts = (),
) -> Adoption:
    """Return the scenario of a platform that a model of one's own describes.

    The platform is the body with a free joint, or with a ball joint, which is an air bearing. A hinge of it about an
    axis of symmetry, with a motor or a wheel's name, is a reaction wheel; a hinge that carries such a hinge across its
    axis is the gimbal of a control moment gyro. All other joints are locked as drawn.

    Args:
        model: path of an MJCF or a URDF. The root of a URDF is the platform, unless a floating joint says otherwise.
        name: of the scenario; by default the file's.
        wheel: joints, or their bodies, that are reaction wheels, whatever they look like; a single text is one of them.
        rotor: likewise rotors of control moment gyros; what carries them are their gimbals.
        ignore: likewise what is locked as drawn.

    Raises:
        InputError: the file cannot be read, or the model lacks something; all of it is listed.

    Example:
        >>> import pathlib, tempfile, testbed as tb
        >>> wheels = "".join(
        ...     f"<body name='{name}'><joint name='{name}' axis='{axis}'/>"
        ...     f"<geom type='cylinder' size='0.02 0.004' zaxis='{axis}' mass='0.1'/></body>"
        ...     for name, axis in {"port": "0 1 0", "bow": "1 0 0", "keel": "0 0 1"}.items()
        ... )
        >>> motors = "".join(f"<motor joint='{name}' ctrlrange='-0.001 0.001'/>" for name in ("port", "bow", "keel"))
        >>> body = f"<body name='ship'><freejoint/><geom type='box' size='.1 .1 .15' mass='4'/>{wheels}</body>"
        >>> xml = f"<mujoco><worldbody>{body}</worldbody><actuator>{motors}</actuator></mujoco>"
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder, "ship.xml")
        ...     _ = path.write_text(xml)
        ...     adopted = tb.adopt(path)
        >>> [f"{part}: {role}" for part, role, _ in adopted.parts]
        ['ship: platform', 'port: wheel', 'bow: wheel', 'keel: wheel']
        >>> adopted.difference < 1e-8
        True
    """
    path = Path(model)
    found = adopted_platform(path, Corrections(wheel=wheel, rotor=rotor, ignore=ignore))
    text = scenario_text(found, scenario_name(path.stem if name is None else name))
    file = TextFile(path=path.with_suffix(".toml"), content=text.encode("utf-8"), text=text)
    try:
        scenario = scenario_of(file)
        platform = nominal_platform(scenario)
    except InputError as error:
        problems = _LINE.sub(r"\1", str(error).removeprefix(f"{file.path}: "))
        locked = "".join(f"\n  the joint {each.name} is locked: it {each.reason}" for each in found.locked)
        raise InputError(
            f"{path}: what was found in it makes no scenario that can be flown: {problems}{locked}"
        ) from error
    speed = platform.cluster.rotor_momentum / platform.cluster.rotor_spin_inertia
    return Adoption(
        scenario=scenario,
        text=text,
        parts=tuple((each.name, each.role, each.reason) for each in found.taken),
        notes=(*found.notes, *softness_notes(found, platform.model)),
        difference=motion_difference(found, platform.model, 0.5 * each_wheel(scenario, "torque_limit_N_m"), speed),
        _found=found,
    )
