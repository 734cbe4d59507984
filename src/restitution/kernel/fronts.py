"""Fronts of a contact at the nodes of a step, and what the elements there feel.

The front is where the load of the following elements, or the gap of the free ones, is zero. Eight nodes whose fronts
lie in one panel are found together; others follow one by one, along the panels.
"""

import math
from typing import Any

from restitution.kernel.compile import compiled, inlined
from restitution.kernel.driver import (
    FOLLOWING,
    FREE_PANELS,
    NO_FRONT_YET,
    PI,
    SHRINKS,
    SLOPE,
    A,
    D,
    Driver,
    F,
    Room,
    V,
    Y,
)
from restitution.kernel.lanes import (
    WIDTH,
    absolute,
    at_least,
    broadcast,
    exp,
    from_lane,
    largest,
    read8,
    where_positive,
    write8,
)
from restitution.kernel.panels import (
    FORGOTTEN,
    FROZEN,
    NODES,
    Solid,
    Stack,
    locate,
    touch,
    write_displacements,
    write_loads,
)
from restitution.kernel.path import Path, radii_and_integrals, radius_and_integral

# Steps of Newton's method for eight nodes; where they do not do, the panels are looked through.
_MOST_TOGETHER = 5
# Fewer nodes follow one by one.
_FEW = 2


@inlined
def shared_load(solid: Solid, room: Room, i: int) -> float:
    """Load that all following elements share at a node: Einf d + eta d' + sum E_k h_k."""
    drive = solid.equilibrium * room.nodes[D, i] + solid.viscosity * room.nodes[V, i]
    for k in range(solid.rates.shape[0]):
        drive += solid.moduli[k] * room.h[k, i]
    return drive


@inlined
def at_eight(row: Any, first: int, behind: int) -> Any:
    """Return the numbers of a row at eight nodes from the first on; behind a node those of the node before it."""
    return from_lane(behind - first, broadcast(row[behind - 1]), read8(row, first))


@inlined
def write_polynomials(z: Any, basis: Any) -> None:
    """Write the Chebyshev polynomials at eight z, and their slopes."""
    x = 2.0 * z - 1.0
    before, here, slope_before, slope = broadcast(1.0), x, broadcast(0.0), broadcast(2.0)
    write8(basis, 0, 0, 0, before)
    write8(basis, 1, 0, 0, slope_before)
    for n in range(1, NODES):
        write8(basis, 0, n, 0, here)
        write8(basis, 1, n, 0, slope)
        slope_before, slope = slope, 4.0 * here + 2.0 * (x * slope) - slope_before
        before, here = here, 2.0 * (x * here) - before


@inlined
def values_at(coefficients: Any, p: int, q: int, basis: Any, which: int) -> Any:
    """Return a polynomial of a panel at eight z (`which` 0), or its slope (1)."""
    value = broadcast(0.0)
    for n in range(NODES):
        value = value + coefficients[p, q, n] * read8(basis, which, n, 0)
    return value


@inlined
def shares(kind: int, z: Any) -> Any:
    """Return the shares of a step at eight z, and their slopes; see `panels.share`."""
    if kind == FROZEN:
        return 0.0 * z, 0.0 * z
    base = z if kind > 0 else 1.0 - z
    power = broadcast(1.0)
    for _ in range(abs(kind) - 1):
        power = power * base
    pace = float(abs(kind)) * power
    return (power * base if kind > 0 else 1.0 - power * base), pace


@inlined
def write_decays(rates: Any, panels: Stack, p: int, z: Any, t: Any, basis: Any, decays: Any) -> None:
    """Write polynomials at eight z of a panel, and what is left of each of its parts at eight times."""
    write_polynomials(z, basis)
    elapsed = t - panels.start[p] - panels.length[p] * shares(panels.kind[p], z)[0]
    for k in range(rates.shape[0]):
        write8(decays, k, 0, exp(at_least(-rates[k] * elapsed, FORGOTTEN)))


