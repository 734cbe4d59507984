"""Files as instruments write them: the forms are those of the exports, the numbers are made here."""

import json
import math
import re
import sys
import time

import numpy as np
import pytest

from refusals import in_one_line
from restitution import DynamicTable, InputError, Isotherms, PronySeries, RelaxationTable
from restitution.material.readers import parse, read_material

SERIES = PronySeries(1e6, [3e6, 8e6, 2e7], [0.01, 0.1, 1.0])
OMEGA = np.geomspace(0.5, 200.0, 7)
TIME = np.geomspace(0.01, 10.0, 6)
# Temperature in Celsius and shift factor of each sweep.
SWEEPS = {20.0: 1.0, 30.0: 0.25, 45.0: 0.05}


def moduli(factor):
    return SERIES.storage_modulus(OMEGA * factor), SERIES.loss_modulus(OMEGA * factor)


def rows(factor):
    return zip(OMEGA.tolist(), *(item.tolist() for item in moduli(factor)), strict=True)


def relaxing(factor):
    return zip(TIME.tolist(), SERIES.relaxation_modulus(TIME / factor).tolist(), strict=True)


def trios_steps(mark="Data point\t", header=True):
    """Frequency sweeps as TRIOS writes them for its system of a laboratory (LIMS), and a flow ramp."""
    lines = ["[Version]", "TA Instruments LIMS export format version\t0", "[Header]", "Instrument name\t4010"]
    for celsius, factor in SWEEPS.items():
        lines += ["[Step]", f"Step name\tFrequency sweep ({celsius} °C)", f"Number of points\t{OMEGA.size}"]
        lines += ["Variables\tRun time\tTemperature\tAngular frequency\tOscillation strain (cmd)\tStatus bits\t"
                  "1/temperature\tFrequency\tTan(delta)\tStorage modulus\tLoss modulus"]  # fmt: skip
        lines += ["Units\ts\t°C\trad/s\t%\t\t1/K\tHz\t\tkPa\tkPa"]
        for i, (w, g1, g2) in enumerate(rows(factor)):
            kelvin = celsius + 0.01 * i
            lines += [f"{mark}{i}\t{kelvin!r}\t{w!r}\t5.0\t0xB6453\t{1 / (kelvin + 273.15)!r}\t{w / 2 / math.pi!r}\t"
                      f"{g2 / g1!r}\t{g1 / 1e3!r}\t{g2 / 1e3!r}"]  # fmt: skip
    lines += ["[Step]", "Step name\tFlow ramp - 3", "Number of points\t1", "Variables\tTime\tModulus\tShear rate"]
    return "\n".join([*lines, "Units\ts\tPa\t1/s", "Data point\t1\t2\t3"]) + "\n"


def trios_old():
    """The older form: no word begins a line, and an amplitude sweep comes first."""
    lines = ["Filename\tx.tri", "Instrument name\tDHR", "proceduresegments\tAmplitude sweep#Frequency sweep"]
    lines += ["[File Parameters]", "Trios version\t4.0", "[step]", "Amplitude sweep - 1"]
    lines += ["Angular frequency\tStorage modulus\tLoss modulus", "rad/s\tPa\tPa", "10\t5\t2", "10\t4\t2"]
    for celsius, factor in SWEEPS.items():
        lines += ["[step]", f"Frequency sweep - {celsius:.0f}", "Storage modulus\tTemperature\tLoss modulus\t"
                  "Angular frequency\tTan(delta)", "MPa\t°C\tMPa\trad/s\t"]  # fmt: skip
        lines += [f"{g1 / 1e6!r}\t{celsius}\t{g2 / 1e6!r}\t{w!r}\t{g2 / g1!r}"
                  for w, g1, g2 in rows(factor)]  # fmt: skip
    return "\n".join(lines)


