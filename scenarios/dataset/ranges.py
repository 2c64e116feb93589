"""What the sequences of each split are drawn from."""

from __future__ import annotations

from dataclasses import replace

from scenarios.dataset.draws import CROSSING, Draws
from scenarios.dataset.scenes.model_take import MODEL
from scenarios.dataset.spec_file import DatasetSpec
from scenarios.dataset.splits import SHORT_NAMES, VEHICLE, divide
from scenarios.errors import ScenarioError
from scenarios.sweep.parameters import check_name
from scenarios.sweep.random_sample import UNIFORM, Distribution

_FAR_KIND = "crossing.distractors.far_vehicle_kind"
_ALWAYS_DRAWN = {
    False: ("crossing.street_seed", "crossing.distractors.seed"),
    True: ("model.seed",),
}
"""Seeds of a street and of a model that differ from sequence to sequence, unless the file sets
them."""


def split_ranges(spec: DatasetSpec) -> dict[str, Draws]:
    """Return what each split draws from, with values of disjoint parameters divided.

    Raises:
        ScenarioError: a split cannot be disjoint.
    """
    base = spec.base
    set_in_variants = {name for draws in spec.variants.values() for name in draws.names}
    always = _ALWAYS_DRAWN[spec.is_model]
    missing = [n for n in always if n not in base.names | set_in_variants]
    seeds = tuple(Distribution(name, UNIFORM, (0, 2**32 - 1)) for name in missing)
    base = replace(base, drawn=base.drawn + seeds)
    ranges = dict.fromkeys(spec.counts, base)
    for given in spec.disjoint:
        name = SHORT_NAMES.get(given, given)
        _check_disjoint(given, name, spec)
        distribution = next((d for d in base.drawn if d.name == name), None)
        if distribution is None or name in set_in_variants:
            place = "in [[variants]]" if name in set_in_variants else "not drawn"
            raise ScenarioError(
                f"splits.disjoint holds {given!r}, and {name} is {place}. Allowed are parameters "
                f"that are drawn for all sequences. Write {name} = {{choice = [one, another]}} in "
                f"[{name.split('.')[0]}], or remove it from the list."
            )
        parts = divide(distribution, spec.counts)
        for split, part in parts.items():
            changes = (part, *_far_kinds(given, part, spec, set_in_variants))
            ranges[split] = ranges[split].with_changes(Draws({}, changes))
    return ranges


def _far_kinds(
    given: str, part: Distribution, spec: DatasetSpec, in_variants: set[str]
) -> list[Distribution]:
    """Return the kinds of the second vehicle, which must not be those of other splits either."""
    if given not in (VEHICLE, SHORT_NAMES[VEHICLE]):
        return []
    if _FAR_KIND in spec.base.names | in_variants:
        raise ScenarioError(
            f"splits.disjoint holds {given!r}, and {_FAR_KIND} is set. It is then drawn from the "
            f"vehicles of each split. Remove {_FAR_KIND}, or {given!r} from the list."
        )
    return [Distribution(_FAR_KIND, part.kind, part.values)]


def _check_disjoint(given: str, name: str, spec: DatasetSpec) -> None:
    if not name.startswith(f"{MODEL}."):
        check_name(name)
    if spec.is_model and name.startswith(f"{CROSSING}."):
        raise ScenarioError(
            f"splits.disjoint holds {given!r}, and the scene is a model, not a street. Allowed are "
            f"parameters of [{MODEL}] that are drawn. Remove it from the list."
        )
