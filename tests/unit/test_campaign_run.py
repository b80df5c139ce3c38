"""A campaign's folder: grows block by block, is finished by a resumed campaign, takes no other one."""

from __future__ import annotations

import errno
import fcntl
import hashlib
import json
import os
from dataclasses import replace
from pathlib import Path

import pyarrow.dataset as ds
import pytest

from support.campaigns import Pretended, plan_of, small_scenario
from testbed.campaign.columns import schema_of
from testbed.campaign.manifest import read_manifest
from testbed.campaign.plan import COMPILED_BLOCK_RUNS, blocks_of, run_seed
from testbed.campaign.run import Progress, run_campaign
from testbed.errors import InputError

RUNS = 4 * COMPILED_BLOCK_RUNS - 10


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    return plan_of(small_scenario(tmp_path_factory.mktemp("scenario")), RUNS)


def parts(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "runs").iterdir()}


def test_seeds_of_runs_are_distinct_and_fit_their_column():
    seeds = [run_seed(7, run) for run in range(10_000)]
    assert len(set(seeds)) == 10_000
    assert min(seeds) >= 0
    assert max(seeds) < 2**63
    assert run_seed(8, 0) not in seeds


def test_the_folder_is_a_data_set_of_one_schema(plan, tmp_path):
    table = run_campaign(plan, tmp_path, Pretended())
    assert sorted(parts(tmp_path)) == [f"part-{index:05d}.parquet" for index in range(4)]
    whole = ds.dataset(tmp_path / "runs").to_table()
    assert whole.equals(table)
    assert whole.schema.equals(schema_of(plan.scenario))
    assert table["run"].to_pylist() == list(range(RUNS))
    assert table["seed"].to_pylist() == [run_seed(plan.seed, run) for run in range(RUNS)]
    assert table["first_contact_s"].null_count == RUNS
    assert read_manifest(tmp_path).complete


def test_memory_and_any_order_give_the_same_runs(plan, tmp_path):
    straight = run_campaign(plan, None, Pretended())
    assert run_campaign(plan, None, Pretended(backwards=True)).equals(straight)
    assert run_campaign(plan, tmp_path, Pretended(backwards=True)).equals(straight)


def test_an_interrupted_campaign_is_marked_and_flies_only_what_is_missing(plan, tmp_path):
    run_campaign(plan, tmp_path / "straight", Pretended())
    with pytest.raises(KeyboardInterrupt):
        run_campaign(plan, tmp_path / "twice", Pretended(most=2))
    assert not read_manifest(tmp_path / "twice").complete
    counts: list[int] = []
    second = Pretended()
    run_campaign(plan, tmp_path / "twice", second, Progress(kept=counts.append))
    assert second.flown == [2, 3]
    assert counts == [2 * COMPILED_BLOCK_RUNS, COMPILED_BLOCK_RUNS, COMPILED_BLOCK_RUNS - 10]
    assert parts(tmp_path / "twice") == parts(tmp_path / "straight")
    assert read_manifest(tmp_path / "twice").complete


def test_a_complete_campaign_flies_nothing_again(plan, tmp_path):
    first = run_campaign(plan, tmp_path, Pretended())
    idle = Pretended()
    assert run_campaign(plan, tmp_path, idle).equals(first)
    assert idle.flown == []


def set_aside(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "set_aside").iterdir()}