def trios_json():
    headers = {
        "Angular frequency_rad/s": {
            "DisplayName": "Angular frequency",
            "ValueType": "Number",
            "Unit": {"Name": "rad/s"},
        },
        "Storage modulus_MPa": {"DisplayName": "Storage modulus", "ValueType": "Number", "Unit": {"Name": "MPa"}},
        "Loss modulus_MPa": {"DisplayName": "Loss modulus", "ValueType": "Number", "Unit": {"Name": "MPa"}},
        "Temperature_°C": {"DisplayName": "Temperature", "ValueType": "Number", "Unit": {"Name": "°C"}},
        "Status bits": {"DisplayName": "Status bits", "ValueType": "Text"},
    }
    numbered = [
        dict(zip(headers, (w, g1 / 1e6, g2 / 1e6, celsius, "0x1"), strict=True)) | {"Results Step Id": f"id {celsius}"}
        for celsius, factor in SWEEPS.items()
        for w, g1, g2 in rows(factor)
    ]
    steps = [{"Id": f"id {celsius}", "Name": f"Frequency - {celsius}"} for celsius in SWEEPS]
    data = {"ResultsSteps": steps, "ColumnHeaders": headers, "Rows": numbered}
    return json.dumps({"Schema": {"Url": "x"}, "Results": {"Processed": data}})


def trios_json_of_columns():
    columns = [
        {"name": "Time", "unit": "s"},
        {"name": "Relaxation Modulus", "unit": "kPa"},
        {"name": "Step", "unit": ""},
    ]
    results = [
        {"Properties": {"Name": f"Relaxation at {celsius} °C"},
         "DataSet": [{"Data": {"columns": columns, "values": [
             [t, g / 1e3, 1] for t, g in relaxing(factor)]}}]}
        for celsius, factor in SWEEPS.items()
    ]  # fmt: skip
    return json.dumps({"Experiment": {"Results": results}})


def rheocompass(mark="\t", comma=False):
    lines = [f"Project:{mark}P", f"Test:{mark}T"]
    for celsius, factor in SWEEPS.items():
        lines += ["", f"Result:{mark}FS {celsius:g} °C", "", f"Interval and data points:{mark}1{mark}{OMEGA.size + 1}"]
        names = ("Interval data:", "Point No.", "Temperature", "Angular Frequency", "Storage Modulus", "Loss Modulus",
                 "Torque", "Status")  # fmt: skip
        lines += [mark.join(names), mark * 7, mark.join(("", "", "[°C]", "[rad/s]", "[Pa]", "[Pa]", "[mN·m]", ""))]
        # The first point has no values, and a status in words.
        lines += [mark.join(("", "1", "", "", "", "", "", "ME-"))]
        for i, (w, g1, g2) in enumerate(rows(factor)):
            cells = ["", str(i + 2), repr(celsius), repr(float(w)), f"{g1:.17E}", repr(float(g2)), "0.1", "WMa"]
            lines += [mark.join(cell.replace(".", ",") if comma else cell for cell in cells)]
    return "\n".join(lines)


def rheocompass_relaxation():
    lines = ["Project:\tP", "Test:\tStress Relaxation"]
    for celsius, factor in SWEEPS.items():
        lines += ["Result:\tSample", f"Temperature:\t{celsius} °C", "Interval and data points:\t1\t6"]
        lines += [
            "Test Type:\tRelaxation",
            "Interval data:\tTime\tShear Strain\tRelaxation Modulus",
            "\t[s]\t[%]\t[Pa]",
        ]
        lines += [f"{t!r}\t1.0\t{g!r}" for t, g in relaxing(factor)]
    return "\n".join(lines)


def pyvisco(time=False, number=True):
    lines = ["t,E_relax,T,Set" if time else "f,E_stor,E_loss,T,Set", "s,MPa,C,-" if time else "Hz, MPa, MPa, C, -"]
    for place, (celsius, factor) in enumerate(SWEEPS.items()):
        if time:
            numbers = [(t, g / 1e6) for t, g in relaxing(factor)]
        else:
            numbers = [(w / 2 / math.pi, g1 / 1e6, g2 / 1e6) for w, g1, g2 in rows(factor)]
        lines += [",".join(map(repr, row)) + f",{celsius},{place}" for row in numbers]
    if not number:
        lines = [line.rpartition(",")[0] for line in lines]
    return "\n".join(lines)


def by_frequency():
    """A ramp of the temperature at several frequencies: the frequency is the slow column."""
    lines = ["Frequency (rad/s);Temp;G';G''", "rad/s;°C;Pa;Pa"]
    sweeps = zip(*(rows(factor) for factor in SWEEPS.values()), strict=True)
    lines += [f"{w!r};{celsius + 0.1 * (i % 2)};{g1!r};{g2!r}"
              for i, row in enumerate(sweeps) for celsius, (w, g1, g2) in zip(SWEEPS, row, strict=True)]  # fmt: skip
    return "\n".join(lines)