@compiled
def locate_together(solid: Solid, panels: Stack, p: int, follows: bool, t: Any, drive: Any, z: Any, room: Room) -> Any:
    """Return z, y and the slope of load or gap over y at eight fronts near one panel, and which of them lie in it.

    `drive` are the shared loads, or the depths. The last result is positive for fronts that were found in the panel.
    """
    end, last, basis, decays = panels.end[p], 1.0, room.eight, room.decays
    rates = solid.rates if follows else solid.recoveries
    y, steepness, inside = z, z, 0.0 * z
    for _ in range(_MOST_TOGETHER):
        write_decays(rates, panels, p, z, t, basis, decays)
        y, rise = values_at(panels.coefficients, p, 0, basis, 0), values_at(panels.coefficients, p, 0, basis, 1)
        pace = panels.length[p] * shares(panels.kind[p], z)[1]
        sign, stiffness = (-1.0, solid.equilibrium) if follows else (1.0, 1.0)
        value, slope = sign * (stiffness * (y * y)), (2.0 * sign * stiffness) * (y * rise)
        value = value + drive if follows else value - drive
        for k in range(rates.shape[0]):
            decay, part = read8(decays, k, 0), values_at(panels.coefficients, p, 1 + k, basis, 0)
            value = value + decay * part
            slope = slope + decay * (values_at(panels.coefficients, p, 1 + k, basis, 1) + rates[k] * (pace * part))
        # Both fall towards the top of the panels.
        step = 0.0 - value / slope
        z = z + step
        y, steepness = y + rise * step, absolute(slope / rise)
        inside = where_positive(0.0 - slope, where_positive(absolute(rise), z * (end - z)))
        size = largest(where_positive(inside, absolute(step)))
        if size <= 1e-11 or size * size * size <= 1e-16 * last * last:
            return z, y, steepness, inside
        last, z = size, end - at_least(end - at_least(z, 0.0), 0.0)
    return z, y, steepness, 0.0 * z


@compiled
def write_fronts_together(solid: Solid, room: Room, path: Path, phase: int, first: int) -> int:
    """Write fronts from a node on that lie in one panel, and what the elements there feel; return their number.

    What is written behind them is for later fronts to replace.
    """
    nodes, basis, decays, p, behind = room.nodes, room.eight, room.decays, room.at[first], first
    follows = phase == SHRINKS
    panels = room.following if follows else room.free
    while behind < min(first + WIDTH, NODES) and room.at[behind] == p:
        behind += 1
    if p < 0 or behind - first < _FEW:
        return 0
    t, drive = at_eight(room.times, first, behind), at_eight(nodes[D], first, behind)
    if follows:
        drive = solid.equilibrium * drive + solid.viscosity * at_eight(nodes[V], first, behind)
        for k in range(solid.rates.shape[0]):
            drive = drive + solid.moduli[k] * at_eight(room.h[k], first, behind)
    z, y, steepness, inside = locate_together(
        solid, panels, p, follows, t, drive, at_eight(room.z, first, behind), room
    )  # fmt: skip
    count = 0
    while count < behind - first and inside[count] > 0.0:
        count += 1
    if count == 0:
        return 0
    y = at_least(y, 0.0)
    radius, integral = radii_and_integrals(path, y, room.radii)
    force, terms = broadcast(0.0), solid.recoveries.shape[0]
    write_decays(solid.rates if follows else solid.recoveries, panels, p, z, t, basis, decays)
    for j in range(0 if follows else terms):
        part = read8(decays, j, 0) * values_at(panels.coefficients, p, 1 + j, basis, 0)
        write8(room.displacements, j, first, part)
    for k in range(solid.rates.shape[0]):
        load = broadcast(0.0)
        if follows:
            decay, common = read8(decays, k, 0), solid.moduli[k] * read8(room.h, k, first)
            load = decay * values_at(panels.coefficients, p, 1 + k, basis, 0) + common
            total = decay * values_at(panels.coefficients, p, 1 + solid.rates.shape[0] + k, basis, 0) + common * radius
            write8(room.L, k, first, total)
            force = force + total
        else:
            for j in range(terms):
                load = load + solid.moduli_of[k, j] * read8(room.displacements, j, first)
        write8(room.loads, k, first, load)
    write8(room.z, first, from_lane(count, read8(room.z, first), z))
    write8(nodes, Y, first, y)
    write8(nodes, SLOPE, first, steepness)
    write8(nodes, A, first, radius)
    write8(nodes, PI, first, integral)
    write8(nodes, F, first, force)
    return count


