"""The benchmarks of releases are kept as one file each, and stand side by side."""

from checkout import ROOT, script

history = script("benchmarks/history.py")


def results(version: str, seconds: float) -> dict:
    return {
        "machine": {"processor": f"that of {version}", "versions": {"restitution": version}},
        "domains": [{"domain": "wide", "rtol": 1e-8, "mean": seconds, "error": 2e-9}],
        "profiles": [{"profile": "cone", "seconds": 2 * seconds}],
        "start": {"processes": [{"subject": "`rs.solve`", "first_processor": 9.0, "later": 0.5}]},
    }


def test_releases_stand_in_the_order_of_their_versions(tmp_path):
    folder = tmp_path / "history"
    for version, seconds in (("0.10.0", 3e-6), ("0.9.0", 2e-6)):
        assert history.keep(results(version, seconds), folder).name == f"{version}.json"
    lines = history.table(folder).splitlines()
    assert lines[0] == "|  | 0.9.0 | 0.10.0 |"
    assert lines[2:] == [
        "| processor | that of 0.9.0 | that of 0.10.0 |",
        "| wide, rtol 1e-08 [µs] | 2 | 3 |",
        "| profile cone [µs] | 4 | 6 |",
        "| first rs.solve [s] | 9 | 9 |",
        "| later rs.solve [s] | 0.5 | 0.5 |",
    ]


def test_a_number_that_a_release_lacks_is_empty(tmp_path):
    old = results("1.0.0", 1e-6) | {"profiles": []}
    for content in (old, results("1.1.0", 1e-6)):
        history.keep(content, tmp_path)
    assert "| profile cone [µs] |  | 2 |" in history.table(tmp_path)


def test_the_kept_files_are_those_of_the_table():
    folder = ROOT / "benchmarks"
    assert (folder / "tables" / "history.md").read_text() == history.table(folder / "history") + "\n"
