"""Interpolants with a stated error that replace solves."""
