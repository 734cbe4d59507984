"""Curves in files of microscopes, with a substitute for afmformats; errors of one line."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

import restitution as rs

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


def give(monkeypatch, *records, error=None):
    def load_data(path):
        if error is not None:
            raise error
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
    with pytest.raises(rs.InputError, match=r"cannot be read: .*segment") as refused:
        rs.read_curves("gel.jpk-force", profile=TIP)
    assert "\n" not in str(refused.value)


def test_the_message_without_the_package_has_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "afmformats", None)
    with pytest.raises(rs.InputError, match="pip install afmformats"):
        rs.read_curves("gel.jpk-force", profile=TIP)