@inlined
def guess_next(room: Room, i: int) -> None:
    """Let the first search for the fronts at the next nodes start where the last two nodes lead."""
    if room.places[NO_FRONT_YET] == 1:
        p, z, pace = room.at[i], room.z[i], 0.0
        if room.at[i - 1] == p and room.times[i] > room.times[i - 1]:
            pace = (z - room.z[i - 1]) / (room.times[i] - room.times[i - 1])
        for n in range(i + 1, NODES):
            room.at[n] = p
            room.z[n] = min(max(z + pace * (room.times[n] - room.times[i]), 0.0), 1.0)


@compiled
def write_shrinking_front(solid: Solid, driver: Driver, room: Room, path: Path, i: int) -> None:
    """Write the front of the shrinking contact at a node, its loads, and the part of the force by the memory."""
    nodes, basis, slopes = room.nodes, room.basis[0], room.basis[1]
    p, z, y, nodes[SLOPE, i] = locate(
        solid, room.following, room.places[FOLLOWING], True, room.times[i], shared_load(solid, room, i),
        max(room.at[i], 0), room.z[i], basis, slopes,
    )  # fmt: skip
    room.at[i], room.z[i] = max(p, 0), z
    # Behind the end of the contact no load is left.
    nodes[Y, i] = max(y, 0.0) if p >= 0 else 0.0
    nodes[A, i], nodes[PI, i] = radius_and_integral(path, nodes[Y, i])
    write_loads(
        solid, room.following, max(p, 0), z, room.times[i], room.h[:, i], nodes[A, i], room.loads[:, i], room.L[:, i],
        basis, slopes,
    )  # fmt: skip
    if p < 0 and solid.viscosity > 0.0 and not driver.by_depth and driver.mass == 0.0:
        # Behind the end the rate would jump: the elements at the axis pull, so that the depth goes on smoothly.
        nodes[A, i] = nodes[A, 0]
        for k in range(solid.rates.shape[0]):
            room.L[k, i] = nodes[A, i] * room.loads[k, i]
    nodes[F, i] = 0.0
    for k in range(solid.rates.shape[0]):
        nodes[F, i] += room.L[k, i]
    guess_next(room, i)


@compiled
def write_growing_front(solid: Solid, room: Room, path: Path, i: int) -> None:
    """Write the front of the growing contact at a node, and displacement and loads of the element there."""
    nodes, basis, slopes = room.nodes, room.basis[0], room.basis[1]
    p, y = -1, 0.0
    nodes[F, i], nodes[SLOPE, i] = 0.0, 0.0
    if room.places[FREE_PANELS] > 0 and room.at[i] >= 0:
        p, room.z[i], y, nodes[SLOPE, i] = locate(
            solid, room.free, room.places[FREE_PANELS], False, room.times[i], nodes[D, i], room.at[i], room.z[i],
            basis, slopes,
        )  # fmt: skip
    room.at[i] = p
    if p < 0:
        # Virgin surface.
        y = math.sqrt(max(nodes[D, i], 0.0))
        nodes[SLOPE, i] = 2.0 * y
        room.displacements[:, i] = 0.0
    else:
        write_displacements(solid, room.free, p, room.z[i], room.times[i], room.displacements[:, i], basis, slopes)
    touch(solid, room.displacements[:, i], room.loads[:, i])
    nodes[Y, i] = max(y, 0.0)
    nodes[A, i], nodes[PI, i] = radius_and_integral(path, nodes[Y, i])
    guess_next(room, i)


@compiled
def write_fronts(solid: Solid, driver: Driver, room: Room, path: Path, phase: int) -> None:
    """Write the fronts at the nodes, and what the elements there feel."""
    i = 1
    while i < NODES:
        count = write_fronts_together(solid, room, path, phase, i)
        if count > 0:
            guess_next(room, i + count - 1)
        elif phase == SHRINKS:
            write_shrinking_front(solid, driver, room, path, i)
        else:
            write_growing_front(solid, room, path, i)
        i += max(count, 1)
    room.places[NO_FRONT_YET] = 0
