"""States of contacts and the numbers that belong to them, as all contact laws check them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from restitution.checks import Array, Numeric, finite
from restitution.errors import InputError, InputTypeError


def like(name: str, values: Numeric, shape: tuple[int, ...]) -> Array:
    """Return values as an array of a shape, refusing those that do not broadcast to it."""
    try:
        return np.broadcast_to(values, shape)
    except ValueError:
        raise InputError(f"{name}.shape", np.shape(values), f"must be () or {shape}: one for each contact") from None


def states_of(state: Any, size: int, depth: ArrayLike, deepest: float) -> Array:
    """Return the depths [m] of the contacts of a state, each at most the deepest one of the law; refuse others."""
    if not isinstance(state, np.ndarray) or state.dtype != np.float64 or not state.flags.c_contiguous:
        raise InputTypeError("state", rule="must be an array that `start` returned")
    if state.ndim not in (1, 2) or state.shape[-1] != size:
        rule = f"must be ({size},) or (contacts, {size}), as `start` returns"
        raise InputError("state.shape", state.shape, rule)
    depths = np.ascontiguousarray(like("depth", finite("depth", depth, "m"), state.shape[:-1]))
    if np.any(depths > deepest):
        raise InputError("depth", float(depths.max()), f"must be <= {deepest:g} m", "m")
    return depths


def forces_of(state: Array, forces: Array) -> Any:
    """Return the forces in the shape of the contacts, a number for a single contact."""
    return forces if state.ndim > 1 else float(forces[0])