def rheocompass_in_german(mark="\t"):
    words = {
        "Project": "Projekt",
        "Test": "Versuch",
        "Result": "Ergebnis",
        "Interval and data points": "Intervall und Datenpunkte",
        "Interval data": "Intervalldaten",
        "Point No.": "Messpkt.",
        "Temperature": "Temperatur",
        "Angular Frequency": "Kreisfrequenz",
        "Storage Modulus": "Speichermodul",
        "Loss Modulus": "Verlustmodul",
        "Torque": "Moment",
    }
    text = rheocompass(mark, comma=True)
    for word, other in words.items():
        text = text.replace(word, other)
    return text


def netzsch():
    """The names stand in a comment, with the unit behind a slash; columns that are not needed have one too."""
    lines = ["#EXPORTTYPE:DATA ALL", "#DECIMAL:COMMA", "#SEPARATOR:SEMICOLON"]
    lines += ["##Temp./°C;Time/min;Freq./Hz;E'/MPa;E''/MPa;tan d"]
    lines += [f"{celsius};1.5;{w / 2 / math.pi!r};{g1 / 1e6!r};{g2 / 1e6!r};{g2 / g1!r}"
              for celsius, factor in SWEEPS.items() for w, g1, g2 in rows(factor)]  # fmt: skip
    return "\n".join(lines).replace(".", ",").replace("Temp,", "Temp.").replace("Freq,", "Freq.")


def quantity_over_unit():
    lines = ["omega/(rad/s),G'/kPa,G''/kPa,T / °C"]
    lines += [f"{w!r},{g1 / 1e3!r},{g2 / 1e3!r},{celsius}"
              for celsius, factor in SWEEPS.items() for w, g1, g2 in rows(factor)]  # fmt: skip
    return "\n".join(lines)


DYNAMIC = {
    "TRIOS": trios_steps(),
    "TRIOS, older": trios_old(),
    "TRIOS, CSV": trios_old().replace("\t", ","),
    "TRIOS, CSV of a spreadsheet": trios_old().replace("\t", ";").replace("[step]", "[step];;;;"),
    "TRIOS, JSON": trios_json(),
    "RheoCompass": rheocompass(),
    "RheoCompass, decimal commas": rheocompass(comma=True),
    "RheoCompass, semicolons": rheocompass(";", comma=True),
    "RheoCompass, commas": rheocompass(","),
    "RheoCompass, German": rheocompass_in_german(),
    "RheoCompass, German, semicolons": rheocompass_in_german(";"),
    "Netzsch": netzsch(),
    "quantity over unit": quantity_over_unit(),
    "pyvisco": pyvisco(),
    "a column of temperatures": pyvisco(number=False),
    "a ramp of temperatures": by_frequency(),
}
RELAXATION = {
    "TRIOS, JSON of columns": trios_json_of_columns(),
    "RheoCompass": rheocompass_relaxation(),
    "pyvisco": pyvisco(time=True),
    "a column of temperatures": pyvisco(time=True, number=False),
}
REPTATE = {
    "names and units": "T=30;Mw=2.4;chem=PI;label=a b;\nFreq\tG'\tG\"\tTemp\tStrain\nrad/s\tPa\tPa\t°C\t%\n"
    + "".join(f"{w!r}\t{g1!r}\t{g2!r}\t30.0\t0.5\n" for w, g1, g2 in rows(1.0)),
    "comments": "Mw=634.5;T=30;PDI=1.03;\n#Dummy\n#w G' G'' Temp g\n"
    + "".join(f"  {w!r}   {g1!r}  {g2!r} 30  0\n" for w, g1, g2 in rows(1.0)),
    "in any order": "C1=8.7;T=30;\n" + "".join(f" {w!r} {g1!r} {g2!r}\n" for w, g1, g2 in [*rows(1.0)][::-1] * 2),
}


