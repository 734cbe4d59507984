"""Completion of what a user types in the shell: names of the library, of outputs and of axes."""

from __future__ import annotations


def library_names(incomplete: str) -> list[str]:
    """Names of materials of the library."""
    from restitution.material import library

    return [name for name in library.names() if name.startswith(incomplete)]


def outputs(incomplete: str) -> list[str]:
    """Names of outputs of a sweep."""
    from restitution.quantities import OUTPUTS

    return [name for name in OUTPUTS if name.startswith(incomplete)]


def axes(incomplete: str) -> list[str]:
    """Names of quantities that an axis may set, with the sign that follows."""
    from restitution.quantities import ALIASES, INPUTS

    return [f"{name}=" for name in (*INPUTS, *ALIASES) if name.startswith(incomplete)]
