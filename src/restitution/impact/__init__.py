"""The impact problem, its solvers and its results."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["closed_forms"])
