"""Curves in files of microscopes, with a substitute for afmformats; errors of one line."""

import re
import sys
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

import restitution as rs
from refusals import in_one_line, named

TIP = rs.Parabola(2.5e-6)
TIME = np.linspace(0.0, 2.8, 200)
DEPTH = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
FORCE = rs.indent(rs.elastic(shear_modulus=300.0, poisson_ratio=0.5), TIP, depth=DEPTH - 4e-7, time=TIME).force
COLUMNS = {"time": TIME, "force": FORCE, "height (measured)": -DEPTH}


class Record(dict):
    """Columns, metadata and number of a curve, in the form of afmformats."""

    path, enum = "folder/gel.jpk-force", 3

    def __init__(self, columns, metadata):
        super().__init__(columns)
        self.metadata = metadata


class MissingMetaDataError(BaseException):
    """As in afmformats, which derives it from BaseException."""

    def __init__(self, *names):
        super().__init__("Missing meta data")
        self.meta_keys = list(names)


def give(monkeypatch, *records, error=None, needed=()):
    """Substitute afmformats by a reader of these records, which may need metadata, or raise an error."""

    def load_data(path, meta_override=None):
        if error is not None:
            raise error
        if missing := [name for name in needed if name not in (meta_override or {})]:
            raise MissingMetaDataError(*missing)
        for record in records:
            record.metadata |= meta_override or {}
        return list(records)

    monkeypatch.setitem(sys.modules, "afmformats", SimpleNamespace(load_data=load_data))


def test_a_record_becomes_a_curve(monkeypatch):
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5}))
    (read,) = rs.read_curves("gel.jpk-force", profile=TIP)
    curve = read()
    assert curve.label == "gel.jpk-force[3]"
    assert curve.spring_constant == 0.5
    assert np.array_equal(curve.depth, DEPTH)
    assert rs.read_curves("gel.jpk-force", profile=TIP, spring_constant=0.1)[0]().spring_constant == 0.1


def test_a_given_constant_scales_the_force(monkeypatch):
    """The force is spring constant times sensitivity times reading."""
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5, "sensitivity": 4e-8}))
    (read,) = rs.read_curves("gel.jpk-force", profile=TIP, spring_constant=0.1, sensitivity=6e-8)
    curve = read()
    np.testing.assert_allclose(curve.force, FORCE * (0.1 / 0.5) * (6e-8 / 4e-8), rtol=1e-14)
    assert curve.spring_constant == 0.1


def test_missing_metadata_are_asked_for_by_the_names_of_the_arguments(monkeypatch):
    needed = ("spring constant", "sensitivity")
    give(monkeypatch, Record(COLUMNS, {}), needed=needed)
    message = str(in_one_line(lambda: rs.read_curves("gel.txt", profile=TIP)))
    assert re.match(r"gel\.txt: .*spring_constant=.*sensitivity=", message)
    assert "spring" not in str(in_one_line(lambda: rs.read_curves("gel.txt", profile=TIP, spring_constant=0.1)))
    for options in (
        {"spring_constant": 0.1, "sensitivity": 5e-8},
        {"metadata": {"spring constant": 0.1, "sensitivity": 5e-8}},
    ):
        (read,) = rs.read_curves("gel.txt", profile=TIP, **options)
        assert read().spring_constant == 0.1
        assert np.array_equal(read().force, FORCE)
    with pytest.raises(rs.InputError, match=r"spring_constant = 0\.2: must be given once"):
        rs.read_curves("gel.txt", profile=TIP, spring_constant=0.2, metadata={"spring constant": 0.1})


@pytest.mark.parametrize("wrong", [{"spring_constant": -1.0}, {"sensitivity": "a"}, {"metadata": 3}, {"profile": 2}])
def test_wrong_arguments_are_refused(monkeypatch, wrong):
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5}))
    options = {"profile": TIP, "spring_constant": 0.1} | wrong
    assert named(lambda: rs.read_curves("gel.txt", **options)) == next(iter(wrong.items()))


def test_times_follow_from_the_rates(monkeypatch):
    segment = np.repeat([0, 1], TIME.size // 2)
    columns = {name: column for name, column in COLUMNS.items() if name != "time"} | {"segment": segment}
    give(monkeypatch, Record(columns, {"spring constant": 0.5}))
    rates = {"rate approach": 200.0, "rate retract": 50.0}
    (read,) = rs.read_curves("gel.txt", profile=TIP, metadata=rates)
    steps = np.diff(read().time)
    np.testing.assert_allclose(steps[: TIME.size // 2 - 1], 1 / 200.0, rtol=1e-9)
    np.testing.assert_allclose(steps[TIME.size // 2 - 1 :], 1 / 50.0, rtol=1e-9)
    (read,) = rs.read_curves("gel.txt", profile=TIP)
    with pytest.raises(rs.InputError, match=r"no column time.*rate approach"):
        read()


@pytest.mark.parametrize("missing", ["time", "force", "height (measured)", "spring constant"])
def test_an_incomplete_record_is_refused_alone(monkeypatch, missing):
    columns = {name: column for name, column in COLUMNS.items() if name != missing}
    metadata = {} if missing == "spring constant" else {"spring constant": 0.5}
    give(monkeypatch, Record(columns, metadata), Record(COLUMNS, {"spring constant": 0.5}))
    bad, good = rs.read_curves("gel.jpk-force", profile=TIP)
    with pytest.raises(rs.InputError, match=missing.replace(" ", "_").partition("_(")[0]):
        bad()
    assert good().size == TIME.size


def test_a_damaged_file_is_refused_in_one_line(monkeypatch):
    give(monkeypatch, error=KeyError("no\nsegment"))
    assert "segment" in str(in_one_line(lambda: rs.read_curves("gel.jpk-force", profile=TIP)))


def test_the_message_without_the_package_has_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "afmformats", None)
    with pytest.raises(rs.InputError, match="pip install afmformats"):
        rs.read_curves("gel.jpk-force", profile=TIP)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit()])
def test_an_interrupt_is_no_damaged_file(monkeypatch, error):
    give(monkeypatch, error=error)
    with pytest.raises(type(error)):
        rs.read_curves("gel.jpk-force", profile=TIP)


def test_the_errors_of_afmformats_itself(tmp_path):
    """Its readers raise errors that derive from BaseException; NT-MDT needs two constants."""
    pytest.importorskip("afmformats")
    file = tmp_path / "gel.txt"
    depth = np.linspace(0.0, 1000.0, 100)
    np.savetxt(file, np.stack([depth, depth, depth], axis=1), fmt="%.4f", header="a b c", comments="")
    for name in (file, tmp_path / "none.jpk-force", tmp_path / "none.strange"):
        in_one_line(partial(rs.read_curves, name, profile=TIP))
