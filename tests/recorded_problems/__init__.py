"""Some 200 random problems of all kinds, by the public names of the package alone.

`tests/project/test_recorded.py` compares their numbers with those in `tests/data/recorded.json`, within tolerances.
`validation/recorded.py` compares all their bits between two checkouts on one machine.
"""

from recorded_problems import data, impacts, motions, tables
from recorded_problems.registry import PROBLEMS, Problem, Values, beyond, differences, same_bits

__all__ = [
    "PROBLEMS",
    "Problem",
    "Values",
    "beyond",
    "data",
    "differences",
    "impacts",
    "motions",
    "same_bits",
    "tables",
]