@pytest.mark.parametrize("text", DYNAMIC.values(), ids=DYNAMIC)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be", "cp1252"])
def test_several_temperatures_of_dynamic_moduli(tmp_path, text, encoding):
    path = tmp_path / "export.csv"
    path.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    result = read_material(path)
    assert isinstance(result, Isotherms)
    assert result.temperatures - 273.15 == pytest.approx(list(SWEEPS), abs=0.1)
    assert result.source == str(path)
    for table, factor in zip(result.tables, SWEEPS.values(), strict=True):
        assert isinstance(table, DynamicTable)
        assert table.angular_frequency == pytest.approx(OMEGA, rel=1e-12)
        assert table.storage_modulus == pytest.approx(moduli(factor)[0], rel=1e-12)
        assert table.loss_modulus == pytest.approx(moduli(factor)[1], rel=1e-12)


@pytest.mark.parametrize("text", RELAXATION.values(), ids=RELAXATION)
def test_several_temperatures_of_a_relaxation_modulus(text):
    result = parse(text)
    assert isinstance(result, Isotherms)
    assert result.temperatures - 273.15 == pytest.approx(list(SWEEPS))
    for table, factor in zip(result.tables, SWEEPS.values(), strict=True):
        assert isinstance(table, RelaxationTable)
        assert table.time == pytest.approx(TIME, rel=1e-12)
        assert table.modulus == pytest.approx(SERIES.relaxation_modulus(TIME / factor), rel=1e-12)


@pytest.mark.parametrize("text", REPTATE.values(), ids=REPTATE)
def test_dynamic_moduli_of_reptate(text):
    result = parse(text, "PI.osc")
    assert isinstance(result, DynamicTable)
    assert (result.temperature, result.deformation) == (pytest.approx(303.15), "shear")
    assert result.angular_frequency == pytest.approx(OMEGA)
    assert result.storage_modulus == pytest.approx(moduli(1.0)[0])
    assert result.loss_modulus == pytest.approx(moduli(1.0)[1])


def test_relaxation_modulus_of_reptate():
    text = "gamma=0;Mw=3;\n" + "".join(
        f"{t!r} {g!r} 7\n" for t, g in zip(TIME.tolist(), (1 / TIME).tolist(), strict=True)
    )
    result = parse(text, "a.gt")
    assert isinstance(result, RelaxationTable)
    assert (result.modulus, result.temperature) == (pytest.approx(1 / TIME), None)
    # Without the ending of its name, the number of columns decides.
    assert isinstance(parse(text.replace(" 7\n", "\n"), "a.txt"), RelaxationTable)


def test_one_sweep_has_its_temperature():
    text = trios_steps()
    result = parse(text[: text.index("[Step]\nStep name\tFrequency sweep (30")])
    assert isinstance(result, DynamicTable)
    assert result.temperature == pytest.approx(293.15 + 0.03)
    assert parse("f,E',E'',T\nHz,Pa,Pa,°C\n1,3,2,20\n10,4,1,21\n").temperature == pytest.approx(293.65)
    # A torque is no temperature.
    assert parse("f,E',E'',T\nHz,Pa,Pa,N m\n1,3,2,20\n10,4,1,21\n").temperature is None


def test_what_is_left_out_is_noted():
    result = parse(trios_steps().replace(f"{moduli(1.0)[1].tolist()[2] / 1e3!r}\n", "-3\n", 1))
    assert result.tables[0].angular_frequency.size == OMEGA.size - 1
    assert result.notes == (
        "Frequency sweep (20.0 °C): 1 rows without positive values are not used; the first is line 12",
        "not used: Flow ramp - 3",
    )
    truncated = parse(trios_steps().rpartition("[Step]\nStep name\tFlow")[0].rpartition("Data point")[0])
    assert truncated.notes == ("Frequency sweep (45.0 °C): 6 of 7 points",)
    assert "not used: Amplitude sweep - 1" in parse(trios_old()).notes


