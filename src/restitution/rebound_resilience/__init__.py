"""Rebound resilience of standard tests, and the loss tangent that a measured one means."""
