"""Settings of pytest for the benchmarks; files that are not tests are scripts."""

from pathlib import Path

collect_ignore = [path.name for path in Path(__file__).parent.glob("*.py") if not path.name.startswith("test_")]
