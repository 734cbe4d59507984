"""Axes by name: numbers that are DataArrays keep their dimensions and coordinates, up to the results."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from restitution.errors import InputError

if TYPE_CHECKING:
    from xarray import DataArray, Dataset

T = TypeVar("T")

# Types without names of axes: most values, which need no search for them.
_PLAIN = {float, int, str, list, tuple, np.ndarray, type(None)}


@dataclass(frozen=True, eq=False)
class Axes:
    """Dimensions of an array of numbers, by name and with their coordinates.

    Attributes
    ----------
    names : tuple of str
        Name of each axis of the array.
    places : DataArray
        Places of the elements in the raveled array, over the dimensions that vary. An array has the length 1 along a
        name that is none of them.
    """

    names: tuple[Any, ...]
    places: DataArray

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of elements along each name."""
        return tuple(self.places.sizes.get(name, 1) for name in self.names)

    def array(self, values: Any, name: str = "", attributes: Mapping[str, Any] | None = None) -> DataArray:
        """Return numbers in the shape of the array as a DataArray."""
        numbers = np.asarray(values).reshape(self.places.shape)
        return self.places.copy(data=numbers).rename(name or None).assign_attrs(attributes or {})

    def dataset(self, variables: Mapping[str, tuple[Any, Mapping[str, Any]]], attributes: dict[str, Any]) -> Dataset:
        """Return numbers with their attributes as a Dataset."""
        import xarray as xr

        columns = {name: self.array(values, name, attrs) for name, (values, attrs) in variables.items()}
        return xr.Dataset(columns, attrs=attributes)

    def sel(self, indexers: Mapping[Any, Any], method: str | None) -> DataArray:
        """Return the places of the elements at some coordinates; see `xarray.DataArray.sel`."""
        along = ", ".join(map(str, self.places.dims))
        for name in indexers:
            if name not in self.places.dims and name not in self.places.coords:
                raise InputError("indexers", str(name), f"must be among {along}")
        try:
            return self.places.sel(indexers, method=method)
        except (KeyError, ValueError, TypeError, IndexError) as error:
            what = str(error.args[0] if error.args else error)
            raise InputError("indexers", rule=f"must name coordinates along {along}: {what}") from None


def unnamed(shape: tuple[int, ...]) -> Axes:
    """Return the axes of an array whose dimensions have no names: dim_0 and so on."""
    import xarray as xr

    places = xr.DataArray(np.arange(int(np.prod(shape))).reshape(shape))
    return Axes(places.dims, places)


def is_named(value: Any) -> bool:
    """Return whether a value is a DataArray with dimensions."""
    dimensions = getattr(value, "dims", None) if hasattr(value, "coords") else None
    # Those of a Dataset are a mapping.
    return isinstance(dimensions, tuple) and bool(dimensions)


def axes_of(value: Any, *, is_list: bool = False) -> Axes | None:
    """Return the axes of a DataArray, or of an object of such numbers; None without names.

    The last dimension of a list, such as that of the branches, is no axis.
    """
    if not is_named(value):
        # Other arrays, such as those of pandas, have axes of another kind.
        axes = getattr(value, "axes", None)
        return axes if isinstance(axes, Axes) else None
    first = value.isel({value.dims[-1]: 0}, drop=True) if is_list else value
    if not first.dims:
        return None
    places = first.copy(data=np.arange(first.size).reshape(first.shape)).rename(None).drop_attrs()
    return Axes(places.dims, places)


def aligned(values: Mapping[str, Any], lists: Collection[str] = ()) -> tuple[dict[str, Any], Axes | None]:
    """Return values whose arrays have axes of the same names in the same order, and these axes.

    Parameters
    ----------
    values : dict of str to object
        Numbers, arrays, DataArrays, and objects with the attribute `axes` and the method `spread`.
    lists : collection of str
        Names of values whose last axis is that of a list.

    Returns
    -------
    dict, Axes
        The values themselves and None where no one has names.

    Raises
    ------
    InputError
        If dimensions of one name differ in length or coordinates, or an array without names stands beside others.
    """
    axes = {
        name: its_axes
        for name, value in values.items()
        if type(value) not in _PLAIN and (its_axes := axes_of(value, is_list=name in lists)) is not None
    }
    if not axes:
        return dict(values), None
    places = _common({name: each.places for name, each in axes.items()})
    common = Axes(places.dims, places)
    # An array beside objects has their axes, as in a copy of a material with another density.
    names = {each.names for each in axes.values()}
    of_arrays = None if any(map(is_named, values.values())) or len(names) > 1 else Axes(names.pop(), places)
    return {name: _spread(name, value, common, of_arrays, name in lists) for name, value in values.items()}, common


