"""Materials of a case file that stand elsewhere: in the library, or in a file of data or of a solver."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import InstanceOf, ValidationInfo, field_validator, model_validator

from restitution.case.material_form import MaterialSection
from restitution.case.quantity import MODULUS, NUMBER, nonnegative, positive, refuse, within
from restitution.case.relaxation import Bulk, Modulus, PoissonRatio, read_file
from restitution.material import library
from restitution.material.conversion import shear_from_tension
from restitution.material.deck import ViscoelasticDeck
from restitution.material.fit import PronyFit, fit_prony
from restitution.material.fractional import Window
from restitution.material.measurement import DynamicTable, PronyTerms, RelaxationTable
from restitution.material.prony import PronySeries
from restitution.material.shift import ShiftTable
from restitution.material.viscoelastic import Material


class LibrarySection(MaterialSection):
    """A material of the library by its name."""

    library: str

    @field_validator("library")
    @classmethod
    def _known(cls, value: str) -> str:
        if value not in library.names():
            refuse(f"must be one of {', '.join(library.names())}")
        return value

    @model_validator(mode="after")
    def _check(self) -> LibrarySection:
        self.build()
        return self

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        return library.get(self.library)


class FileSection(MaterialSection):
    """A material in a file: measured data, which are fitted, Prony terms, or the deck of a solver."""

    # Before the file, whose reading needs it.
    material_name: str | None = None
    file: (
        InstanceOf[RelaxationTable]
        | InstanceOf[DynamicTable]
        | InstanceOf[PronyTerms]
        | InstanceOf[ViscoelasticDeck]
    )
    deformation: Literal["tension", "shear"] | None = None
    bulk_modulus: Bulk | None = None
    constant_poisson_ratio: Annotated[float, within(NUMBER, -1.0, 0.5)] | None = None
    youngs_modulus: Modulus | None = None
    poisson_ratio: PoissonRatio | None = None
    equilibrium_modulus: Annotated[float, nonnegative(MODULUS)] | None = None
    instantaneous_modulus: Modulus | None = None
    misfit: Annotated[float, positive(NUMBER)] | None = None
    liquid: bool | None = None

    @field_validator("file", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Any:
        content = read_file(value, info, "dma.csv", info.data.get("material_name"))
        if isinstance(content, ShiftTable):
            refuse("holds shift factors and no moduli; give it as shift")
        return content

    @model_validator(mode="after")
    def _check(self) -> FileSection:
        deck = isinstance(self.file, ViscoelasticDeck)
        fitted = isinstance(self.file, RelaxationTable | DynamicTable)
        if deck:
            self._only("the deck of a solver", "material_name", "youngs_modulus", "poisson_ratio")
        else:
            own = ("misfit", "liquid") if fitted else ("equilibrium_modulus", "instantaneous_modulus")
            shared = ("deformation", "bulk_modulus", "constant_poisson_ratio")
            self._only("measured data" if fitted else "Prony terms", *own, *shared)
            self.one_of("bulk_modulus", "constant_poisson_ratio")
            found = getattr(self.file, "deformation", None)
            if found is None and self.deformation is None:
                refuse('is missing: the file does not say whether it is "tension" or "shear"', "deformation")
            if found is not None and self.deformation not in (None, found):
                refuse(f'contradicts the file, which holds moduli in "{found}"', "deformation")
        try:
            _ = self.fit
        except ValueError as error:
            refuse(str(error).removeprefix(f"{self.file.source}: "), "file")
        self.build()
        return self

    def _only(self, what: str, *keys: str) -> None:
        others = [
            key for key in type(self).model_fields if key not in ("file", *MaterialSection.model_fields)
        ]
        for key in self.given(*others):
            if key not in keys:
                refuse(f"has no meaning for {what}; known are {', '.join(keys)}", key)

    @cached_property
    def fit(self) -> PronyFit | None:
        """Fit to measured data."""
        if not isinstance(self.file, RelaxationTable | DynamicTable):
            return None
        options = {key: getattr(self, key) for key in self.given("misfit", "liquid")}
        return fit_prony(self.file, **options)

    def isothermal(self, window: Window | None) -> Material:
        """Material in SI."""
        if isinstance(self.file, ViscoelasticDeck):
            return self.file.material(youngs_modulus=self.youngs_modulus, poisson_ratio=self.poisson_ratio)
        fit = self.fit
        if fit is not None:
            series, covered = fit.series, fit.window
            assumptions = f"{fit.n_terms} Prony terms fitted to the data, relative misfit {fit.misfit:.2g}"
        else:
            assert isinstance(self.file, PronyTerms)
            series, assumptions = self._series(self.file), None
            times = series.relaxation_times
            covered = (float(times.min()), float(times.max())) if times.size > 1 else None
        tension = (self.deformation or self.file.deformation) == "tension"
        shear, bulk = self._shear_and_bulk(series, tension)
        return Material(shear, bulk, source=self.file.source, window=covered, assumptions=assumptions)

    def _series(self, terms: PronyTerms) -> PronySeries:
        return terms.series(
            instantaneous_modulus=self.instantaneous_modulus, equilibrium_modulus=self.equilibrium_modulus
        )

    def _shear_and_bulk(self, series: PronySeries, tension: bool) -> tuple[PronySeries, PronySeries | float]:
        ratio = self.constant_poisson_ratio
        if ratio is None:
            assert self.bulk_modulus is not None
            shear = shear_from_tension(series, bulk_modulus=self.bulk_modulus) if tension else series
            return shear, self.bulk_modulus
        shear = shear_from_tension(series, poisson_ratio=ratio) if tension else series
        factor = math.inf if ratio == 0.5 else 2.0 * (1.0 + ratio) / (3.0 * (1.0 - 2.0 * ratio))
        return shear, math.inf if ratio == 0.5 else shear.scaled(factor)
