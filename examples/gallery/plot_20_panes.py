r"""
Steel balls on panes of glass
=============================

A steel ball rebounds from a block of glass almost without loss. From a pane it hardly rebounds: the flexural waves
that leave the point of impact have its energy. Zener (1941) found that an infinite plate recedes at the rate
:math:`F/Z`, with the impedance :math:`Z = 8\sqrt{D\rho h}`.
"""

import matplotlib.pyplot as plt
import numpy as np

import restitution as rs
from restitution.plot import style
from restitution.plot.history import energy_area

glass = rs.elastic(youngs_modulus=70e9, poisson_ratio=0.22, density=2500.0)
steel = rs.elastic(youngs_modulus=210e9, poisson_ratio=0.3, density=7800.0)


def on_pane(diameter, thickness):
    """Steel balls of these diameters at 1 m/s on panes of these thicknesses."""
    radius = 0.5 * diameter
    mass = 4.0 / 3.0 * np.pi * radius**3 * steel.density
    return rs.Impact(
        glass, rs.Parabola(radius), mass, 1.0, counter_material=steel, impedance=rs.plate_impedance(glass, thickness)
    )


# %%
# The ball that is three times as large needs a pane that is about three times as thick: equal shapes have equal
# :math:`\lambda = k^{2/5}m^{3/5}v_0^{1/5}/Z`.

thickness = np.geomspace(1e-3, 40e-3, 60)
fig, ax = plt.subplots(figsize=(5.6, 3.9), layout="constrained")
for millimetres, color, line in ((3, style.ORANGE, "-"), (6, style.BLUE, "--"), (9, style.GREEN, "-.")):
    result = rs.solve(on_pane(millimetres * 1e-3, thickness))
    ax.plot(1e3 * thickness, result.restitution_coefficient, line, color=color, label=f"ball of {millimetres} mm")
ax.set(xscale="log", xticks=[1, 2, 5, 10, 20, 40], ylim=(0.0, 1.0), xlabel="thickness of the pane [mm]")
ax.xaxis.set_major_formatter("{x:g}")
ax.xaxis.set_minor_formatter("")
ax.set_ylabel("restitution coefficient e")
ax.legend(loc="lower right")

# %%
# A pane of 2.5 mm takes most of the energy of the ball of 6 mm. When the indentation is deepest, ball and pane move
# together, so that the ball still has kinetic energy there.

hit = rs.solve(on_pane(6e-3, 2.5e-3))
fig, ax = plt.subplots(figsize=(5.6, 3.9), layout="constrained")
energy_area(ax, hit.history)
share = hit.energy.radiated / hit.energy.kinetic_in
moved = 1e6 * hit.history.target_displacement.values[-1]
print(f"e = {hit.restitution_coefficient:.4f}, radiated {share:.4f}, the pane has receded by {moved:.1f} µm")
assert abs(share - (1.0 - hit.restitution_coefficient**2)) < 1e-9

# %%
# The pane counts as infinite until a wave has come back from its edge. The fastest waves of the contact have about the
# angular frequency :math:`\pi/T` and the group velocity :math:`2\,(D/(\rho h))^{1/4}\sqrt{\omega}`.

bending = 70e9 * 2.5e-3**2 / (12.0 * (1.0 - 0.22**2) * glass.density)
group_velocity = 2.0 * bending**0.25 * np.sqrt(np.pi / hit.contact_time)
print(f"contact {1e6 * hit.contact_time:.1f} µs, edge at least {50.0 * group_velocity * hit.contact_time:.1f} cm away")

# %%
# For elastic bodies Zener's equation has one number, and a Taylor series with 40 digits gives
# :math:`e(\lambda = 1/2) = 0.43689530094234`.

ball = on_pane(6e-3, 2.5e-3)
stiffness = 4.0 / 3.0 * float(ball.reduced_modulus.equilibrium_modulus) * np.sqrt(3e-3)
impedance = stiffness**0.4 * ball.mass**0.6 / 0.5
e = rs.solve(rs.Impact(glass, rs.Parabola(3e-3), ball.mass, 1.0, counter_material=steel, impedance=impedance))
print(f"{e.restitution_coefficient:.11f}")
assert abs(e.restitution_coefficient - 0.43689530094234) < 1e-9
