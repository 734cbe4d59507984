"""Validity of a result: each assumption of the theory with its number, its threshold and what to do."""
