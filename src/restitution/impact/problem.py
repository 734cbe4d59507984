"""The impact problem and its groups; impacts of two bodies, or of a fall."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import InitVar, dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from restitution import quantities
from restitution.axes import Axes, align, aligned, axes_of, is_named, named, spread_array
from restitution.checks import (
    Numeric,
    common_shape,
    instance,
    pair,
    positive_or_infinite,
    truth,
)
from restitution.contact.adhesion import Adhesion, require_near, require_smooth
from restitution.contact.geometry import BALL_ON_TARGET, Contact, Geometry
from restitution.contact.profiles import Parabola, as_profile, sphere_mass
from restitution.errors import InputError, InputTypeError
from restitution.impact.scaling import viscosity_unit
from restitution.material.prony import PronySeries
from restitution.material.viscoelastic import Material, single_material

# Parts of an impact that are no numbers but may be arrays of them.
_OBJECTS = ("material", "profile", "counter_material", "adhesion")
_NUMBERS = (*quantities.BODY, *quantities.SLIDING)
# Tolerance of a first solution, whose largest contact radius is good to 1e-8 then.
_ESTIMATE_RTOL = 1e-6

STANDARD_GRAVITY = 9.80665
"""Standard acceleration of free fall [m/s^2]."""

SOLID_BALL = 0.4
"""Moment of inertia of a solid ball over m R^2."""


def fall_velocity(height: Any, gravity: Any) -> Any:
    """Return the velocity sqrt(2 g h) [m/s] after a free fall from the height h [m] at the gravity g [m/s^2]."""
    return np.sqrt(2.0 * gravity * height)


def directed(velocity: Any, angle: Any, speed: Any = None) -> tuple[Any, Any]:
    """Return the normal and the tangential velocity [m/s] at an angle of incidence [rad], which keeps the first one.

    A speed [m/s] of the centre, which is not None, replaces the normal velocity.
    """
    if speed is None:
        return velocity, velocity * np.tan(angle)
    return speed * np.cos(angle), speed * np.sin(angle)


@dataclass(frozen=True, eq=False)
class Impact:
    """Impact of a body on a viscoelastic half-space, or on another target, in SI units: normal, or with friction.

    Numbers may be arrays that broadcast against each other, those of the materials and of the geometry included: the
    results then are arrays of the common shape. DataArrays keep their dimensions and coordinates by name.

    Parameters
    ----------
    material : Material
        Material of the target, or an array of materials.
    profile : Geometry
        Profile of the indenting body, such as `Parabola(radius)`, or another geometry; for two curved bodies that of
        the gap between them.
    mass : float or array
        Mass m [kg], > 0; of two free bodies the reduced mass.
    velocity : float or array
        Normal impact velocity v0 [m/s], > 0; of two bodies their relative velocity. Left out where a speed is given.
    counter_material : Material, optional
        Material of the indenting body, which is rigid by default. The compliances of both bodies add.
    external_force : float or array
        Constant force [N] on the body towards the half-space during contact, such as its weight m g; >= 0.
    impedance : float or array
        Mechanical impedance Z [kg/s] of the target, > 0, such as that of `plate_impedance`: the target moves with
        the velocity F/Z, where F is the contact force. Infinite (the default) for a target that does not move.
    body_size : float, optional
        Smallest dimension [m] of the body that is taken as a half-space, such as its thickness, > 0. It does not
        change the solution: the validity report compares it with the contact radius and with the path of waves.
    diameters : tuple
        Diameters of the bodies of `material` and `counter_material` over the radius of the profile; infinite for a
        flat target. The validity report compares them with the path of waves. By default `material` is that of a flat
        target and the other body is a ball; ``(2, inf)`` is a soft ball on a flat target. `collision` sets them.
    friction : float or array, optional
        Coulomb's coefficient mu [-], from 0 to infinity, where nothing slips, for an oblique impact on a half-space.
    tangential_velocity : float or array
        Velocity v_x [m/s] of the centre along the surface; of two bodies that of their contact points.
    spin : float or array
        Angular velocity w [rad/s] of a single ball about the axis across the plane of motion; > 0 moves its contact
        point along x.
    gyration : float or array
        Moment of inertia over m R^2 [-], > 0: 2/5 of a solid ball, `hollow_gyration` of a hollow one.
    angle : float or array, optional
        Angle of incidence [rad] from the normal, > -pi/2 and < pi/2, in place of `tangential_velocity`.
    speed : float or array, optional
        Speed u0 [m/s] of the centre, > 0, in place of `velocity`: v0 = u0 cos(angle), v_x = u0 sin(angle).
    adhesion : Adhesion, optional
        Attraction of the surfaces, without friction.

    Raises
    ------
    InputError
        If a number is out of its range, or a material or the profile of another type.

    Notes
    -----
    The motion is in one plane. This is exact where no body spins about the normal, and where the contact points move
    along one line at first and later. Arrays of velocities and spins are several impacts, not vectors.

    Quasi-static, small strain, half-space, adhesionless unless `adhesion` is given; `ImpactResult.validity` compares
    these assumptions with the numbers of the impact. Friction is that of Coulomb, and leaves the normal motion as it
    is; see `ObliqueResult`.

    Examples
    --------
    >>> from restitution.contact.profiles import Parabola
    >>> from restitution.material.classical import standard_solid
    >>> rubber = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
    >>> Impact(material=rubber, profile=Parabola(radius=0.01), mass=0.005, velocity=[0.5, 1.0]).shape
    (2,)
    """

    material: Material
    profile: Geometry
    mass: Numeric
    velocity: Numeric = math.nan
    counter_material: Material | None = field(default=None, kw_only=True)
    external_force: Numeric = field(default=0.0, kw_only=True)
    impedance: Numeric = field(default=math.inf, kw_only=True)
    body_size: float | None = field(default=None, kw_only=True)
    diameters: tuple[Numeric, Numeric] = field(default=BALL_ON_TARGET, kw_only=True)
    friction: Numeric | None = field(default=None, kw_only=True)
    tangential_velocity: Numeric = field(default=0.0, kw_only=True)
    spin: Numeric = field(default=0.0, kw_only=True)
    gyration: Numeric = field(default=SOLID_BALL, kw_only=True)
    angle: InitVar[Any] = field(default=None, kw_only=True)
    speed: InitVar[Any] = field(default=None, kw_only=True)
    adhesion: Adhesion | None = field(default=None, kw_only=True)

    axes: ClassVar[Axes | None] = None
    """Names of the axes of an array of impacts; None where they have no names."""

    def __post_init__(self, angle: Any, speed: Any) -> None:
        if angle is not None or speed is not None:
            self._direct(angle, speed)
        align(self, (*_OBJECTS, *_NUMBERS))
        if not isinstance(self.adhesion, (Adhesion, type(None))):
            raise InputTypeError("adhesion", self.adhesion, "must be an Adhesion")
        object.__setattr__(self, "profile", self.contact.profile)
        # Defaults need no check.
        if self.diameters is not BALL_ON_TARGET:
            both = pair("diameters", self.diameters, "must be a pair of numbers")
            object.__setattr__(self, "diameters", tuple(positive_or_infinite("diameters", each) for each in both))
        for name in quantities.BODY:
            object.__setattr__(self, name, quantities.INPUTS[name].check(getattr(self, name)))
        self._check_sliding()
        _ = self.shape
        forces = np.where(np.isinf(self.impedance), 0.0, self.external_force)
        if np.any(forces):
            rule = "must be 0 where the target has an impedance, as a force would drive such a target for ever"
            raise InputError("external_force", self.external_force, rule, "N")
        if self.adhesion is not None:
            self._check_adhesion()

    def refuse_adhesion(self) -> None:
        """Refuse adhesion, for what has no theory of it."""
        if self.adhesion is not None:
            raise InputError("adhesion", rule="must be left out here; solve and sweeps have it")

    def _check_adhesion(self) -> None:
        """Refuse what the theory of adhesive impacts does not have."""
        assert self.adhesion is not None
        profile = as_profile(self.profile, "adhesion")
        require_smooth(profile)
        require_near(profile, self.adhesion)
        if self.friction is not None:
            raise InputError("friction", self.friction, "must be left out with adhesion")
        if np.any(np.isfinite(self.impedance)):
            raise InputError("impedance", self.impedance, "must be infinite with adhesion", "kg/s")

    def _direct(self, angle: Any, speed: Any) -> None:
        """Set the velocities from an angle and a speed, whose numbers may have names of axes."""
        if angle is None or np.any(_in_si("tangential_velocity", self.tangential_velocity)):
            raise InputError("tangential_velocity, angle", rule="must be one of them; a speed belongs to an angle")
        if speed is not None and not (type(self.velocity) is float and math.isnan(self.velocity)):
            raise InputError("velocity, speed", rule="must be one of them, not both")
        motion = {"velocity": self.velocity if speed is None else None, "angle": angle, "speed": speed}
        values = (_in_si(name, value) for name, value in motion.items())
        normal, along = directed(*values)
        vars(self).update(velocity=normal, tangential_velocity=along)

    def _check_sliding(self) -> None:
        """Check the numbers of the tangential motion; refuse contacts without a theory of friction."""
        for name in quantities.SLIDING:
            value = getattr(self, name)
            # The defaults need no check, so that a contact without friction pays nothing.
            if value is not getattr(type(self), name):
                object.__setattr__(self, name, quantities.INPUTS[name].check(value))
        if self.friction is None:
            for name in ("tangential_velocity", "spin"):
                value = getattr(self, name)
                if value if type(value) is float else np.any(value):
                    rule = f"must be given where {name} is not 0; 0 for a smooth contact"
                    raise InputError("friction", rule=rule)
            return
        as_profile(self.profile, "friction")
        if np.any(np.isfinite(self.impedance)):
            rule = "must be infinite where there is friction: the target may not move"
            raise InputError("impedance", self.impedance, rule, "kg/s")
        if not np.any(self.spin):
            return
        if not self.is_single_body:
            rule = "must be 0 of two balls; their contact points have the relative velocity v_x + R1 w1 + R2 w2"
            raise InputError("spin", self.spin, rule, "rad/s")
        if np.any(np.isnan(self.profile.ball_radius)):
            raise InputError("spin", self.spin, "must be 0 for a profile without the radius of a ball", "rad/s")

    @property
    def is_single_body(self) -> bool:
        """Whether one of the bodies is flat, so that the velocity of the contact point is that of one body."""
        return bool(np.any(np.isinf(self.diameters[0]) | np.isinf(self.diameters[1])))

    @cached_property
    def normal(self) -> Impact:
        """The impacts without friction and tangential motion, in the shape of their own numbers."""
        return replace(self, friction=None, tangential_velocity=0.0, spin=0.0, gyration=SOLID_BALL)

    @cached_property
    def contact(self) -> Contact:
        """The profile and the materials of both bodies."""
        return Contact(self.material, self.profile, self.counter_material, self.body_size, self.diameters)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Common shape of all numbers; () for a single impact."""
        shapes = {name: np.shape(getattr(self, name)) for name in quantities.BODY}
        shapes |= {name: shape for name in quantities.SLIDING if (shape := np.shape(getattr(self, name)))}
        shapes |= {"profile": self.profile.rows}
        shapes |= {} if self.adhesion is None else {"adhesion": self.adhesion.shape}
        return common_shape(shapes | ({"material": self.contact.shape} if self.contact.shape else {}))

    @cached_property
    def is_split(self) -> bool:
        """Whether its rows have several materials or geometries that one batch does not hold."""
        return self.contact.is_split or any(np.ndim(self.profile.numbers[name]) for name in self.profile.apart)

    @cached_property
    def reduced_moduli(self) -> PronySeries:
        """Reduced relaxation modulus E*(t) [Pa] of all impacts; or an effective one of each on a bonded layer."""
        modulus = self.contact.reduced_modulus
        if self.profile.separable:
            return modulus
        from restitution.impact.batch import Batch

        # The size of a contact is that with the modulus of the material.
        radius = Batch.from_impact(self, modulus).max_contact_radii(_ESTIMATE_RTOL)
        return self.profile.effective_moduli(self.material, radius.reshape(self.shape)).reshaped(self.shape)

    def parts(self) -> Iterator[tuple[NDArray[np.intp], Impact]]:
        """Yield impacts whose rows one batch holds, and their places in the raveled shape."""
        count = math.prod(self.shape)
        if not self.is_split:
            yield np.arange(count), self
            return
        parameters = self.profile.numbers
        kinds = [np.arange(math.prod(self.contact.shape)).reshape(self.contact.shape)] if self.contact.is_split else []
        kinds += [parameters[name] for name in self.profile.apart if np.ndim(parameters[name])]
        # Groups are numbered again after each kind, so that the product of many does not overflow.
        groups = np.zeros(count, dtype=np.intp)
        for values in kinds:
            codes = np.unique(np.broadcast_to(values, self.shape), return_inverse=True)[1].reshape(-1)
            groups = np.unique(groups * (int(codes.max(initial=0)) + 1) + codes, return_inverse=True)[1]
        order = np.argsort(groups, kind="stable")
        for places in np.split(order, np.flatnonzero(np.diff(groups[order])) + 1):
            yield places, self.take(places, alike=True)

    def sel(self, indexers: Mapping[Any, Any] | None = None, method: str | None = None, **names: Any) -> Impact:
        """Return impacts by coordinates of their named axes.

        Parameters
        ----------
        indexers : dict, optional
            Values along axes by name; or keywords.
        method : str, optional
            "nearest" for the nearest coordinate; see `xarray.DataArray.sel`.

        Raises
        ------
        InputError
            If the axes have no names, or an indexer is no coordinate.

        Examples
        --------
        >>> import restitution as rs, xarray as xr
        >>> v = xr.DataArray([0.5, 1.0, 2.0], dims="velocity", coords={"velocity": [0.5, 1.0, 2.0]})
        >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45)
        >>> rs.Impact(rubber, rs.Parabola(0.01), mass=0.005, velocity=v).sel(velocity=0.9, method="nearest").velocity
        1.0
        """
        if self.axes is None:
            raise InputError("impact", rule="must have named axes, which numbers that are DataArrays give it")
        places = self.axes.sel({**(indexers or {}), **names}, method)
        return named(self.take(places.values), axes_of(places) if places.ndim else None)

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> Impact:
        """Return the impacts of an array over axes of other names; their own are `axes`."""
        target, shape = axes or self.axes, self.shape
        assert target is not None
        parts = {name: getattr(self, name) for name in _OBJECTS}
        parts = {name: part and part.spread(names, target) for name, part in parts.items()}
        numbers = {name: spread_array(getattr(self, name), target, names, shape) for name in _NUMBERS}
        diameters = tuple(spread_array(each, target, names, shape) for each in self.diameters)
        return replace(self, **parts, **numbers, diameters=diameters)

    def take(self, places: NDArray[np.intp], *, alike: bool = False) -> Impact:
        """Return rows of the raveled impact in the shape of the places.

        Numbers that all rows of the impact share stay single. Rows that are `alike` belong to one batch, and what they
        must share to do so becomes single.
        """
        shape = self.shape
        first = places[:1].reshape(()) if alike and self.contact.is_split else places
        material, counter = (None if each is None else each.take(shape, first)
                             for each in (self.material, self.counter_material))  # fmt: skip
        assert material is not None
        numbers: dict[str, Any] = {name: _rows(getattr(self, name), shape, places) for name in _NUMBERS}
        diameters = tuple(_rows(each, shape, places) for each in self.diameters)
        profile = self.profile.take(shape, places, self.profile.apart if alike else ())
        adhesion = self.adhesion and self.adhesion.take(shape, places)
        return replace(
            self, material=material, profile=profile, counter_material=counter, diameters=diameters,
            adhesion=adhesion, **numbers,
        )  # fmt: skip

    @property
    def reduced_modulus(self) -> PronySeries:
        """Reduced relaxation modulus E*(t) [Pa] of the contact; on a bonded layer it may be an effective one."""
        if self.profile.separable:
            return self.contact.reduced_modulus
        if self.reduced_moduli.size > 1:
            raise InputError("impact", rule="must be a single one: those of this array have moduli of their own")
        return self.reduced_moduli.row()


