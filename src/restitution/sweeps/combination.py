"""Combinations of values that occur in columns."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Columns = dict[str, NDArray[Any]]


def combinations(columns: Columns, n: int) -> Iterator[tuple[NDArray[np.intp], dict[str, Any]]]:
    """Yield every combination of values that occurs, with the places where it does.

    Parameters
    ----------
    columns : dict of str to array, shape (n,)
        Numbers, or objects, which are told apart by identity.
    n : int
        Number of places.

    Yields
    ------
    tuple of array and dict
        Places in ascending order; values by name.

    Examples
    --------
    >>> columns = {"a": np.array([1.0, 2.0, 1.0]), "b": np.array([5.0, 5.0, 5.0])}
    >>> for places, values in combinations(columns, 3):
    ...     print(places, values)
    [0 2] {'a': 1.0, 'b': 5.0}
    [1] {'a': 2.0, 'b': 5.0}
    """
    if not columns:
        yield np.arange(n), {}
        return
    keys = np.zeros(n, dtype=np.intp)
    for column in columns.values():
        if column.dtype == object:
            numbers: dict[int, int] = {}
            codes = np.array([numbers.setdefault(id(item), len(numbers)) for item in column], dtype=np.intp)
        else:
            codes = np.unique(column, return_inverse=True)[1]
        # Renumbered after each column, so that the product of many does not overflow.
        keys = np.unique(keys * (int(codes.max()) + 1) + codes, return_inverse=True)[1]
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    for places in np.split(order, starts[1:]):
        yield places, {name: _plain(column[places[0]]) for name, column in columns.items()}


def _plain(value: Any) -> Any:
    return float(value) if isinstance(value, np.floating) else value
