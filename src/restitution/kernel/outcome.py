"""Codes of the status of an impact or an indentation, and columns of an outcome, as plain numbers without imports."""

# `restitution.impact.status.Status` contains their names and messages.
(
    SEPARATED, SINKS_IN, CAPTURED, TOO_MANY_STEPS, STEP_TOO_SMALL, NOT_FINITE, NOT_ACCURATE, TOO_DEEP, INADMISSIBLE,
) = range(9)  # fmt: skip
# The same for an indentation, in `restitution.indentation.result.IndentationStatus`.
IN_CONTACT = 1

# Largest e of a body that counts as held, with e = 0, by a liquid or by a target that moves.
LEAST_RESTITUTION = 1e-6

OUTCOME = (
    "restitution_coefficient",
    "contact_time",
    "max_indentation_depth",
    "max_force",
    "max_contact_radius",
    "residual_indentation_depth",
    "status",
    "factorisations",
)
(
    RESTITUTION, CONTACT_TIME, MAX_DEPTH, MAX_FORCE, MAX_RADIUS, RESIDUAL_DEPTH, STATUS, FACTORISATIONS,
) = range(len(OUTCOME))  # fmt: skip
