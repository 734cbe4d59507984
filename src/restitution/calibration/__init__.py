"""Force laws of particle and multibody codes, calibrated to the exact coefficient of restitution."""
