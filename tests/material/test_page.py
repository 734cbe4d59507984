"""Code and numbers on the page about materials."""

import re

import numpy as np
import pytest

from cases import case_file
from checkout import ROOT, blocks, run
from restitution import fit_prony, read_case, read_material

PAGE = "docs/materials.md"
TEXT = (ROOT / PAGE).read_text(encoding="utf-8")
WORDS = " ".join(TEXT.split())


def test_code_of_the_page_runs(folder, capsys):
    run(PAGE)
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("True ")
    assert printed[1] == "temperature = 500 K: must be in [202, 400] K, the range of the law"
    for line, truth in zip(printed[2:4], (10.7, 29.9), strict=True):
        value, error = map(float, re.findall(r"[\d.]+", line.partition("=")[2]))
        assert abs(value - truth) < 3.0 * error < 0.1 * truth
    assert printed[4] == "True"
    (shown,) = [block for block in blocks(PAGE, "text") if block.startswith("[[")]
    assert printed[5:7] == shown.splitlines()
    assert printed[7] == "[0.35  0.439 0.5  ] [954.  30.]"
    assert printed[8].startswith("(202.0, 400.0) ")


@pytest.mark.filterwarnings("ignore:.*one frequency measures no shift")
@pytest.mark.parametrize("block", blocks(PAGE, "toml"))
def test_materials_of_case_files_are_read(block, tmp_path):
    (tmp_path / "case.toml").write_text(case_file(material=None) + block)
    (tmp_path / "deck.inp").write_text(
        "*MATERIAL, NAME=rubber\n*ELASTIC\n9, .4\n*VISCOELASTIC, TIME=PRONY\n.5, 0, 2\n*MATERIAL, NAME=steel\n"
    )
    rows = [f"{w},{1e6 * (w * s) ** 0.5},{1e6 * (w * s) ** 0.5},{100 - 20 * np.log10(s)}"
            for s in (1.0, 0.3, 0.1) for w in np.geomspace(0.1, 100.0, 16)]  # fmt: skip
    (tmp_path / "dma.csv").write_text("\n".join(["omega,G',G'',T", "rad/s,Pa,Pa,degC", *rows]))
    moduli = {t: 1e8 * 10.0 ** (-8.35 * (t + 40.0) / (t + 93.6)) for t in range(-50, 61, 5)}
    ramp = [f"{t},{modulus},{modulus}" for t, modulus in moduli.items()]
    (tmp_path / "ramp.csv").write_text("\n".join(["T,G',G''", "degC,Pa,Pa", *ramp]))
    assert read_case(tmp_path / "case.toml").impact.material.shear.n_branches > 0


def rms(values):
    return np.sqrt(np.mean(np.abs(values) ** 2))


def test_table_of_the_dynamic_data(shared_reference):
    folder = shared_reference / "materials"
    data = read_material(folder / "polymer_dma_master_curve.csv")
    omega, measured = data.angular_frequency, data.storage_modulus + 1j * data.loss_modulus
    shares = read_material(folder / "polymer_ansys_prony.MPL").shear.series(instantaneous_modulus=1.0)
    size = np.abs(measured)
    per_unit = shares.carson_transform(1j * omega) / size
    best = np.vdot(per_unit, measured / size).real / np.vdot(per_unit, per_unit).real
    fits = fit_prony(data), fit_prony(data, loss_weight=1.0)
    result = [
        fits[0].series, shares.scaled(data.storage_modulus.max()), shares.scaled(best), fits[1].series
    ]  # fmt: skip
    rows = re.findall(r"^\|[^|]+\| (\d+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", TEXT, re.MULTILINE)
    assert len(rows) == 4
    for series, row in zip(result, rows, strict=True):
        moduli = series.carson_transform(1j * omega)
        misfits = [
            rms((moduli - measured) / size),
            rms(moduli.real / measured.real - 1.0),
            rms(moduli.imag / measured.imag - 1.0),
        ]
        assert series.n_branches == int(row[0])
        assert misfits == pytest.approx([float(number) for number in row[1:]], abs=6e-5)
    ratio = fits[0].series.loss_modulus(omega) / data.loss_modulus
    assert f"at {(ratio < 0.7).sum()} of the {omega.size} frequencies" in WORDS
    assert f"{(ratio[omega < 1.0] < 0.7).sum()} of them below 1 rad/s" in WORDS
    assert f"at worst {100.0 * (1.0 - ratio.min()):.0f} %" in WORDS
    for decade, lowness in ((0, 0.16), (3, 0.10), (6, 0.13)):
        inside = (omega >= 10.0**decade) & (omega < 10.0 ** (decade + 3))
        assert 1.0 - ratio[inside].mean() == pytest.approx(lowness, abs=6e-3)
    plateau = (omega >= 1e-9) & (omega < 1e-6)
    slope = np.polyfit(np.log(omega[plateau]), data.storage_modulus[plateau], 1)[0] * np.pi / 2.0
    assert [slope, data.loss_modulus[plateau].mean()] == pytest.approx([2e6, 11e6], abs=0.5e6)
