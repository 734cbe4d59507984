"""Impact of bodies on linear-viscoelastic ones: restitution, contact time, force, energy.

The public names are listed in `__init__.pyi`. Each is loaded on its first use, so importing the package
costs nearly nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)  # pyright: ignore[reportUnsupportedDunderAll]
