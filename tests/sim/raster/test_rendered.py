"""Which elements are rendered, and in which colour."""

import mujoco
import numpy as np
import pytest

from sim.raster.rendered import HIDDEN_GROUP, element_rgba, hide, rendered

MODEL = """<mujoco>
  <asset><material name="red" rgba="1 0 0 1"/><material name="clear" rgba="1 1 1 0"/></asset>
  <worldbody>{}</worldbody>
</mujoco>"""


def model_of(kind: str, *attributes: str) -> mujoco.MjModel:
    elements = "".join(f'<{kind} size="1" {more}/>' for more in attributes)
    return mujoco.MjModel.from_xml_string(MODEL.format(elements))


@pytest.mark.parametrize("kind", ["geom", "site"])
def test_groups_0_to_2_are_rendered(kind: str) -> None:
    model = model_of(kind, *(f'group="{k}"' for k in range(6)))
    np.testing.assert_array_equal(rendered(model, kind), [True] * 3 + [False] * 3)


@pytest.mark.parametrize("kind", ["geom", "site"])
def test_what_is_fully_transparent_is_not_rendered(kind: str) -> None:
    cases = {
        'rgba="1 1 1 0"': False,
        'rgba="1 1 1 .01"': True,
        'material="clear"': False,
        'material="clear" rgba="1 1 1 1"': True,  # its own colour has precedence
        'material="red" rgba="0 0 1 0"': False,
    }
    model = model_of(kind, *cases)
    np.testing.assert_array_equal(rendered(model, kind), list(cases.values()))
    hide(model)
    groups = getattr(model, f"{kind}_group")
    np.testing.assert_array_equal(groups == HIDDEN_GROUP, ~np.array(list(cases.values())))


def test_an_element_has_its_own_colour_or_its_materials() -> None:
    model = model_of("geom", "", 'material="red"', 'material="red" rgba="0 1 0 1"')
    expected = [[0.5, 0.5, 0.5, 1], [1, 0, 0, 1], [0, 1, 0, 1]]
    np.testing.assert_array_equal(element_rgba(model, "geom"), np.array(expected, np.float32))


def test_the_material_of_a_flex_is_found() -> None:
    model = mujoco.MjModel.from_xml_string(
        MODEL.format(
            '<flexcomp name="cloth" type="grid" count="3 3 1" spacing=".1 .1 .1" dim="2" mass="1" '
            'material="clear"><edge equality="true"/></flexcomp>'
        )
    )
    np.testing.assert_array_equal(rendered(model, "flex"), [False])
