"""Curves in files of microscopes, with a substitute for afmformats; errors of one line."""

import logging
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import restitution as rs
from checkout import blocks

TIP = rs.Parabola(2.5e-6)
TIME = np.linspace(0.0, 2.8, 200)
DEPTH = np.interp(TIME, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
FORCE = rs.indent(rs.elastic(shear_modulus=300.0, poisson_ratio=0.5), TIP, depth=DEPTH - 4e-7, time=TIME).force
COLUMNS = {"time": TIME, "force": FORCE, "height (measured)": -DEPTH}
HEIGHTS = ["height (piezo)", "height (measured)"]
SEGMENT = np.repeat([0, 1], TIME.size // 2)


class Record(dict):
    """Columns, metadata and number of a curve, in the form of afmformats."""

    enum = 3

    def __init__(self, columns, metadata):
        super().__init__(columns)
        self.metadata = metadata


class MissingMetaDataError(BaseException):
    """As in afmformats, which derives it from BaseException."""

    def __init__(self, *names):
        super().__init__("Missing meta data")
        self.meta_keys = list(names)


def give(monkeypatch, *records, error=None, needed=(), **files):
    """Substitute afmformats by a reader of these records, which may need metadata, or raise an error.

    Files have records by the stems of their names.
    """

    def load_data(path, meta_override=None):
        logging.getLogger("afmformats.formats").exception("Loader failed. Traceback follows.")
        if error is not None:
            raise error
        if missing := [name for name in needed if name not in (meta_override or {})]:
            raise MissingMetaDataError(*missing)
        curves = files.get(Path(path).stem, records)
        for record in curves:
            record.metadata |= meta_override or {}
        return list(curves)

    module = SimpleNamespace(load_data=load_data, supported_extensions=[".h5", ".tab"])
    monkeypatch.setitem(sys.modules, "afmformats", module)


def test_a_record_becomes_a_curve(monkeypatch):
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5}))
    (read,) = rs.read_curves("gel.h5", profile=TIP)
    curve = read()
    assert curve.label == "gel.h5[3]"
    assert curve.spring_constant == 0.5
    assert np.array_equal(curve.depth, DEPTH)
    assert curve.source == "depth: -height (measured) less force / (0.5 N/m); time: of the file; 1 segment"
    assert rs.read_curves("gel.h5", profile=TIP, spring_constant=0.1)[0]().spring_constant == 0.1


def test_the_first_approach_alone(monkeypatch):
    columns = COLUMNS | {"force": FORCE - 1e-10 * np.exp(-(((TIME - 2.5) / 0.1) ** 2))}
    give(monkeypatch, Record(columns, {"spring constant": 0.5}))
    file = rs.read_curves("gel.h5", profile=TIP)
    with pytest.raises(rs.InputError, match=r'adhesion.*segment="approach"'):
        file[0]()
    assert file[0]("approach").time[-1] == pytest.approx(1.4, abs=0.03)
    assert file.read("approach")[0].time[-1] == pytest.approx(1.4, abs=0.03)


def test_a_given_constant_scales_the_force(monkeypatch):
    """The force is spring constant times sensitivity times reading."""
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5, "sensitivity": 4e-8}))
    (read,) = rs.read_curves("gel.h5", profile=TIP, spring_constant=0.1, sensitivity=6e-8)
    curve = read()
    np.testing.assert_allclose(curve.force, FORCE * (0.1 / 0.5) * (6e-8 / 4e-8), rtol=1e-14)
    assert curve.spring_constant == 0.1