def require_outputs(impact: Impact | list[Impact], names: Iterable[str]) -> None:
    """Refuse outputs of friction or adhesion where there is none; a list has them in all or in none."""
    first = impact[0] if isinstance(impact, list) else impact
    for kind, outputs in {"friction": quantities.OBLIQUE, "adhesion": quantities.ADHESION}.items():
        for name in names if getattr(first, kind) is None else ():
            if name in outputs:
                raise InputError("outputs", name, f"is of an impact with {kind}, which this one does not have")


def _in_si(name: str, value: Any) -> Any:
    """Return checked values of an input in SI, with their names of axes; None stays."""
    if value is None:
        return None
    checked = np.asarray(quantities.INPUTS[name].check(value))
    return value.copy(data=checked) if is_named(value) else checked[()]


def _rows(value: Numeric, shape: tuple[int, ...], places: NDArray[np.intp]) -> Numeric:
    """Return the numbers of some rows of an array."""
    return np.broadcast_to(value, shape).reshape(-1)[places][()] if np.ndim(value) else value


@dataclass(frozen=True, eq=False)
class Body:
    """Body of a collision: a ball, or a wall.

    Parameters
    ----------
    material : Material or None
        Material of the body; None if it is rigid.
    radius : float or array
        Radius R [m] of the surface at the point of contact, > 0; infinite (the default) for a wall or a half-space.
    mass : float or array, optional
        Mass [kg], > 0, may be infinite. The default is the mass of a solid sphere of the density of the material, and
        infinite for a wall.

    Raises
    ------
    InputError
        If a number is out of range, the mass of a ball is neither given nor known, or the material is of another type.

    Notes
    -----
    Each body counts as a half-space: valid where the contact is small compared with it.

    Examples
    --------
    >>> ball = Body(Material(1e6, 1e9, density=1200.0), radius=0.01)
    >>> round(ball.mass, 9)
    0.005026548
    """

    material: Material | None
    radius: Numeric = math.inf
    mass: Numeric | None = None

    axes: ClassVar[Axes | None] = None
    """Names of the axes of an array of bodies; None where they have no names."""

    def __post_init__(self) -> None:
        if self.material is not None and not isinstance(self.material, Material):
            raise InputTypeError("material", self.material, "must be a Material, or None for a rigid body")
        align(self, ("material", "radius", "mass"))
        radius = positive_or_infinite("radius", self.radius, "m")
        object.__setattr__(self, "radius", radius)
        mass = self.mass
        if mass is None and not np.all(np.isfinite(radius)):
            if np.ndim(radius):
                raise InputError("mass", rule="must be given where some of the bodies are walls")
            mass = math.inf
        elif mass is None:
            if self.material is None or self.material.density is None:
                raise InputError("mass", rule="must be given for a ball whose material has no density")
            mass = sphere_mass(self.material.density, radius)
        object.__setattr__(self, "mass", positive_or_infinite("mass", mass, "kg"))

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of an array of bodies; () for one."""
        material = () if self.material is None else self.material.shape
        numbers: dict[str, Any] = {"radius": self.radius, "mass": self.mass}
        return common_shape({"material": material} | {name: np.shape(value) for name, value in numbers.items()})

    def spread(self, names: tuple[Any, ...], axes: Axes | None = None) -> Body:
        """Return the bodies of an array over axes of other names; their own are `axes`."""
        target = axes or self.axes
        assert target is not None
        numbers = (spread_array(value, target, names, self.shape) for value in (self.radius, self.mass))
        return Body(self.material and self.material.spread(names, target), *numbers)


def collision(body_1: Body, body_2: Body, velocity: Any, *, external_force: Any = 0.0) -> Impact:
    """Return the central impact of two bodies.

    Parameters
    ----------
    body_1, body_2 : Body
        Two balls, or a ball and a wall, in any order.
    velocity : float or array
        Relative velocity [m/s], > 0.
    external_force : float or array
        Constant force [N] that presses the bodies together during contact, >= 0. On a wall that cannot move it is the
        weight of the ball; for two bodies in free fall it is zero.

    Returns
    -------
    Impact
        With the radius 1/R = 1/R1 + 1/R2, the mass 1/m = 1/m1 + 1/m2, and both materials, whose compliances add.

    Raises
    ------
    InputError
        If both bodies are rigid, flat, or immovable, or a body is of another type.

    Notes
    -----
    Exact for the parabolic gap between two spheres (Hertz 1882), and by the correspondence principle for any two
    materials (Lee and Radok 1960). All velocities are relative, and the depth is the approach of the centres.

    Examples
    --------
    >>> import restitution as rs
    >>> rubber = rs.standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)
    >>> ball, wall = rs.Body(rubber, radius=0.01), rs.Body(None)
    >>> print(round(rs.solve(rs.collision(ball, wall, velocity=1.0)).restitution_coefficient, 6))
    0.333914
    """
    for name, body in (("body_1", body_1), ("body_2", body_2)):
        if not isinstance(body, Body):
            raise InputTypeError(name, body, "must be a Body")
    numbers = {"body_1": body_1, "body_2": body_2, "velocity": velocity, "external_force": external_force}
    numbers, axes = aligned(numbers)
    return named(_collision(**numbers), axes)


def _collision(body_1: Body, body_2: Body, velocity: Any, external_force: Any) -> Impact:
    """Return the central impact of two bodies, of arrays over the same axes."""
    radius = _reduced("radius", "m", "both bodies are flat, but one must be curved", body_1.radius, body_2.radius)
    mass = _reduced("mass", "kg", "both bodies are immovable", body_1.mass, body_2.mass)
    material, counter = body_1.material or body_2.material, body_2.material if body_1.material else None
    if material is None:
        raise InputError("material", rule="both bodies are rigid, but one must deform")
    with np.errstate(all="ignore"):  # a radius that underflows is refused below
        first, second = (2.0 * (np.asarray(body.radius) / radius) for body in (body_1, body_2))
    diameters = (first, second) if body_1.material else (second, first)
    # The axes of these numbers are those of the bodies now.
    speed, force = (quantities.check(name, value)
                    for name, value in (("velocity", velocity), ("external_force", external_force)))  # fmt: skip
    options: dict[str, Any] = {"external_force": force, "diameters": diameters}
    return Impact(material, Parabola(radius), mass, speed, counter_material=counter, **options)


def two_bodies(problem: Any) -> tuple[Body, Body]:
    """Return the members of a pair of bodies, which stands for an impact where the velocity does not matter."""
    members: list[Any] = list(problem) if isinstance(problem, (tuple, list)) else []
    if len(members) != 2 or not all(isinstance(body, Body) for body in members):
        raise InputTypeError("problem", problem, "must be an Impact or a pair of Body")
    return members[0], members[1]


def _reduced(name: str, unit: str, problem: str, first: Any, second: Any) -> Any:
    """Return the reduced mass or radius; one of the two may be infinite."""
    if np.any(np.isinf(first) & np.isinf(second)):
        raise InputError(name, math.inf, problem, unit)
    combined = reduced(first, second)
    return combined if combined.ndim else float(combined)


def reduced(first: Any, second: Any) -> Any:
    """Reduced mass or radius x, 1/x = 1/first + 1/second; either may be infinite. Zero where 1/x overflows."""
    with np.errstate(over="ignore"):
        return np.asarray(1.0 / (1.0 / np.asarray(first) + 1.0 / np.asarray(second)))


def drop(
    body: Body, ground: Body, height: Any, *, gravity: Any = STANDARD_GRAVITY, with_weight: bool = True
) -> Impact:
    """Return the impact of a body that falls from rest onto ground that does not move, without air resistance.

    Parameters
    ----------
    body : Body
        The falling body, of finite mass m.
    ground : Body
        The ground, of infinite mass: a wall, or a ball that is held.
    height : float or array
        Height h [m] of the lowest point of the body over the undeformed surface, > 0.
    gravity : float or array
        Acceleration of free fall g [m/s^2], > 0.
    with_weight : bool
        Whether the weight m g also acts during contact.

    Returns
    -------
    Impact
        With the velocity sqrt(2 g h).

    Raises
    ------
    InputError
        If a number is out of range, the body is immovable or the ground is not.

    Examples
    --------
    >>> from restitution.material.classical import standard_solid
    >>> rubber = standard_solid(1e6, 1e7, 1e3, poisson_ratio=0.45, density=1200.0)
    >>> impact = drop(Body(rubber, radius=0.01), Body(None), height=0.5, gravity=9.81)
    >>> print(round(impact.velocity, 6), round(impact.external_force, 6))
    3.132092 0.04931
    """
    for name, each in (("body", body), ("ground", ground)):
        if not isinstance(each, Body):
            raise InputTypeError(name, each, "must be a Body")
    values, axes = aligned({"body": body, "ground": ground, "height": height, "gravity": gravity})
    body, ground, height, gravity = values.values()
    fall = np.asarray(quantities.check("drop_height", height, "height"))
    acceleration = np.asarray(quantities.check("gravity", gravity))
    if not np.all(np.isfinite(np.asarray(body.mass, dtype=np.float64))):
        raise InputError("body.mass", body.mass, "must be finite for a body that falls", "kg")
    if np.any(np.isfinite(np.asarray(ground.mass, dtype=np.float64))):
        raise InputError("ground.mass", ground.mass, "must be infinite for ground that does not move", "kg")
    with np.errstate(over="ignore"):  # an infinite velocity or weight is refused
        impact = _collision(body, ground, fall_velocity(fall, acceleration), 0.0)
        weight = impact.mass * acceleration
    impact = replace(impact, external_force=weight) if truth("with_weight", with_weight) else impact
    return named(impact, axes)


class DimensionlessGroups(NamedTuple):
    """Dimensionless groups that determine the restitution coefficient of a standard solid (Willert et al., eq. 11)."""

    p1: float
    p2: Numeric
    p3: Numeric


def dimensionless_groups(impact: Impact) -> DimensionlessGroups:
    """Return dimensionless groups p1, p2, p3 of a parabolic body on a standard solid.

    Parameters
    ----------
    impact : Impact
        A parabola on a standard solid with a constant bulk modulus, without a constant force.

    Returns
    -------
    DimensionlessGroups
        Static Poisson ratio p1 = nu, p2 = Ginf/G1 and p3 = eta (v0 R/(m^2 Ginf^3))^(1/5), all [-].

    Raises
    ------
    InputError
        If the impact is of another kind.

    Examples
    --------
    >>> from restitution.contact.profiles import Parabola
    >>> from restitution.material.classical import standard_solid
    >>> solid = standard_solid(1.0, 10.0, 2.0, poisson_ratio=0.3)
    >>> groups = dimensionless_groups(Impact(solid, Parabola(1.0), mass=1.0, velocity=1.0))
    >>> print(round(groups.p1, 12), groups.p2, groups.p3)
    0.3 0.1 2.0
    """
    material = single_material("impact.material", instance("impact", impact, Impact, "must be an Impact").material)
    shear, bulk = material.shear.simplified(), material.bulk
    reasons = [
        (impact.counter_material is not None, "both bodies deform"),
        (impact.profile.path_exponent != 1.0, "the profile is not a parabola"),
        (shear.branch_moduli.size != 1, f"the shear modulus has {shear.branch_moduli.size} branches, not 1"),
        (shear.parallel_viscosity > 0.0, "the shear modulus has a parallel dashpot"),
        (shear.equilibrium_modulus == 0.0, "the equilibrium modulus is 0"),
        (isinstance(bulk, PronySeries) and not bulk.is_elastic, "the bulk relaxes"),
        (bool(np.any(impact.external_force)), "a constant force acts"),
        (bool(np.any(np.isfinite(impact.impedance))), "the target has an impedance"),
        (impact.adhesion is not None, "the surfaces adhere"),
    ]
    for wrong, reason in reasons:
        if wrong:
            rule = f"must be of a rigid parabola on a standard solid, which has p1, p2, p3: here {reason}"
            raise InputError("impact", rule=rule)
    modulus, branch = shear.equilibrium_modulus, float(shear.branch_moduli[0])
    viscosity = branch * float(shear.relaxation_times[0])
    radius = np.asarray(impact.profile.path_coefficient) ** 2
    p3 = viscosity / viscosity_unit(modulus, np.asarray(impact.mass), np.asarray(impact.velocity), radius)
    return DimensionlessGroups(material.poisson_ratio, modulus / branch, float(p3) if p3.ndim == 0 else p3)