def align(thing: Any, names: Collection[str]) -> None:
    """Give those attributes of a frozen object that have axes the same ones, which become its `axes`."""
    with_parts = [name for name in names if type(getattr(thing, name)) not in _PLAIN]
    if all(axes_of(getattr(thing, name)) is None for name in with_parts):
        return
    values, axes = aligned({name: getattr(thing, name) for name in names})
    vars(thing).update(values, axes=axes)


def _common(places: Mapping[str, DataArray]) -> DataArray:
    """Return the places over the dimensions of all, in the order in which they appear."""
    import xarray as xr

    try:
        arrays = xr.align(*places.values(), join="exact", copy=False)
        merged = xr.merge([each.coords.to_dataset() for each in arrays], compat="override", join="exact")
    except ValueError as error:
        fields = ", ".join(places)
        rule = f"must have the same coordinates along dimensions of one name: {str(error).splitlines()[0]}"
        raise InputError(fields, rule=rule) from None
    sizes: dict[Any, int] = {}
    for name, each in places.items():
        for dimension, size in each.sizes.items():
            if sizes.setdefault(dimension, size) != size:
                rule = f"must have {sizes[dimension]} values along {dimension}, as others have, not {size}"
                raise InputError(name, rule=rule)
    shape = tuple(sizes.values())
    return xr.DataArray(np.arange(int(np.prod(shape))).reshape(shape), merged.coords, tuple(sizes))


def _spread(name: str, value: Any, axes: Axes, of_arrays: Axes | None, is_list: bool) -> Any:
    """Return a value over the axes; those of arrays without names are `of_arrays`."""
    if is_named(value):
        last = value.dims[-1:] if is_list else ()
        there = [each for each in axes.names if each in value.dims and each not in last]
        ordered = value.transpose(*there, *last)
        missing = {each: place for place, each in enumerate(axes.names) if each not in there}
        return ordered.drop_vars(ordered.coords).expand_dims(list(missing), list(missing.values()))
    if (its_axes := axes_of(value)) is not None:
        return named(value.spread(axes.names), Axes(axes.names, its_axes.places))
    shape = _shape(value)
    shape = shape[: len(shape) - is_list]
    if not shape:
        return value
    if of_arrays is None or not _fits(shape, of_arrays):
        rule = (
            f"must be a DataArray, as numbers beside it have dimensions with names: {', '.join(map(str, axes.names))}"
        )
        raise InputError(name, rule=rule)
    if of_arrays.names == axes.names:
        return value
    spread = getattr(value, "spread", None)
    return spread_array(value, of_arrays, axes.names, shape) if spread is None else spread(axes.names, of_arrays)


def _fits(shape: tuple[int, ...], axes: Axes) -> bool:
    """Return whether an array of a shape may be over axes."""
    return len(shape) == len(axes.shape) and all(n in (1, most) for n, most in zip(shape, axes.shape, strict=True))


def _shape(value: Any) -> tuple[int, ...]:
    """Return the shape of an array, or of an object of arrays."""
    for name in ("rows", "shape"):
        if isinstance(shape := getattr(value, name, None), tuple):
            return shape
    return () if value is None else np.shape(value)


def spread_array(values: Any, axes: Axes, names: tuple[Any, ...], shape: tuple[int, ...]) -> Any:
    """Return numbers over the axes, or an array of the shape that broadcasts to them, as an array over other names.

    The array may have a last axis more. A number stays one.
    """
    numbers = np.asarray(values)
    if not numbers.ndim:
        return values
    count = len(axes.names)
    rest = tuple(range(count, numbers.ndim))
    if numbers.ndim < count:
        numbers = np.broadcast_to(numbers, shape)
    dimensions = axes.places.dims
    order = [axes.names.index(name) for name in names if name in dimensions]
    absent = [place for place, name in enumerate(axes.names) if name not in dimensions]
    numbers = np.transpose(numbers, (*order, *absent, *rest))
    numbers = numbers.reshape(*numbers.shape[: len(order)], *numbers.shape[count:])
    return numbers[tuple(slice(None) if name in dimensions else None for name in names)]


def named(value: T, axes: Axes | None) -> T:
    """Give an object, and arrays of its shape within it, their axes; return it."""
    if axes is not None:
        vars(value)["axes"] = axes
        for part in vars(value).values():
            if hasattr(part, "spread") and _shape(part) == axes.shape:
                named(part, axes)
    return value
