"""Places of the numbers in the two arrays of the contact law: the constants of the law, and the state of a contact.

`law` holds the entries below, then the moduli and the times of the branches, then the table of a profile that is no
power law. A branch with time 0 is a dashpot, and its modulus a viscosity. The table holds the ends of its cells over
s = sqrt(depth), the origin, start and width of each cell, and the polynomials of a and of its integral.

`state` holds the entries below, then five numbers for each branch, then the rows of the nodes. A node is a place of
the foundation. It lies where the surface was touched when the depth first reached `PLACE`.
"""

# Constants of the law.
BRANCHES, NODES, EQUILIBRIUM, EXPONENT, COEFFICIENT, MAX_DEPTH, CELLS, CONSTANTS = range(8)

# State of a contact.
COUNT = 0  # nodes
CONTACT = 1  # nodes in contact: all up to the edge of the contact
DEPTH, RATE, STEP = 2, 3, 4  # depth, mean rate and length of the last step; length 0 before the first one
CLOCK = 5  # time
ELAPSED = 6  # length of step to which the decay, gain and bend of the branches belong
STIFFNESS = 7  # line load of all branches at the end of a step in which the displacement grows by 1
RADIUS = 8  # contact radius at the last node
# Of the cell at the edge: if its outer node was released, the growth of the contact radius over the cell; if the body
# touches the cell again, the gap at the outer node when the edge was at the inner one, with a minus sign.
EDGE = 9
NUMBERS = 10

# Five numbers for each branch: three that depend on the length of the step alone, and two of the cell at the edge.
DECAY = 0  # share of the line load that is left after the step
GAIN = 1  # line load at the end, if the displacement grows by 1 at a constant rate
BEND = 2  # further line load at the end, if the acceleration is 1 over the square of the step
BULGE = 3  # line load at the middle of the cell beyond the mean of its ends
BEYOND = 4  # line load at the outer end of the cell as if it still followed the body
BRANCH = 5

# Rows of the nodes; those of the line loads of the branches follow, and those of their inner forces: the integrals of
# the line load over x up to the node, less the line load of the node times x.
PLACE, BORN, INTEGRAL, DISPLACEMENT, TRIAL, ROWS = range(6)

# Number of coefficients of the contact radius and of its integral in each cell of a table.
RADIUS_TERMS, INTEGRAL_TERMS = 8, 12

_MEANINGS = {
    BRANCHES: "number of branches",
    NODES: "largest number of nodes",
    EQUILIBRIUM: "equilibrium modulus [Pa]",
    EXPONENT: "exponent p of the contact radius a = c s^p, s = sqrt(depth); -1 for a table",
    COEFFICIENT: "coefficient c [m^(1-p/2)]",
    MAX_DEPTH: "largest depth [m]",
    CELLS: "number of cells of the table of the profile",
}


def labels(branches: int) -> list[str]:
    """Meaning of each constant of a law that has no table."""
    of_branches = (
        "modulus of branch {} [Pa]; of a dashpot its viscosity [Pa s]",
        "time of branch {} [s]; of a dashpot 0",
    )
    return [*_MEANINGS.values(), *(text.format(k + 1) for text in of_branches for k in range(branches))]


def state_size(branches: int, nodes: int) -> int:
    """Length of the state of a contact."""
    return NUMBERS + BRANCH * branches + nodes * (ROWS + 2 * branches)
