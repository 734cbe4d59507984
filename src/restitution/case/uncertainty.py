"""Standard deviations in a case file: which keys have them, and the impacts as a function of these keys."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from restitution.case.axes import place_of, quantity_name, quantity_of, value_in_si
from restitution.case.impact import UNCERTAIN, Case, UncertaintySection
from restitution.case.section import in_file, refuse, split_list, without_deviations
from restitution.case.sweep import ENTRY, CaseTemplate, plan_case
from restitution.checks import Array
from restitution.errors import InputError
from restitution.impact.problem import Impact
from restitution.propagation.inputs import Input, Model, input_of
from restitution.propagation.result import UncertaintyResult
from restitution.propagation.uncertainty import Block, propagate
from restitution.units import deviation_in_si


def propagate_case(case: Case) -> UncertaintyResult:
    """Return the outputs of a case with standard deviations.

    Raises
    ------
    CaseError
        If the file states no standard deviation, or one belongs to no number of the impact or has another unit.
    SolverError
        If the impact is not solved.
    """
    section = case.sections.uncertainty
    with in_file(case.path):
        texts: dict[str, tuple[str, Any]] = {_name(place): (place, text) for place, text in case.deviations.items()}
        for keys, text in _leaves({} if section is None else section.deviations):
            field = f"uncertainty.deviations.{'.'.join(keys)}"
            name = quantity_name(field, keys)
            if name in texts:
                refuse(f"stands behind the value of {place_of(name)} too; leave one of the two out", field)
            texts[name] = field, text
        if not texts:
            refuse('has no standard deviation to take to the outputs; write e.g. "10 +- 0.5 MPa"', "uncertainty")
        if case.sections.solver.method != "exact":
            refuse('must be "exact" for standard deviations', "solver.method", case.sections.solver.method)
        if case.sections.needs_window:
            refuse("must not be a fractional model, whose Prony series changes with each impact", "material.model")
        options = section or UncertaintySection()
        model, blocks = _model(case, texts)
        draws = options.draws
        return propagate(model, blocks, options.outputs, draws=draws, rng=None if draws is None else options.seed)


def _name(place: str) -> str:
    return quantity_name(place, tuple(place.split(".")))


def _leaves(content: Mapping[str, Any], *above: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the keys and values of nested tables."""
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _leaves(value, *above, key)
        else:
            yield (*above, key), value


def _model(case: Case, texts: Mapping[str, tuple[str, Any]]) -> tuple[Model, list[Block]]:
    """Return the impacts of a case file as a function of its keys, and how these scatter."""
    content = copy.deepcopy(case.content)
    without_deviations(content, UNCERTAIN)
    for name in ("uncertainty", "bounces"):
        content.pop(name, None)
    inputs: list[Input] = []
    blocks: list[Block] = []
    for name, (field, text) in texts.items():
        quantity = quantity_of(name)
        if quantity is None:
            refuse("is no number that may have a standard deviation", field)
        value = _value(content, name, field)
        try:
            size = _deviation(text, value, quantity.dimension)
        except InputError as error:
            raise InputError(field, text, error.rule) from None
        inputs.append(input_of(name, quantity, value, 0.25 * size if value == 0.0 else None))
        blocks.append(Block((name,), np.array([[size**2]])))
    plan = plan_case(case.path, content, {each.name: float(each.value) for each in inputs})
    template = plan.template
    assert isinstance(template, CaseTemplate)
    vary = template.prepare({})

    def build(values: Mapping[str, Array]) -> Impact | list[Impact]:
        if not template.builds_with(tuple(values)):
            return vary(dict(values))
        rows = np.stack(list(values.values()), axis=1)
        return [vary(dict(zip(values, row, strict=True))) for row in rows.tolist()]

    return Model(tuple(inputs), build), blocks


def _value(content: Mapping[str, Any], name: str, field: str) -> float:
    """Return the number in SI that the file has for a key."""
    part: Any = content
    for key in place_of(name).split("."):
        match = ENTRY.fullmatch(key)
        plain, entry = (key, None) if match is None else (match[1], int(match[2]))
        part = part.get(plain) if isinstance(part, dict) else None
        items = split_list(part) if entry is not None and isinstance(part, str) else part
        part = items if entry is None else items[entry] if isinstance(items, list) and entry < len(items) else None
    value = value_in_si(field, name, copy.copy(part))
    if not isinstance(value, float):
        refuse(f"must belong to a number that the file has, and {place_of(name)} is none", field)
    return value


def _deviation(text: Any, value: float, dimension: Any) -> float:
    """Return a standard deviation in SI: a text with a unit or per cent, or a number in SI."""
    if isinstance(text, str):
        return deviation_in_si(text, value, dimension)
    if isinstance(text, bool) or not isinstance(text, int | float) or not 0.0 < text < np.inf:
        raise InputError("", rule="must be a standard deviation > 0, a number in SI or a text with a unit")
    return float(text)
