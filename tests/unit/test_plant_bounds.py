"""What an MJCF may ask for: refused before MuJoCo allocates it, and all that a platform takes is let through."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from testbed.errors import InputError
from testbed.plant.bounds import MOST_FILE, require_bounded
from testbed.plant.build import shipped_model


def model(folder: Path, content: str) -> Path:
    path = folder / "platform.xml"
    path.write_text(f"<mujoco>{content}</mujoco>", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('<asset><hfield name="h" nrow="20000" ncol="20000"/></asset>', "a hfield of 20000 x 20000 has more than"),
        ('<asset><texture width="30000" height="30000"/></asset>', "a texture of 30000 x 30000 has more than"),
        ('<size nuserdata="500000000"/>', "<size nuserdata> is 500000000, more than 10000"),
        (f'<size nkey="{"9" * 5000}"/>', f"<size nkey> is {'9' * 20}, more than 10000"),
        ('<custom><numeric name="n" size="500000000"/></custom>', "<numeric size> is 500000000"),
        ('<sensor><user dim="500000000"/></sensor>', "<user dim> is 500000000"),
        ('<worldbody><replicate count="1000000"/></worldbody>', "<replicate> makes 1000000 copies"),
        (
            '<worldbody><replicate count="200"><replicate count="200"/></replicate></worldbody>',
            "<replicate> makes 40000 copies",
        ),
        ('<worldbody><flexcomp count="300 300 300"/></worldbody>', "<flexcomp> makes 27000000 copies"),
        ('<asset><mesh file="/dev/zero"/></asset>', "its file /dev/zero cannot be read (Is a device or a pipe"),
        ('<include file="more.xml"/>', "<size nuserdata> is 20000"),
        ('<include file="/dev/zero"/>', "of what it includes, /dev/zero: cannot be read (Is a device or a pipe"),
        ('<asset><mesh file="big.stl"/></asset>', "its file big.stl is larger than 100 MB"),
        ('<compiler meshdir="meshes"/><asset><mesh file="big.stl"/></asset>', "its file big.stl is larger than 100 MB"),
        ('<asset><texture file="wide.png"/></asset>', "its picture wide.png has more than 16777216 pixels"),
    ],
)
def test_what_asks_for_too_much_is_refused(tmp_path, content, message):
    (tmp_path / "more.xml").write_text('<mujoco><size nuserdata="20000"/></mujoco>', encoding="utf-8")
    folder = tmp_path / "meshes" if "meshdir" in content else tmp_path
    folder.mkdir(exist_ok=True)
    with (folder / "big.stl").open("wb") as file:
        file.truncate(MOST_FILE + 1)
    (tmp_path / "wide.png").write_bytes(
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", 30_000, 30_000) + b"\x08\x02\x00\x00\x00"
    )
    with pytest.raises(InputError) as caught:
        require_bounded(model(tmp_path, content))
    assert message in str(caught.value)
    assert str(caught.value).endswith("; mend the file")


@pytest.mark.parametrize("content", ["<open>", "<a></b>"])
def test_what_is_no_xml_is_refused_with_its_place(tmp_path, content):
    with pytest.raises(InputError, match=r"platform\.xml: not a readable MJCF: mismatched tag: line 1, column \d+"):
        require_bounded(model(tmp_path, content))


def test_a_file_that_includes_itself_ends(tmp_path):
    require_bounded(model(tmp_path, '<include file="platform.xml"/>'))


def test_the_shipped_platform_and_hyphens_in_comments_pass(tmp_path):
    require_bounded(shipped_model())
    require_bounded(model(tmp_path, '<!-- one -- two --><asset><hfield nrow="4000" ncol="4000"/></asset>'))