def flip(path: Path) -> bytes:
    """Flip a byte in the middle of a file; returns what it holds then."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    path.write_bytes(content)
    return bytes(content)


def resumed(plan, folder: Path) -> tuple[list[int], list[str]]:
    """Resume a campaign; returns the blocks that were flown, and what was said."""
    notices: list[str] = []
    again = Pretended()
    run_campaign(plan, folder, again, Progress(notify=notices.append))
    return again.flown, notices


def test_every_part_has_its_checksum_in_the_manifest(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    sums = {name: hashlib.sha256(content).hexdigest() for name, content in parts(tmp_path).items()}
    assert read_manifest(tmp_path).parts == sums


def test_damaged_and_foreign_parts_are_set_aside_and_flown_again(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    whole = parts(tmp_path)
    first, second, third, fourth = sorted((tmp_path / "runs").iterdir())
    first.write_bytes(whole[first.name][:1000])
    second.write_bytes(whole[third.name])
    flipped = flip(fourth)
    (tmp_path / "runs" / "part-junk.parquet").write_bytes(b"junk")
    (tmp_path / "runs" / "part-99999.parquet").write_bytes(whole[third.name])
    flown, notices = resumed(plan, tmp_path)
    assert flown == [0, 1, 3]
    assert parts(tmp_path) == whole
    assert set_aside(tmp_path) == {
        "part-00000.parquet": whole[first.name][:1000],
        "part-00001.parquet": whole[third.name],
        "part-00003.parquet": flipped,
        "part-junk.parquet": b"junk",
        "part-99999.parquet": whole[third.name],
    }
    assert len(notices) == 5
    assert all(any(name in text for text in notices) for name in set_aside(tmp_path))


def test_what_is_set_aside_twice_overwrites_nothing(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    whole, contents = parts(tmp_path), []
    for _ in range(3):
        contents.append(flip(tmp_path / "runs" / "part-00001.parquet")[:-1])
        (tmp_path / "runs" / "part-00001.parquet").write_bytes(contents[-1] + bytes([len(contents)]))
        contents[-1] += bytes([len(contents)])
        assert resumed(plan, tmp_path)[0] == [1]
    assert sorted(set_aside(tmp_path).values()) == sorted(contents)
    assert parts(tmp_path) == whole


def test_a_campaign_begun_before_there_were_checksums_is_read_and_gets_them(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    manifest = json.loads((tmp_path / "campaign.json").read_text(encoding="utf-8"))
    sums = manifest.pop("parts")
    (tmp_path / "campaign.json").write_text(json.dumps(manifest), encoding="utf-8")
    whole = parts(tmp_path)
    (tmp_path / "runs" / "part-00000.parquet").write_bytes(whole["part-00000.parquet"][:1000])
    (tmp_path / "runs" / "part-99999.parquet").write_bytes(whole["part-00001.parquet"])
    flown, notices = resumed(plan, tmp_path)
    assert flown == [0]
    assert len(notices) == 2
    assert parts(tmp_path) == whole
    assert read_manifest(tmp_path).parts == sums


def test_more_runs_extend_a_campaign_as_if_it_had_been_flown_in_one_go(plan, tmp_path):
    more = replace(plan, runs=RUNS + COMPILED_BLOCK_RUNS)
    straight = run_campaign(more, tmp_path / "straight", Pretended())
    run_campaign(plan, tmp_path / "twice", Pretended())
    second = Pretended()
    extended = run_campaign(more, tmp_path / "twice", second)
    assert second.flown == [3, 4]  # the last block had 15 of its 25 runs
    assert extended.equals(straight)
    assert parts(tmp_path / "twice") == parts(tmp_path / "straight")
    assert not (tmp_path / "twice" / "set_aside").exists()
    before, after = (read_manifest(tmp_path / name) for name in ("straight", "twice"))
    assert (after.campaign, after.parts, after.complete) == (before.campaign, before.parts, True)


def test_what_a_killed_process_had_half_written_is_removed(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    (tmp_path / "runs" / ".part-00002.parquet.part").write_bytes(b"half")
    assert resumed(plan, tmp_path) == ([], [])
    assert len(parts(tmp_path)) == 4


def changed(plan, **sections):
    scenario = plan.scenario
    update = {name: getattr(scenario, name).model_copy(update=change) for name, change in sections.items()}
    return replace(plan, scenario=scenario.model_copy(update=update))


def test_another_campaign_is_refused_and_nothing_is_touched(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended(), Progress())
    whole, manifest = parts(tmp_path), read_manifest(tmp_path)
    for other, named in (
        (replace(plan, seed=6), "seed 5, now 6"),
        (replace(plan, runs=50), f"runs {RUNS}, now 50"),
        (changed(plan, gyro={"noise_rad_s": 0.05}), r"scenario.gyro.noise_rad_s 0.002, now 0.05"),
        (replace(plan, maneuver=replace(plan.maneuver, duration=0.5)), "maneuver_sha256"),
    ):
        with pytest.raises(InputError, match=named):
            run_campaign(other, tmp_path, Pretended())
    assert parts(tmp_path) == whole
    assert read_manifest(tmp_path) == manifest


def test_other_versions_are_refused(plan, tmp_path, monkeypatch):
    run_campaign(plan, tmp_path, Pretended())
    monkeypatch.setattr("testbed.campaign.manifest.version", lambda _package: "0.0.0")
    with pytest.raises(InputError, match=r"versions.mujoco .*, now \"0.0.0\""):
        run_campaign(plan, tmp_path, Pretended())


def test_a_full_disk_keeps_what_is_there_and_names_the_folder(plan, tmp_path, monkeypatch):
    write = Path.write_bytes

    def full(path, content):
        if "part-00002" in path.name:
            write(path, content[:100])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=rf"{tmp_path}.*No space left on device(.|\n)*--resume"):
        run_campaign(plan, tmp_path, Pretended())
    assert sorted(parts(tmp_path)) == ["part-00000.parquet", "part-00001.parquet"]
    monkeypatch.undo()
    again = Pretended()
    run_campaign(plan, tmp_path, again)
    assert again.flown == [2, 3]


def test_two_campaigns_in_one_folder_at_once_are_refused(plan, tmp_path):
    run_campaign(plan, tmp_path, Pretended())
    handle = os.open(tmp_path / "runs", os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        with pytest.raises(InputError, match="another campaign is writing"):
            run_campaign(plan, tmp_path, Pretended())
    finally:
        os.close(handle)


def test_one_run_has_no_scatter(plan, tmp_path):
    with pytest.raises(InputError, match="2 or more"):
        run_campaign(replace(plan, runs=1), tmp_path / "none", Pretended())
    assert not (tmp_path / "none").exists()


def test_blocks_cover_every_run_once(plan):
    blocks = list(blocks_of(plan))
    assert [block.first for block in blocks] == [0, 50, 100, 150]
    assert sum(len(block.seeds) for block in blocks) == RUNS


def test_a_failed_run_leaves_its_numbers_empty(plan, tmp_path):
    from testbed.campaign.executor import BlockRows
    from testbed.campaign.kept_parts import KeptParts
    from testbed.campaign.runs import RunsFolder

    (block, *_) = blocks_of(plan)
    rows = [
        {"run": run, "seed": seed, "outcome": "failed", "message": "diverged"} for run, seed in enumerate(block.seeds)
    ]
    files = KeptParts(folder=tmp_path, checksums={}, record=lambda: None)
    kept = RunsFolder(parts=files, schema=schema_of(plan.scenario))
    kept.keep(BlockRows(block=block, rows=rows))
    assert kept.has(block)
    assert kept.table()["output_error_J11_kg_m2"].null_count == COMPILED_BLOCK_RUNS