@pytest.mark.parametrize("seed", range(20))
def test_columns_and_segments_of_any_number_and_order(monkeypatch, seed):
    """All points are kept; the deflection is subtracted once, from the height alone, whose sign may be the other."""
    rng = np.random.default_rng(seed)
    stiffness, sign, count = rng.uniform(0.01, 10.0), rng.choice([-1.0, 1.0]), int(rng.integers(2, 7))
    # The first segments are approach, hold and retraction; the file may split them further.
    cuts = np.unique(np.concatenate([[0, TIME.size // 2], rng.choice(np.arange(120, 190), count - 2, replace=False)]))
    columns = {
        "time": TIME, "force": FORCE, "segment": np.searchsorted(cuts, np.arange(TIME.size), side="right") - 1,
    }  # fmt: skip
    height = sign * -(DEPTH + FORCE / stiffness)
    columns |= dict.fromkeys(HEIGHTS[: rng.integers(1, 3)], height)
    if subtracted := bool(rng.integers(2)):
        columns["tip position"] = sign * -DEPTH
    columns = {name: columns[name] for name in rng.permutation(list(columns))}
    give(monkeypatch, Record(columns, {"spring constant": stiffness}))
    curve = rs.read_curves("gel.h5", profile=TIP)[0]()
    assert np.array_equal(curve.time, TIME)
    assert np.array_equal(curve.force, FORCE)
    bend = 0.0 if curve.spring_constant is None else curve.force / curve.spring_constant
    np.testing.assert_allclose(curve.depth - bend, DEPTH, atol=1e-20)
    assert curve.spring_constant == (None if subtracted else stiffness)
    assert ("has subtracted the deflection" in curve.source) == subtracted
    assert curve.source.endswith(f"{count} segments")


@pytest.mark.filterwarnings("ignore:straight lines")
def test_a_tip_position_follows_a_given_sensitivity(monkeypatch):
    """The tip is at z + F/k, and F/k is the sensitivity times the reading."""
    stiffness, sensitivity, corrected = 0.05, 4e-8, 6e-8
    height = -DEPTH - FORCE / stiffness
    columns = {"time": TIME, "force": FORCE, "tip position": height + FORCE / stiffness}
    give(monkeypatch, Record(columns, {"spring constant": stiffness, "sensitivity": sensitivity}))
    curve = rs.read_curves("gel.h5", profile=TIP, sensitivity=corrected)[0]()
    np.testing.assert_allclose(curve.depth, -height - corrected / sensitivity * FORCE / stiffness, atol=1e-20)
    assert curve.spring_constant is None
    give(monkeypatch, Record(columns, {"sensitivity": sensitivity}))
    assert np.array_equal(rs.read_curves("gel.h5", profile=TIP)[0]().depth, -columns["tip position"])
    with pytest.raises(rs.InputError, match="has no spring constant: give spring_constant="):
        rs.read_curves("gel.h5", profile=TIP, sensitivity=corrected)[0]()


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_approach_of_a_relaxation_is_the_second_segment(monkeypatch, sign):
    """Before it the tip rests."""
    rest = 20
    time = np.arange(TIME.size + rest) * TIME[1]
    depth, force = (np.concatenate([np.full(rest, column[0]), column]) for column in (DEPTH, FORCE))
    segment = np.repeat([0, 1, 2], [rest, 100, 100])
    columns = {"time": time, "force": force, "height (measured)": -sign * depth, "segment": segment}
    give(monkeypatch, Record(columns, {"spring constant": 0.5, "imaging mode": "stress-relaxation"}))
    assert np.array_equal(rs.read_curves("gel.h5", profile=TIP)[0]().depth, depth)


def test_a_height_of_unknown_sign_is_refused(monkeypatch):
    """No segment is named an approach."""
    give(monkeypatch, Record(COLUMNS | {"height (measured)": DEPTH}, {"spring constant": 0.5}))
    with pytest.raises(rs.InputError, match=r"^gel\.h5\[3\]: depth: falls during the approach: give -height$"):
        rs.read_curves("gel.h5", profile=TIP)[0]()


def test_missing_metadata_are_asked_for_by_the_names_of_the_arguments(monkeypatch):
    needed = ("spring constant", "sensitivity")
    give(monkeypatch, Record(COLUMNS, {}), needed=needed)
    with pytest.raises(rs.InputError, match=r"^gel\.txt\[3\]: .*spring_constant=.*sensitivity=") as refused:
        rs.read_curves("gel.txt", profile=TIP)[0]()
    assert "\n" not in str(refused.value)
    give(monkeypatch, Record(COLUMNS, {}), needed=needed)
    with pytest.raises(rs.InputError, match="give sensitivity=") as refused:
        rs.read_curves("gel.txt", profile=TIP, spring_constant=0.1)[0]()
    assert "spring" not in str(refused.value)
    for options in (
        {"spring_constant": 0.1, "sensitivity": 5e-8},
        {"metadata": {"spring constant": 0.1, "sensitivity": 5e-8}},
    ):
        give(monkeypatch, Record(COLUMNS, {}), needed=needed)
        (read,) = rs.read_curves("gel.txt", profile=TIP, **options)
        assert read().spring_constant == 0.1
        assert np.array_equal(read().force, FORCE)
    with pytest.raises(rs.InputError, match=r"spring_constant = 0\.2: must be given once"):
        rs.read_curves("gel.txt", profile=TIP, spring_constant=0.2, metadata={"spring constant": 0.1})


@pytest.mark.parametrize(
    "options",
    [
        {"spring_constant": -1.0}, {"sensitivity": "a"}, {"metadata": 3}, {"profile": 2}, {"rate": 0.0},
        {"duration": [1.0, np.nan]}, {"duration": 1.0, "rate": 1.0},
    ],
)  # fmt: skip
def test_wrong_arguments_are_refused(monkeypatch, options):
    give(monkeypatch, Record(COLUMNS, {"spring constant": 0.5}))
    with pytest.raises(rs.InputError, match=next(iter(options))):
        rs.read_curves("gel.txt", **{"profile": TIP, "spring_constant": 0.1} | options)


@pytest.mark.parametrize("seed", range(10))
def test_times_follow_from_a_rate_or_a_duration(monkeypatch, seed):
    """A segment of n points at the rate r lasts n/r."""
    rng = np.random.default_rng(seed)
    counts = np.array([100, *rng.multinomial(100 - rng.integers(3), [0.3, 0.3, 0.4])])
    counts[-1] += TIME.size - counts.sum()
    columns = COLUMNS | {"segment": np.repeat(np.arange(counts.size), counts)}
    if rng.integers(2):
        del columns["time"]
    give(monkeypatch, Record(columns, {"spring constant": 0.5}))
    rates = rng.uniform(10.0, 1e4, counts.size)
    rate = rng.uniform(10.0, 1e4)
    starts = np.concatenate([[0.0], np.cumsum(counts / rates)])
    expected = np.concatenate([starts[n] + np.arange(count) / rates[n] for n, count in enumerate(counts)])
    for options, times in (
        ({"rate": rate}, np.arange(TIME.size) / rate),
        ({"duration": TIME.size / rate}, np.arange(TIME.size) / rate),
        ({"rate": rates}, expected),
        ({"duration": list(counts / rates)}, expected),
    ):
        curve = rs.read_curves("gel.h5", profile=TIP, **options)[0]()
        np.testing.assert_allclose(curve.time, times, rtol=1e-12, atol=1e-12 * times[-1])
        assert f"time: from {next(iter(options))}" in curve.source
    with pytest.raises(rs.InputError, match=r"rate = \[1\.0, 2\.0, 3\.0\]: must be one number, or one for each of 4"):
        rs.read_curves("gel.h5", profile=TIP, rate=[1.0, 2.0, 3.0])[0]()


def test_times_follow_from_the_rates_of_the_metadata(monkeypatch):
    columns = {name: column for name, column in COLUMNS.items() if name != "time"} | {"segment": SEGMENT}
    give(monkeypatch, Record(columns, {"spring constant": 0.5}))
    rates = {"rate approach": 200.0, "rate retract": 50.0}
    (read,) = rs.read_curves("gel.txt", profile=TIP, metadata=rates)
    half = TIME.size // 2
    expected = np.concatenate([np.arange(half) / 200.0, half / 200.0 + np.arange(half) / 50.0])
    np.testing.assert_allclose(read().time, expected, rtol=1e-12)
    (read,) = rs.read_curves("gel.txt", profile=TIP)
    with pytest.raises(rs.InputError, match=r"no column time: give rate=.*duration="):
        read()


@pytest.mark.parametrize("seed", range(10))
def test_an_incomplete_record_is_refused_alone(monkeypatch, seed):
    """One line names all that is missing, and does not lose the other curves."""
    rng = np.random.default_rng(seed)
    missing = set(rng.choice(["time", "force", "height (measured)", "spring constant"], rng.integers(1, 5), False))
    columns = {name: column for name, column in COLUMNS.items() if name not in missing}
    constants = {} if "spring constant" in missing else {"spring constant": 0.5}
    good = Record(COLUMNS, {"spring constant": 0.5})
    give(monkeypatch, good, Record(columns, constants), good)
    result = rs.read_curves("gel.h5", profile=TIP)
    with pytest.raises(rs.InputError) as refused:
        result[1]()
    line = str(refused.value)
    assert "\n" not in line
    columns_missing = missing & {"force", "height (measured)"}
    for name in columns_missing or missing:
        assert f"{name}" in line
    if not columns_missing:
        assert [f"{name}=" in line for name in ("rate", "duration", "spring_constant")] == [
            "time" in missing, "time" in missing, "spring constant" in missing
        ]  # fmt: skip
    with pytest.warns(rs.RestitutionWarning) as caught:
        assert [curve.size for curve in result.read()] == [TIME.size] * 2
    assert [str(warning.message) for warning in caught] == [line]


def test_without_a_curve_that_can_be_read_the_error_is_raised(monkeypatch):
    give(monkeypatch, Record({"time": TIME}, {}))
    with pytest.raises(rs.InputError, match="no column force"):
        rs.read_curves("gel.h5", profile=TIP).read()


@pytest.mark.parametrize("force", [FORCE[:-1], FORCE[:0], FORCE.reshape(2, -1)])
def test_columns_of_other_shapes_are_refused(monkeypatch, force):
    give(monkeypatch, Record(COLUMNS | {"force": force, "segment": SEGMENT}, {"spring constant": 0.5}))
    with pytest.raises(rs.InputError, match=r"equal length > 0.*force"):
        rs.read_curves("gel.h5", profile=TIP)[0]()


def test_an_archive_holds_curves_of_several_files(monkeypatch, tmp_path):
    """A damaged file, and a curve that lacks a column, are refused alone; other files are passed over."""
    good, bad = Record(COLUMNS, {"spring constant": 0.5}), Record({"time": TIME}, {})
    give(monkeypatch, error=None, one=[good], two=[bad, good], three=3)
    file = tmp_path / "gels.zip"
    with zipfile.ZipFile(file, "w") as archive:
        for name in ("one.h5", "folder/two.tab", "three.h5", "notes.md"):
            archive.writestr(name, "")
    result = rs.read_curves(file, profile=TIP)
    assert [read.label for read in result] == [
        "gels.zip/one.h5[3]", "gels.zip/folder/two.tab[3]", "gels.zip/folder/two.tab[3]", "gels.zip/three.h5"
    ]  # fmt: skip
    with pytest.warns(rs.RestitutionWarning) as caught:
        curves = result.read()
    assert [np.array_equal(curve.force, FORCE) for curve in curves] == [True, True]
    assert [str(warning.message).partition(": ")[0] for warning in caught] == [result[1].label, result[3].label]
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("notes.md", "")
    with pytest.raises(rs.InputError, match=r"must hold files that afmformats reads: \.h5, \.tab"):
        rs.read_curves(file, profile=TIP)


def test_a_damaged_file_is_refused_in_one_line(monkeypatch, caplog):
    give(monkeypatch, error=KeyError("no\nsegment"))
    with pytest.raises(rs.InputError, match=r"cannot be read: .*segment") as refused:
        rs.read_curves("gel.h5", profile=TIP)
    assert "\n" not in str(refused.value)
    assert not caplog.records


def test_the_message_without_the_package_has_the_remedy(monkeypatch):
    monkeypatch.setitem(sys.modules, "afmformats", None)
    for name in ("gel.h5", "gel.jpk-force"):
        with pytest.raises(rs.InputError, match="pip install afmformats"):
            rs.read_curves(name, profile=TIP)


@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit()])
def test_an_interrupt_is_no_damaged_file(monkeypatch, error):
    give(monkeypatch, error=error)
    with pytest.raises(type(error)):
        rs.read_curves("gel.h5", profile=TIP)


def test_a_map_keeps_the_line_of_a_refused_curve(monkeypatch):
    good = Record(COLUMNS | {"height (measured)": -DEPTH - FORCE / 0.5}, {"spring constant": 0.5})
    give(monkeypatch, good, Record({"time": TIME}, {}), good)
    result = rs.identify_map(
        rs.read_curves("gel.h5", profile=TIP), rs.elastic, fixed={"poisson_ratio": 0.5}, progress=False
    )
    assert result["status"].values.tolist() == [0, 3, 0]
    assert "gel.h5[3]: has no column" in str(result["message"].values[1])
    # The material of the record.
    np.testing.assert_allclose(result["shear_modulus"].values[[0, 2]], 300.0, rtol=1e-3)


@pytest.mark.parametrize("dwell_rate", [0, 1])
@pytest.mark.parametrize("seed", range(4))
def test_segments_of_asylum_research_stand_in_the_note(monkeypatch, seed, dwell_rate):
    """A hold may have a rate of its own; without one the points are equally spaced."""
    rng = np.random.default_rng(seed)
    rate, sign, hold = rng.uniform(50.0, 5000.0), rng.choice([-1.0, 1.0]), bool(rng.integers(2))
    ends = [99, int(rng.integers(105, 150)), TIME.size - 1] if hold else [99, TIME.size - 1]
    way = "1,0,-1" if hold else "1,-1"
    lines = ["Version:1", f"UseDwellRate: {dwell_rate}", "DwellRate: 10", f"Indexes: 0,{','.join(map(str, ends))}"]
    lines.append(f"Direction: NaN,{way},")
    module = SimpleNamespace(load=lambda path: {"wave": {"note": "\r".join(lines).encode()}})
    monkeypatch.setitem(sys.modules, "igor2.binarywave", module)
    columns = {"force": FORCE, "segment": 0 * SEGMENT, "height (measured)": -sign * DEPTH}
    metadata = {"spring constant": 0.5, "rate approach": rate, "rate retract": rate}
    give(monkeypatch, Record(columns, metadata))
    (read,) = rs.read_curves("gel.ibw", profile=TIP)
    assert np.array_equal(read.record().segments[0], np.diff([-1, *ends]))
    if hold and dwell_rate:
        with pytest.raises(rs.InputError, match=r"no column time: give rate=.*each of 3 segments"):
            read()
        (read,) = rs.read_curves("gel.ibw", profile=TIP, rate=[rate, rate, rate])
    curve = read()
    np.testing.assert_allclose(curve.time, np.arange(TIME.size) / rate, rtol=1e-12)
    assert np.array_equal(curve.depth, DEPTH)


def test_a_note_without_segments_leaves_one(monkeypatch):
    monkeypatch.setitem(
        sys.modules, "igor2.binarywave", SimpleNamespace(load=lambda path: {"wave": {"note": b"Indexes: NaN\rx"}})
    )
    metadata = {"spring constant": 0.5, "rate approach": 100.0, "rate retract": 100.0}
    give(monkeypatch, Record({"force": FORCE, "segment": 0 * SEGMENT, "height (measured)": -DEPTH}, metadata))
    curve = rs.read_curves("gel.ibw", profile=TIP)[0]()
    np.testing.assert_allclose(curve.time, np.arange(TIME.size) / 100.0, rtol=1e-12)
    assert curve.source.endswith("1 segment")


# Files of JPK: a substitute for the reader of afmformats, then afmformats itself with small files.

STYLES = ("extend", "pause", "retract", "modulation")
# Unit of the integers in a file [m, N].
MULTIPLIER = 1e-13


class JpkReader:
    """The part of the reader of afmformats that is used, for one curve of given segments."""

    segments = ()

    def __init__(self, path):
        self.stated = {}

    @property
    def files(self):
        return [
            name
            for n, (_, columns, _) in enumerate(self.segments)
            for name in (f"segments/{n}/", *(f"segments/{n}/channels/{column}.dat" for column in columns))
        ]

    def get_index_numbers(self):
        return np.array([7])

    def get_index_path(self, index):
        return ""

    def get_index_segment_path(self, index, segment):
        return f"segments/{segment}/"

    def set_metadata(self, metadata):
        self.stated = metadata

    def get_metadata_jpk_primary(self, index, segment):
        duration = self.segments[segment][2]
        times = {} if duration is None else {"duration": duration}
        return {"spring constant": 0.5, "sensitivity": 1e-8, "point count": 1} | times | self.stated

    def get_metadata_jpk_secondary(self, index, segment):
        return {"curve type": self.segments[segment][0]}

    def get_data(self, column, index, segment):
        return self.segments[segment][1][{"force": "vDeflection"}.get(column, "measuredHeight")]


def jpk_segments(seed):
    """Segments of random styles and lengths of a record; one of them is the approach."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    styles = ["pause"] * int(rng.integers(2)) + ["extend"] + [str(style) for style in rng.choice(STYLES, count)]
    cuts = [0, 20] if styles[0] == "pause" else [0]
    cuts += [100, *sorted(rng.choice(np.arange(105, 195), len(styles) - len(cuts) - 1, replace=False)), TIME.size]
    cuts = [*cuts[: len(styles)], TIME.size]
    height = -rng.choice([-1.0, 1.0]) * (DEPTH + FORCE / 0.5)
    segments = [
        (style, {"vDeflection": FORCE[a:b], "measuredHeight": height[a:b]}, float(rng.uniform(0.1, 2.0)))
        for style, a, b in zip(styles, cuts[:-1], cuts[1:], strict=True)
    ]
    sizes = np.diff(cuts)
    durations = np.array([duration for *_, duration in segments])
    starts = np.cumsum(durations) - durations
    times = np.concatenate(
        [start + np.arange(n) * d / n for start, n, d in zip(starts, sizes, durations, strict=True)]
    )
    return segments, times


@pytest.fixture
def jpk(monkeypatch):
    monkeypatch.setattr(JpkReader, "segments", ())
    channels = {"force": ["vDeflection"], "height (measured)": ["strainGaugeHeight", "measuredHeight"]}
    monkeypatch.setitem(sys.modules, "afmformats", SimpleNamespace())
    for name, module in {"jpk_reader": {"JPKReader": JpkReader}, "jpk_data": {"JPK_COLUMNS": channels}}.items():
        monkeypatch.setitem(sys.modules, f"afmformats.formats.fmt_jpk.{name}", SimpleNamespace(**module))
    return JpkReader


@pytest.mark.parametrize("seed", range(10))
def test_all_segments_of_a_file_of_jpk_are_read(jpk, seed):
    jpk.segments, times = jpk_segments(seed)
    (read,) = rs.read_curves("gel.jpk-force", profile=TIP)
    assert read.label == "gel.jpk-force[7]"
    curve = read()
    assert np.array_equal(curve.force, FORCE)
    np.testing.assert_allclose(curve.depth, DEPTH + FORCE / 0.5, atol=1e-20)
    np.testing.assert_allclose(curve.time, times, rtol=1e-12)
    assert curve.source.endswith(f"{len(jpk.segments)} segments")


def test_the_example_of_the_page(jpk, capsys):
    jpk.segments = [
        (style, {"vDeflection": FORCE[part], "measuredHeight": -DEPTH[part]}, 1.0)
        for style, part in zip(STYLES, (slice(0, 100), slice(100, 120), slice(120, 200)), strict=False)
    ]
    (code,) = blocks("docs/identification/afm.md", "py")
    exec(code, {"rs": rs})
    assert [f"# {line}" for line in capsys.readouterr().out.splitlines()] == [code.splitlines()[-1]]


def test_a_segment_of_jpk_without_a_duration_needs_a_rate(jpk):
    jpk.segments = [(style, columns, None) for style, columns, _ in jpk_segments(0)[0]]
    with pytest.raises(rs.InputError, match=r"no column time: give rate="):
        rs.read_curves("gel.jpk-force", profile=TIP)[0]()
    curve = rs.read_curves("gel.jpk-force", profile=TIP, rate=100.0)[0]()
    np.testing.assert_allclose(curve.time, np.arange(TIME.size) / 100.0, rtol=1e-12)


def test_a_file_of_jpk_without_segments_or_channels_is_refused(jpk):
    with pytest.raises(rs.InputError, match=r"^gel\.jpk-force\[7\]: has no segments"):
        rs.read_curves("gel.jpk-force", profile=TIP)[0]()
    jpk.segments = [(style, {"vDeflection": columns["vDeflection"]}, d) for style, columns, d in jpk_segments(0)[0]]
    with pytest.raises(rs.InputError, match="no column tip position or height"):
        rs.read_curves("gel.jpk-force", profile=TIP)[0]()


def write_jpk(path, segments, constants=("distance", "force")):
    """Write a file in the format of JPK: integers, and properties that turn them into N and m."""
    multiplier = {"distance": 1e-8, "force": 0.5}
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.properties", "type=force-scan-series\n")
        archive.writestr("segments/", "")
        for n, (style, columns, duration) in enumerate(segments):
            archive.writestr(f"segments/{n}/", "")
            lines = [f"force-segment-header.settings.style={style}", f"force-segment-header.duration={duration}"]
            for name, column in columns.items():
                channel, set_ = f"channel.{name}", f"channel.{name}.conversion-set"
                # The reading of the deflection is a voltage.
                unit = MULTIPLIER / (1e-8 * 0.5) if name == "vDeflection" else MULTIPLIER
                numbers = np.round(column / MULTIPLIER)
                archive.writestr(f"segments/{n}/channels/{name}.dat", numbers.astype(">i4").tobytes())
                lines += [
                    f"{channel}.data.encoder.type=signedinteger",
                    f"{channel}.data.encoder.scaling.multiplier={unit!r}",
                    f"{channel}.data.encoder.scaling.offset=0.0",
                    f"{set_}.conversions.base=volts",
                ]
                lines.append(f"{set_}.conversion.force.name=Force")
                slots = {slot: multiplier[slot] for slot in constants} if name == "vDeflection" else {"nominal": 1.0}
                for slot, base in zip(slots, ("volts", "distance"), strict=False):
                    part = f"{set_}.conversion.{slot}"
                    lines += [
                        f"{part}.scaling.multiplier={slots[slot]!r}", f"{part}.scaling.offset=0.0",
                        f"{part}.base-calibration-slot={base}", f"{part}.name={slot}",
                        f"{part}.scaling.unit.unit={'N' if slot == 'force' else 'm'}",
                    ]  # fmt: skip
            lines.append(f"force-segment-header.num-points={len(columns['vDeflection'])}")
            archive.writestr(f"segments/{n}/segment-header.properties", "\n".join(lines))


@pytest.mark.parametrize("seed", range(5))
def test_files_of_jpk_with_afmformats_itself(tmp_path, seed):
    pytest.importorskip("afmformats")
    segments, times = jpk_segments(seed)
    write_jpk(tmp_path / "gel.jpk-force", segments)
    curve = rs.read_curves(tmp_path / "gel.jpk-force", profile=TIP)[0]()
    assert curve.spring_constant == 0.5
    np.testing.assert_allclose(curve.time, times, rtol=1e-12)
    # Half a unit of the integers.
    np.testing.assert_allclose(curve.force, FORCE, atol=0.51 * MULTIPLIER)
    np.testing.assert_allclose(curve.depth, DEPTH + FORCE / 0.5, atol=0.51 * MULTIPLIER)


def test_constants_that_a_file_of_jpk_lacks(tmp_path):
    pytest.importorskip("afmformats")
    file = tmp_path / "gel.jpk-force"
    write_jpk(file, jpk_segments(1)[0], constants=("distance",))
    with pytest.raises(rs.InputError, match=r"^gel\.jpk-force\[0\]: has no spring constant: give spring_constant="):
        rs.read_curves(file, profile=TIP)[0]()
    curve = rs.read_curves(file, profile=TIP, spring_constant=0.5)[0]()
    np.testing.assert_allclose(curve.force, FORCE, atol=0.51 * MULTIPLIER)


def write_workshop(path, volts):
    """Write a file in the format of AFM Workshop, which has no times; its height increases towards the surface."""
    half, unit = TIME.size // 2, "T-B(V)" if volts else "Force(nN)"
    reading = FORCE / (5e-8 * 0.5) if volts else 1e9 * FORCE
    height = 1e9 * (DEPTH + FORCE / 0.5)
    rows = np.column_stack([height[:half], reading[:half], height[half:], reading[half:]])
    header = f"Extend Z-Sense(nm),Extend {unit},Retract Z-Sense(nm),Retract {unit}"
    head = f"Force-Distance Curve\n\nDate:\t22 October 2020\nTime:\t14:16:20\nMode:\tSingle\nPoint:\t1\n\n{header}"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.17g")


@pytest.mark.parametrize("volts", [True, False])
def test_files_of_afm_workshop(tmp_path, volts):
    pytest.importorskip("afmformats")
    file = tmp_path / "gel.csv"
    write_workshop(file, volts)
    lacks = (
        "no sensitivity, no spring constant and no column time" if volts else "no spring constant and no column time"
    )
    with pytest.raises(rs.InputError, match=f"has {lacks}: give .*duration="):
        rs.read_curves(file, profile=TIP)[0]()
    options = {"spring_constant": 0.5} | ({"sensitivity": 5e-8} if volts else {})
    with zipfile.ZipFile(tmp_path / "gel.zip", "w") as archive:
        archive.write(file, "1.csv")
        archive.write(file, "2.csv")
    both = rs.read_curves(tmp_path / "gel.zip", profile=TIP, duration=2.8, **options).read()
    for curve in (rs.read_curves(file, profile=TIP, duration=2.8, **options)[0](), *both):
        np.testing.assert_allclose(curve.force, FORCE, rtol=1e-12, atol=1e-24)
        np.testing.assert_allclose(curve.depth, DEPTH + FORCE / 0.5, rtol=1e-12, atol=1e-20)
        np.testing.assert_allclose(curve.time, np.arange(TIME.size) * 2.8 / TIME.size, rtol=1e-12)
    assert len(both) == 2


def test_files_of_optics11_have_the_position_of_the_tip(tmp_path):
    """The piezo moves by the depth and the deflection; nothing is subtracted twice."""
    pytest.importorskip("afmformats")
    names = ["Time (s)", "Load (uN)", "Indentation (nm)", "Cantilever (nm)", "Piezo (nm)", "Auxiliary"]
    rows = np.column_stack(
        [TIME, 1e6 * FORCE, 1e9 * DEPTH, 1e9 * FORCE / 0.5, 1e9 * (DEPTH + FORCE / 0.5), 0.0 * TIME]
    )
    notes = {"Date": "01/02/2020", "Time": "10:11:12", "Device:": "Chiaro", "Software version": "3", "k (N/m)": "0.5",
             "Max load (µN)": "1", "Piezo position (nm) (Measured)": "1", "Piezo speed  (µm/s)": "1"}  # fmt: skip
    head = "".join(f"{name}\t{value}\n" for name, value in notes.items()) + "\t".join(names) + "\n"
    body = "\n".join("\t".join(f"{value:.17g}" for value in row) for row in rows)
    (tmp_path / "gel.txt").write_text(head + body + "\n", encoding="ISO-8859-1")
    curve = rs.read_curves(tmp_path / "gel.txt", profile=TIP)[0]()
    assert curve.spring_constant is None
    assert "has subtracted the deflection" in curve.source
    np.testing.assert_allclose(curve.depth, DEPTH, atol=1e-18)


@pytest.mark.parametrize("suffix", ["jpk-force", "jpk-force-map", "h5", "ibw", "tab", "csv", "txt", "zip", "strange"])
def test_damaged_files_of_all_formats_are_refused_in_one_line(tmp_path, caplog, suffix):
    """Its readers raise errors that derive from BaseException, and log tracebacks."""
    pytest.importorskip("afmformats")
    rng = np.random.default_rng(sum(suffix.encode()))
    whole = tmp_path / "whole.jpk-force"
    write_jpk(whole, jpk_segments(2)[0])
    contents = [b"", rng.bytes(300), b"1,2\n3,4\n", whole.read_bytes()[: rng.integers(100, 5000)], None]
    for n, content in enumerate(contents):
        file = tmp_path / f"{n}.{suffix}"
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(rs.InputError) as refused:
            rs.read_curves(file, profile=TIP).read()
        assert str(file.name) in str(refused.value)
        assert "\n" not in str(refused.value)
    assert not caplog.records
