"""Gauss quadrature over [0, 1] with slopes at its nodes."""

import numpy as np
from numpy.polynomial.polynomial import polyvander

_COUNT = 16
_CENTRED, WEIGHTS = (0.5 * part for part in np.polynomial.legendre.leggauss(_COUNT))
PLACES = _CENTRED + 0.5
# Values at the nodes to the slopes there, by the polynomial through them.
_POWERS = polyvander(_CENTRED, _COUNT - 1)
SLOPES = (_POWERS[:, :-1] * np.arange(1, _COUNT)) @ np.linalg.inv(_POWERS)[1:]
