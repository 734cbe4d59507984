"""Read and render the recipe of the conda package, as a feedstock does; an unknown or missing key is an error."""

from pathlib import Path

from rattler_build import Stage0Recipe, VariantConfig

RECIPE = Path(__file__).resolve().parents[1] / "recipe" / "recipe.yaml"

for variant in Stage0Recipe.from_file(RECIPE).render(VariantConfig()):
    recipe = variant.recipe
    print(recipe.package.name, recipe.package.version, "depends on", *recipe.requirements.run)
