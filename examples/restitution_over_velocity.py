"""The coefficient of restitution of a rubber ball over its velocity."""

import numpy as np

import restitution as rs

rubber = rs.standard_solid(
    equilibrium_modulus=2e6,  # Pa, in shear
    branch_modulus=20e6,  # Pa
    viscosity=1e3,  # Pa s
    poisson_ratio=0.45,
)
velocity = np.geomspace(0.01, 1.0, 9)  # m/s
ball = rs.Impact(material=rubber, profile=rs.Parabola(radius=0.015), mass=0.0156, velocity=velocity)
result = rs.solve(ball)

print("velocity [m/s]  restitution  contact time [ms]")
for v, e, duration in zip(velocity, result.restitution_coefficient, result.contact_time, strict=True):
    print(f"{v:14.4f}  {e:11.6f}  {1e3 * duration:17.4f}")