def test_sweeps_at_one_temperature_are_averaged():
    twice = parse(pyvisco() + "\n" + "\n".join(f"{line[:-1]}3" for line in pyvisco().splitlines()[2:9]))
    assert twice.notes == ("2 sweeps at 20.0 °C are averaged",)
    assert twice.tables[0].storage_modulus == pytest.approx(moduli(1.0)[0])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "x: line 1: Expecting property name.*: must be JSON"),
        ("{}", "x: is no export of TRIOS: must have Results"),
        ('{"Results": {"a": 3}}', "x: is no export of TRIOS"),
        ('{"Results": []}', "x: no step: one must have"),
        ("{" + '"a":{' * 100_000, "x: .*must be JSON"),
        (trios_json().replace('"Rows": [{', '"Rows": [3, {'), "x: is no export of TRIOS"),
        (trios_json().replace(": 20.0, ", ': "warm", ', 1), "x, Frequency - 20.0: row 1: Temperature = 'warm': must be a number"),
        (trios_steps().replace("\tkPa\tkPa", "\tkPa\tmm"), "x: line 9: column 'Loss modulus': unit 'mm'"),
        (trios_steps().replace("\t5.0\t", "\t", 1), "x: line 10: 9 values: must be 10"),
        ("[step]\nFlow\n", "x: line 1: must have a step with data points"),
        (rheocompass()[:300], "x: line 12: 3 values: must be 7, one for each column"),
        ("Interval data:\n", "x: must have an interval with data"),
        ("T=3;\n", "x: line 1: is followed by no numbers"),
        ("T=hot;\n1 2 3\n", "x: line 1: T = 'hot': must be a temperature in °C"),
        ("T=3;\n1 2 3\n1 2\n", "x: line 3: 2 values: must be 3, omega, G', G''"),
        ("T=3;\n1 2 x\n", "x: line 2: G'' = 'x': must be a number"),
        ("f,E',E'',T\n1,3,2,-20\n2,4,1,-20\n1,3,2,5\n2,3,2,5\n", r"x: line 2: T = -20: must be finite and > 0 K, as no"),
        (
            rheocompass().replace("FS", "").replace("°C", "").replace("Temperature", "Gap"),
            "x: holds 3 sweeps: the temperature of each",
        ),
    ],
)  # fmt: skip
def test_malformed_exports_are_refused_with_the_number_of_their_line(text, message):
    line = str(in_one_line(lambda: parse(text, "x")))
    assert re.search(message, line)
    assert len(line) < 500


def workbook(path, sheets):
    book = pytest.importorskip("openpyxl").Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def cells(text, mark):
    """Rows of a text, with its numbers as numbers."""

    def value(cell):
        try:
            return float(cell)
        except ValueError:
            return cell

    return [[value(cell) for cell in line.split(mark)] for line in text.splitlines()]


def test_workbooks(tmp_path):
    whole = read_material(workbook(tmp_path / "a.xlsx", {"data": cells(pyvisco(), ",")}))
    assert isinstance(whole, Isotherms)
    assert whole.tables[2].loss_modulus == pytest.approx(moduli(0.05)[1])
    # TRIOS writes one sheet for each step, and one of details.
    sheets = {"Details": [["Filename", "x"], ["rundate", 3]]}
    for celsius, factor in SWEEPS.items():
        names = [["Angular frequency", "Storage modulus", "Loss modulus", "Temperature"], ["rad/s", "Pa", "Pa", "°C"]]
        sheets[f"Frequency sweep {celsius}"] = [
            ["Frequency sweep"],
            *names,
            *([*row, celsius] for row in rows(factor)),
        ]
    steps = read_material(workbook(tmp_path / "b.xlsx", sheets))
    assert isinstance(steps, Isotherms)
    assert steps.tables[1].storage_modulus == pytest.approx(moduli(0.25)[0])
    shift = {"data": [["T", "log_aT"], ["C", "-"], [10.0, 1.0], [20.0, 0.0], [30.0, -0.5]]}
    assert read_material(workbook(tmp_path / "d.xlsx", shift)).log10_factors.tolist() == [1.0, 0.0, -0.5]
    several = {
        "moduli": [["t [s]", "E [MPa]"], [1.0, 3.0], [2.0, 2.0]],
        "factors": shift["data"],
        "flow": [["Time", "Modulus"], [1.0, 2.0], [2.0, 1.0]],
    }
    table = read_material(workbook(tmp_path / "e.xlsx", several))
    assert (table.modulus.tolist(), table.notes) == ([3e6, 2e6], ("not used: factors, flow",))
    bad = {"data": [["t", "E"], ["s", "MPa"], [1.0, 3.0], [2.0, "x"]]}
    with pytest.raises(InputError, match=r"c\.xlsx, sheet 'data': row 4: E = 'x'"):
        read_material(workbook(tmp_path / "c.xlsx", bad))
    assert "material 'a'" in str(in_one_line(lambda: read_material(tmp_path / "c.xlsx", name="a")))


