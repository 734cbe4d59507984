"""The discrete-element code of the examples, compiled with the header that `restitution export` writes."""

import re
import shutil
import subprocess

import pytest

from checkout import EXAMPLES
from commands import done


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a compiler of C")
@pytest.mark.parametrize("options", [[], pytest.param(["-DMEMORYLESS"], marks=pytest.mark.slow)])
def test_beads_come_to_rest_and_never_gain_energy(tmp_path, options):
    header = tmp_path / "contact_law.h"
    done("export", str(EXAMPLES / "two_beads.toml"), "--to", str(header))
    program = tmp_path / "balls"
    strict = ["-O2", "-std=c99", "-Wall", "-Wextra", "-Werror", *options, f"-I{tmp_path}"]
    subprocess.run(["cc", *strict, "-o", str(program), str(EXAMPLES / "dem" / "balls.c"), "-lm"], check=True)
    beads = subprocess.run([str(program), "27", "0.3"], capture_output=True, text=True, check=True)
    highest, work, kinetic = map(float, re.findall(r"= (\S+) of the first", beads.stdout))
    assert highest < 1e-12
    # A contact returns no more than it got, but for the error of the trapezoidal rule.
    assert work > -1e-6
    assert kinetic < 1e-3
