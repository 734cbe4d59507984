"""Relaxation functions of materials: models, measured data, a library."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["library"])
