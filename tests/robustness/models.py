"""MJCF files of one's own: broken, incomplete, and larger than any machine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from support.processes import ROOT
from tests.robustness.case import ANY, REFUSED, Case
from tests.robustness.scenario_files import TEXT

PLATFORM, UNIT = ((ROOT / "models" / name).read_text(encoding="utf-8") for name in ("platform.xml", "cmg.xml"))
COMMANDS = (("check", "scenario.toml"), ("run", "scenario.toml", "--out", "out"))


def cases() -> Iterator[Case]:
    """Give a case for every model."""
    for name, (platform, unit, codes, says) in _models().items():
        yield Case(
            name=f"MJCF: {name}",
            prepare=_writing(platform, unit),
            commands=COMMANDS,
            codes=codes,
            says=says,
            fast=name in {"a texture of 2.7 GB", "empty", "no hull"},
        )


def _writing(platform: str | bytes, unit: str):
    def prepare(folder: Path) -> None:
        scenario = TEXT.replace("[platform]", '[platform]\nmodel = "platform.xml"', 1)
        (folder / "scenario.toml").write_text(scenario, encoding="utf-8")
        content = platform if isinstance(platform, bytes) else platform.encode()
        (folder / "platform.xml").write_bytes(content)
        (folder / "cmg.xml").write_text(unit, encoding="utf-8")

    return prepare


def _with(addition: str) -> str:
    return PLATFORM.replace("</mujoco>", f"{addition}</mujoco>")


def _models() -> dict[str, tuple[str | bytes, str, tuple[int, ...], tuple[str, ...]]]:
    said = ("platform.xml",)
    broken: dict[str, str | bytes] = {
        "empty": "",
        "zeros": bytes(1000),
        "prose": "a platform",
        "cut": PLATFORM[: len(PLATFORM) // 2],
        "another root": "<robot name='x'/>",
        "an unknown element": _with("<wings/>"),
        "an attribute of no meaning": PLATFORM.replace("<worldbody", '<worldbody wings="2"', 1),
        "a name twice": _with('<worldbody><body name="bus"/></worldbody>'),
        "12 MB": _with(" " * 12_000_000),
        "5,000 elements deep": f"<mujoco><worldbody>{'<body>' * 5000}{'</body>' * 5000}</worldbody></mujoco>",
        "entities that multiply": _entities(),
        "includes itself": _with('<include file="platform.xml"/>'),
        "includes a device": _with('<include file="/dev/zero"/>'),
        "includes nothing": _with('<include file="nothing.xml"/>'),
        "a mesh that is a device": _with('<asset><mesh name="m" file="/dev/zero"/></asset>'),
        "a mesh that is not there": _with('<asset><mesh name="m" file="m.stl"/></asset>'),
        "a height field of 1.6 GB": _with('<asset><hfield name="h" nrow="20000" ncol="20000" size="1 1 1 1"/></asset>'),
        "a texture of 2.7 GB": _with(
            '<asset><texture name="t" type="2d" builtin="flat" width="30000" height="30000"/></asset>'
        ),
        "4 GB of user data": _with('<size nuserdata="500000000"/>'),
        "numbers of 4 GB": _with('<custom><numeric name="n" size="500000000" data="1"/></custom>'),
        "a hundred million key frames": _with('<size nkey="100000000"/>'),
        "a million copies": _with(
            '<worldbody><replicate count="1000000" offset="1 0 0"><geom size="1"/></replicate></worldbody>'
        ),
        "27 million points": _with(
            '<worldbody><flexcomp name="f" type="grid" count="300 300 300" spacing=".1 .1 .1" mass="1"/></worldbody>'
        ),
    }
    models = {name: (platform, UNIT, (REFUSED,), said) for name, platform in broken.items()}
    for part in ("hull", "bus"):
        without = re.sub(f'name="{part}"', f'name="{part}s"', PLATFORM)
        models[f"no {part}"] = (without, UNIT, (REFUSED,), (part,))
    for part in ("gimbal", "rotor", "gimbal_motor", "rotor_motor"):
        without = re.sub(f'name="{part}"', f'name="{part}s"', UNIT)
        models[f"no {part}"] = (PLATFORM, without, (REFUSED,), (f"cmg1_{part}", "cmg.xml", "platform.xml"))
    models["a unit that is empty"] = (PLATFORM, "", (REFUSED,), ("cmg.xml", "platform.xml"))
    models["a unit of zero mass"] = (PLATFORM, re.sub(r'mass="[^"]*"', 'mass="0"', UNIT), ANY, ())
    models["a plugin of nobody"] = (
        _with('<extension><plugin plugin="nobody.knows"/></extension>'),
        UNIT,
        (REFUSED,),
        said,
    )
    return models


def _entities() -> str:
    lines = ["<!DOCTYPE mujoco [", '<!ENTITY a0 "many">']
    lines += [f'<!ENTITY a{level} "{f"&a{level - 1};" * 10}">' for level in range(1, 10)]
    return "\n".join([*lines, "]>", '<mujoco model="&a9;"/>'])
