"""Whether this processor can run the code of another one, and which AVX-512 paths of NumPy it takes."""

import platform
import sys

import llvmlite.binding as llvm
import numpy._core._multiarray_umath as umath

NEEDED = {
    "generic": (),
    "haswell": ("avx2", "fma", "bmi2"),
    "skylake-avx512": ("avx512f", "avx512vl", "avx512dq"),
}

if sys.argv[1] == "--numpy-avx512":
    features = umath.__cpu_features__
    wide = [name for name in umath.__cpu_dispatch__ if features[name] and ("512" in name or name == "X86_V4")]
    print(" ".join(wide))
else:
    needed = NEEDED[sys.argv[1]]
    host = llvm.get_host_cpu_features()
    suitable = not needed or platform.machine().lower() in ("x86_64", "amd64")
    sys.exit(not (suitable and all(host.get(feature, False) for feature in needed)))
