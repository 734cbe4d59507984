"""The figures and the claims of one paper on compressibility and restitution.

E. Willert, J.-E. Leroy, M. Satora, Y. Scholtyssek, "The Influence of Compressibility on the Restitution
Coefficient for Viscoelastic Spheres in Low-Velocity Normal Impacts", TU Berlin.
"""
