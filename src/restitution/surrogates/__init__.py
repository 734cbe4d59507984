"""Interpolants of a stated error in place of solves."""
