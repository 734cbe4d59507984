"""All random campaigns with one new seed, one after the other; each writes its own table beside its script.

Usage: python validation/campaigns.py --seed 1 [--only tolerance fuzz] [--share 0.1]

The sizes are those of the last review or larger; with `--share` they are that part of it. Together they take some
hours of processor time. The exit status is 1 if a script fails.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

# The script, the option of its size, and the size.
CAMPAIGNS = {
    "tolerance": ("--size", 30_000),
    "ting": ("--count", 5_300),
    "interval_coverage": ("--size", 740),
    "rubbish": ("--sets", 400),
    "fuzz": ("--runs", 15_000),
    "bits": ("--size", 30),
    "explorer": ("--messages", 12_000),
    "law_random": ("--laws", 350),
    "wrong_types": ("--calls", 7_000),
}


def main() -> None:
    """Run the campaigns."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--only", nargs="+", default=list(CAMPAIGNS), choices=list(CAMPAIGNS))
    parser.add_argument("--share", type=float, default=1.0)
    options = parser.parse_args()
    failed: list[str] = []
    for name in options.only:
        option, size = CAMPAIGNS[name]
        script = Path(__file__).with_name(f"{name}.py")
        size = max(round(options.share * size), 1)
        command = [sys.executable, str(script), option, str(size), "--seed", str(options.seed)]
        begin = time.monotonic()
        status = subprocess.run(command).returncode
        print(f"{name}: {size:,}, exit status {status}, {time.monotonic() - begin:.0f} s", flush=True)
        if status:
            failed.append(name)
    sys.exit(f"failed: {', '.join(failed)}" if failed else 0)


if __name__ == "__main__":
    main()