def test_a_workbook_without_its_reader_asks_for_it(tmp_path, monkeypatch):
    path = workbook(tmp_path / "a.xlsx", {"data": cells(pyvisco(), ",")})
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(InputError, match=r'save its sheet as CSV, or install .* "restitution\[excel\]"'):
        read_material(path)


FORMS = {**DYNAMIC, **{f"relaxation, {name}": text for name, text in RELAXATION.items()}, **REPTATE}
PIECES = ("", "\t", ";", ",", "\n", "nan", "-1", "1e999", "0", "[step]", "Interval data:", "=", '"', "{", "}", "°C", "T=", "\0")  # fmt: skip


def mutated(text, rng):
    """Text with some pieces removed, repeated, moved or replaced."""
    for _ in range(int(rng.integers(1, 5))):
        begin, end = sorted(int(place) for place in rng.integers(0, len(text) + 1, 2))
        if rng.random() < 0.7:
            end = min(end, begin + int(rng.integers(0, 30)))
        piece = str(rng.choice(PIECES)) if rng.random() < 0.6 else text[begin:end] * 2
        text = text[:begin] + piece + text[end:]
    return text


def refusal(read, *arguments):
    """Message of a refusal, empty if there is none."""
    try:
        read(*arguments)
    except InputError as error:
        return str(error)
    return ""


def read_or_refuse(text):
    message = refusal(parse, text, "x.gt" if text.startswith("gamma") else "x")
    assert "\n" not in message
    assert len(message) < 600


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("count", [20, pytest.param(1000, marks=pytest.mark.slow)])
def test_mutated_exports_are_read_or_refused(form, count):
    rng = np.random.default_rng([count, list(FORMS).index(form)])
    for _ in range(count):
        read_or_refuse(mutated(FORMS[form], rng))


def test_a_quotation_mark_that_stands_alone_joins_no_lines():
    table = parse('frequency [Hz],storage modulus [MPa],loss modulus [MPa]\n1,2,3\n2,3,"4\n4,5,6\n8,6,7\n', "x")
    assert isinstance(table, DynamicTable)
    assert table.angular_frequency / (2.0 * math.pi) == pytest.approx([1.0, 2.0, 4.0, 8.0])
    assert table.loss_modulus == pytest.approx([3e6, 4e6, 6e6, 7e6])


@pytest.mark.slow
def test_a_thousand_mutated_workbooks_are_read_or_refused(tmp_path):
    content = workbook(tmp_path / "a.xlsx", {"data": cells(pyvisco(), ",")}).read_bytes()
    rng = np.random.default_rng(0)
    path = tmp_path / "b.xlsx"
    for _ in range(1000):
        spoiled = bytearray(content)
        for _ in range(int(rng.integers(1, 6))):
            spoiled[int(rng.integers(len(spoiled)))] = int(rng.integers(256))
        path.write_bytes(b"PK" + bytes(spoiled)[2 : int(rng.integers(100, 2 * len(content)))])
        assert "\n" not in refusal(read_material, path)


LARGE = {
    "steps": lambda n: "[step]\n" * (n // 7),
    "empty steps": lambda n: "[step]\na\tb\n\t\n" * (n // 12),
    "intervals": lambda n: "Interval data:\tTime\n" * (n // 20),
    "parameters": lambda n: "a=1;" * (n // 4) + "\n1 2 3\n",
    "brackets": lambda n: "[" * n,
    "braces": lambda n: '{"a":' * (n // 5),
    "digits": lambda n: '{"Results": ' + "1" * n,
    "tabs": lambda n: "Variables\t" + "\t" * n + "\n",
    "turns": lambda n: "f,E',E'',T\nHz,Pa,Pa,C\n" + "".join(f"{1 + i % 2},3,2,{i % 300}\n" for i in range(n // 11)),
    "degrees": lambda n: "Result:\t" + "1" * n + "°C\nInterval data:\tTime\tG\n\t[s]\t[Pa]\n1\t2\n",
}
"""Texts of about n characters."""


def processor_time(text):
    times = []
    for _ in range(3):
        start = time.process_time()
        read_or_refuse(text)
        times.append(time.process_time() - start)
    return min(times)


@pytest.mark.parametrize("text", LARGE.values(), ids=LARGE)
def test_large_texts_take_no_quadratic_time(text):
    # Ten times the text takes ten times as long, in quadratic time a hundred times, on a machine of any speed.
    assert processor_time(text(100_000)) < 30.0 * processor_time(text(10_000))
