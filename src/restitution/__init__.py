"""Impact of bodies on linear-viscoelastic ones: restitution, contact time, force, energy.

The public names are listed in `__init__.pyi`. Each is loaded on its first use, so importing the package
costs nearly nothing.
"""

import lazy_loader

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    """Load a public name on its first use; the error of an unknown name has the nearest one."""
    try:
        return _load(name)
    except AttributeError:
        if name.startswith("_"):
            # Python and its tools look such names up by the hundred, and nobody reads the error.
            raise
        from difflib import get_close_matches

        near = get_close_matches(name, __all__, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        raise AttributeError(f"module 'restitution' has no attribute {name!r}{hint}") from None
