"""Series over the panels of a/h, compiled: contacts of one profile on layers of many thicknesses."""

from typing import Any

from restitution.kernel.compile import entry_point, inlined

MOST = 128
"""Contacts that are evaluated together."""


@inlined
def _panel(panels: Any, radius: float) -> int:
    """Panel that contains a radius over the thickness; the last one beyond its end."""
    last = panels.shape[0] - 2
    panel = 0
    while panel < last and radius >= panels[panel + 1]:
        panel += 1
    return panel


@entry_point
def on_layers(
    thickness: Any, radius: Any, panels: Any, stiffness: Any, edge: Any, series: Any, scratch: Any, found: Any
) -> None:
    """Write ln kappa, ln w(a) and a mean over the profile for every contact on every layer.

    Parameters
    ----------
    thickness, radius
        Thicknesses of the layers, shape (n_layer,), and radii of the contacts in the same unit, shape (n,).
    panels, stiffness, edge
        Ends of the panels, and the series of ln kappa and ln w over each, shape (n_panel, n_term), n_term even.
    series
        Series of the mean of each contact, shape (n_panel, n_term, n).
    scratch
        Space of the shape (6, `MOST`).
    found
        Results, shape (3, n_layer, n).
    """
    n, terms = radius.shape[0], stiffness.shape[1]
    twice, even, odd, one, two, three = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5]
    for layer in range(thickness.shape[0]):
        per_unit = 1.0 / thickness[layer]
        first = 0
        while first < n:
            # Neighbours in one panel.
            panel = _panel(panels, radius[first] * per_unit)
            low, high = panels[panel], panels[panel + 1]
            count = 1
            while count < MOST and first + count < n and _panel(panels, radius[first + count] * per_unit) == panel:
                count += 1
            for i in range(count):
                place = (2.0 * radius[first + i] * per_unit - low - high) / (high - low)
                twice[i] = 2.0 * place
                even[i], odd[i] = 1.0, place
                one[i] = stiffness[panel, 0] + stiffness[panel, 1] * place
                two[i] = edge[panel, 0] + edge[panel, 1] * place
                three[i] = series[panel, 0, first + i] + series[panel, 1, first + i] * place
            # Two terms at a time, since reading and writing cost more than the products.
            for k in range(2, terms, 2):
                for i in range(count):
                    now = twice[i] * odd[i] - even[i]
                    after = twice[i] * now - odd[i]
                    even[i] = now
                    odd[i] = after
                    one[i] += stiffness[panel, k] * now + stiffness[panel, k + 1] * after
                    two[i] += edge[panel, k] * now + edge[panel, k + 1] * after
                    three[i] += series[panel, k, first + i] * now + series[panel, k + 1, first + i] * after
            for i in range(count):
                found[0, layer, first + i] = one[i]
                found[1, layer, first + i] = two[i]
                found[2, layer, first + i] = three[i]
            first += count
