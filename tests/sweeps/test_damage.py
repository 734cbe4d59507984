"""Damaged stores: readers refuse damage in one line, and the same sweep repairs it."""

import json
import multiprocessing
import random
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import restitution as rs
from cases import BALL, RUBBER
from checkout import tree
from refusals import in_one_line, warns
from restitution.errors import InputError
from restitution.sweeps import plan
from restitution.sweeps.store import _is_intact

# Many of these bodies exceed the limits of the theory.
pytestmark = pytest.mark.filterwarnings(r"ignore:.*; exceeded in \d+ of")

OUTPUTS = ["restitution_coefficient", "contact_time"]


def run(out: Path, n: int = 12) -> Any:
    """Sweep over n chunks of one point each."""
    axes = {"velocity": rs.Logarithmic(0.01, 10.0, n), "material": [RUBBER], "external_force": 0.0}
    return rs.sweep(BALL, axes, OUTPUTS, out=out, chunk=1)


@pytest.fixture(scope="module")
def intact_store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("made") / "result.zarr"
    run(out)
    return out


@pytest.fixture
def out(intact_store: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(intact_store, tmp_path / "result.zarr"))


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Indices of the chunks that are computed."""
    indices: list[Any] = []
    compute = plan.Plan.compute

    def watched(self: Any, index: Any, *rest: Any) -> Any:
        indices.append(index)
        return compute(self, index, *rest)

    monkeypatch.setattr(plan.Plan, "compute", watched)
    return indices


def flipped(content: bytes, bit: int) -> bytes:
    changed = bytearray(content)
    changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


@pytest.mark.parametrize("name", ["contact_time", "status", "velocity", "material", "external_force"])
def test_every_flipped_bit_is_noticed(intact_store: Path, out: Path, name: str, computed: list[Any]) -> None:
    folder = out / name / "c"
    chunk = next(path for path in (folder / "7" / "0", folder / "0", folder) if path.is_file())
    content = chunk.read_bytes()
    bits = range(8 * len(content))
    assert _is_intact(content)
    assert not any(_is_intact(flipped(content, bit)) for bit in bits)
    for bit in random.sample(bits, 2):
        chunk.write_bytes(flipped(content, bit))
        with pytest.raises(InputError, match=rf"result\.zarr: {chunk.relative_to(out)} is damaged; [^\n]+\Z"):
            rs.open_sweep(out).load()
        run(out)
        assert tree(out) == tree(intact_store), bit
    assert computed == ([(7, 0)] * 2 if name in (*OUTPUTS, "status") else [])


def remove(path: Path) -> None:
    path.unlink()


def empty(path: Path) -> None:
    path.write_bytes(b"")


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1])


def zero(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


def four_zeros(path: Path) -> None:
    # The checksum of an empty chunk.
    path.write_bytes(bytes(4))


@pytest.mark.parametrize("harm", [remove, empty, truncate, zero, four_zeros])
@pytest.mark.parametrize("name", ["restitution_coefficient", "status", "velocity"])
def test_remains_of_a_crash_are_reported_and_repaired(
    intact_store: Path, out: Path, name: str, harm: Callable[[Path], None], computed: list[Any]
) -> None:
    harm(out / name / "c" / ("0" if name == "velocity" else "7/0"))
    if (name, harm) == ("status", remove):
        # A chunk without its status counts as not computed.
        with warns("unfinished"):
            rs.open_sweep(out).load()
    else:
        assert in_one_line(lambda: rs.open_sweep(out).load()).where == str(out)
    run(out)
    assert computed == ([] if name == "velocity" else [(7, 0)])
    assert tree(out) == tree(intact_store)


@pytest.mark.parametrize("name", ["restitution_coefficient", "status", "velocity", "material"])
def test_a_missing_folder_of_a_variable_is_restored(intact_store: Path, out: Path, name: str) -> None:
    shutil.rmtree(out / name)
    assert in_one_line(lambda: rs.open_sweep(out).load()).where == str(out)
    run(out)
    assert tree(out) == tree(intact_store)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("contact_time/zarr.json", '"NaN"', "0.5"),
        ("contact_time/zarr.json", '"float64"', '"float32"'),
        ("zarr.json", '"float64"', '"float32"'),
        ("zarr.json", '"rtol\\"', '"atol\\"'),
        ("velocity/zarr.json", "12", "11"),
    ],
)
def test_edited_metadata_are_reported_and_repaired(
    intact_store: Path, out: Path, file: str, old: str, new: str, computed: list[Any]
) -> None:
    text = (out / file).read_text()
    assert old.replace('\\"', '\\"') in text
    (out / file).write_text(text.replace(old, new, 1))
    assert in_one_line(lambda: rs.open_sweep(out)).where == str(out)
    run(out)
    assert tree(out) == tree(intact_store)
    assert computed == []


@pytest.mark.parametrize("content", [b"", b"{", b"[" * 100_000, b'{"attributes": 3}', b"\xff\xfe"])
def test_a_folder_that_is_no_store_is_not_changed(out: Path, content: bytes) -> None:
    (out / "zarr.json").write_bytes(content)
    before = tree(out)
    for attempt in (run, rs.open_sweep):
        assert in_one_line(partial(attempt, out)).where == str(out)
    assert tree(out) == before


@pytest.mark.parametrize("value", [[1], "{", 7, None])
def test_an_invalid_description_is_refused_in_one_line(out: Path, value: Any) -> None:
    content = json.loads((out / "zarr.json").read_text())
    content["attributes"] |= {"sweep": value, "hash": "0" * 64}
    (out / "zarr.json").write_text(json.dumps(content))
    for attempt in (run, rs.open_sweep):
        assert in_one_line(partial(attempt, out)).where == str(out)


def test_other_files_among_the_chunks_are_ignored(intact_store: Path, out: Path, computed: list[Any]) -> None:
    (out / "status" / "c" / "99999").mkdir()
    (out / "status" / "c" / "99999" / "0").write_text("x")
    (out / "status" / "c" / "9" / "0").unlink()
    (out / "status" / "c" / "888").write_text("x")
    (out / "status" / "c" / "-1").write_text("x")
    done: list[int] = []
    rs.sweep(
        BALL,
        {"velocity": rs.Logarithmic(0.01, 10.0, 12), "material": [RUBBER], "external_force": 0.0},
        OUTPUTS,
        out=out,
        chunk=1,
        progress=lambda points, _: done.append(points),
    )
    assert (done[0], done[-1]) == (11, 12)
    assert computed == [(9, 0)]
    assert (out / "status" / "c" / "9" / "0").read_bytes() == (intact_store / "status" / "c" / "9" / "0").read_bytes()


def test_links_and_files_in_the_way_are_refused_by_name(out: Path, tmp_path: Path) -> None:
    shutil.rmtree(out / "status" / "c" / "7")
    (out / "status" / "c" / "7").symlink_to(".")
    with pytest.raises(InputError, match="status/c/7 is a link"):
        run(out)
    (out / "status" / "c" / "7").unlink()
    (out / "status" / "c" / "7").write_text("x")
    with pytest.raises(InputError, match="status/c/7 must be a folder"):
        run(out)
    (out / "status" / "c" / "7").unlink()
    (out / "status" / "c" / "7" / "0").mkdir(parents=True)
    with pytest.raises(InputError, match="status/c/7/0 must be a file"):
        run(out)


def test_a_chunk_of_nan_counts_as_computed(tmp_path: Path, computed: list[Any]) -> None:
    def build(radius: float) -> rs.Impact:
        if radius == 0.02:
            raise InputError("radius", radius, "must not be this one")
        return rs.Impact(RUBBER, rs.Parabola(radius), mass=0.005, velocity=1.0)

    for _ in range(2):
        with warns("failed"):
            result = rs.sweep(
                build, {"radius": [0.01, 0.02, 0.03]}, ["contact_time"], out=tmp_path / "nan.zarr", chunk=1
            )
        assert np.isnan(result.contact_time.values).tolist() == [False, True, False]
    assert sorted(computed) == [(0,), (1,), (2,)]


def test_an_exchanged_chunk_is_noticed_and_repaired(intact_store: Path, out: Path, computed: list[Any]) -> None:
    """A chunk of another variable or another place has a right checksum, and wrong numbers."""
    intact = rs.open_sweep(intact_store).load()
    places = [(name, n) for name in OUTPUTS for n in range(12)]
    for _ in range(6):
        (name, i), (other, j) = random.sample(places, 2)
        shutil.copyfile(out / other / "c" / str(j) / "0", out / name / "c" / str(i) / "0")
        with pytest.raises(InputError, match=f"{name}/c/{i}/0 is damaged: it is another chunk; "):
            rs.open_sweep(out).load()
        computed.clear()
        assert run(out).identical(intact)
        assert computed == [(i, 0)]
        assert tree(out) == tree(intact_store)


def test_chunks_exchanged_with_their_records_are_noticed(intact_store: Path, out: Path) -> None:
    """Everything of one place in the files of another one."""
    i, j = random.sample(range(12), 2)
    for name in (*OUTPUTS, "status"):
        shutil.copyfile(intact_store / name / "c" / str(j) / "0", out / name / "c" / str(i) / "0")
    shutil.copyfile(intact_store / "validity" / f"c-{j}-0", out / "validity" / f"c-{i}-0")
    assert in_one_line(lambda: rs.open_sweep(out).load()).where == str(out)
    run(out)
    assert tree(out) == tree(intact_store)


def _start(out: Path, barrier: Any, answers: Any) -> None:
    barrier.wait()
    try:
        run(out)
        answers.put("done")
    except ValueError as error:
        answers.put(str(error))


def test_any_bit_of_any_file_is_noticed(intact_store: Path, out: Path) -> None:
    """With one random bit of the store flipped, a reader refuses the store or reads the same numbers."""
    intact = rs.open_sweep(intact_store).load()
    files = sorted(path for path in out.rglob("*") if path.is_file())
    for file in random.choices(files, weights=[file.stat().st_size for file in files], k=40):
        content = file.read_bytes()
        file.write_bytes(flipped(content, bit := random.randrange(8 * len(content))))
        try:
            read = rs.open_sweep(out).load()
        except InputError:
            pass
        else:
            # The store has a second copy of the metadata of each array.
            assert read.identical(intact), (file.relative_to(out), bit)
        file.write_bytes(content)


@pytest.mark.slow
def test_two_processes_start_the_same_sweep_at_once(
    intact_store: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parents[2])  # the processes import this module
    context = multiprocessing.get_context("spawn")
    for n in range(2):
        out, barrier, answers = tmp_path / f"{n}.zarr", context.Barrier(2), context.Queue()
        processes = [context.Process(target=_start, args=(out, barrier, answers)) for _ in range(2)]
        for process in processes:
            process.start()
        ends = sorted(answers.get(timeout=600) for _ in processes)
        for process in processes:
            process.join()
        assert ends[-1] == "done"
        assert ends[0] == "done" or ends[0].endswith("another process is writing it")
        assert tree(out) == tree(intact_store)
