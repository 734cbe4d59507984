"""
Rebound resilience and the thickness of the pad
===============================================

The pendulum of Schob (DIN 53512, ASTM D7121) hits a rubber pad of 12.5 mm. The pad is no half-space: the contact is
nearly as wide as the pad is thick. A thinner pad is stiffer, the contact is shorter, and the rubber has other losses
at these shorter times. The holder lets the pad slide on its base or not, and the truth lies between both.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs

# %%
# An invented rubber. The result has all ways to hold the pad.

times = [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5]
shear = rs.PronySeries(0.6e6, [0.06e6, 0.08e6, 0.12e6, 0.25e6, 0.8e6, 3e6], times)
rubber = rs.Material(shear, bulk=np.inf, density=1100.0)
pad = rs.resilience(rubber, "ASTM D7121")
print(pad)

# %%
# The same test on pads of other thickness.

thickness = np.array([4.0, 5.0, 6.0, 8.0, 10.0, 12.5, 16.0, 20.0, 25.0, 35.0, 50.0]) * 1e-3
pads = [rs.resilience(rubber, "ASTM D7121", thickness=h) for h in thickness]
resilience = np.array([result.rebound_resilience for result in pads])
contact_time = np.array([result.contact_time for result in pads])

fig, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
for place, (name, style) in enumerate(zip(pad.base, ("C0o-", "C1s-", "k:"), strict=True)):
    left.plot(1e3 * thickness, resilience[:, place], style, markersize=4, label=name)
    right.plot(1e3 * thickness, 1e3 * contact_time[:, place], style, markersize=4, label=name)
left.axvline(12.5, color="0.8", zorder=0)
right.axvline(12.5, color="0.8", zorder=0)
left.set(xlabel="thickness of the pad [mm]", ylabel="rebound resilience [%]")
right.set(xlabel="thickness of the pad [mm]", ylabel="contact time [ms]", ylim=(0.0, None))
left.legend()

# %%
# An independent integration of the equations gives 59.86 % and 61.13 % for the pad of 12.5 mm, and 56.73 % and 61.61 %
# for bonded pads of 6 and 25 mm. Finite elements of a disc of 29 mm diameter with a free side have about one point
# more: 60.7 % and 61.8 %.

assert np.allclose(pad.rebound_resilience[:2], [59.86, 61.13], atol=0.006)
assert np.allclose(resilience[[2, 8], 0], [56.73, 61.61], atol=0.006)
assert np.all(np.diff(resilience[:, :2], axis=0) > 0.0)
