import mujoco
import numpy as np
import pytest

from sim.scene.lamp_flicker import FlickeringLamps, changed_lights
from sim.scene.lighting import OFF_EMISSION


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string("""<mujoco>
      <asset>
        <material name="rectangle" emission=".5"/><material name="lens" emission=".25"/>
        <material name="wall" emission="0"/>
      </asset>
      <worldbody>
        <light type="spot" intensity="100"/><light type="spot" intensity="200"/>
        <light type="directional" intensity="300"/>
      </worldbody>
    </mujoco>""")


MAINS = FlickeringLamps(lights=np.array([0, 1]), materials=np.array([0, 1]))


@pytest.mark.parametrize("factor", [0.0, 0.5, 1.0, 1.5])
def test_only_lamps_on_the_mains_are_scaled(model: mujoco.MjModel, factor: float) -> None:
    with MAINS.scaled(model, factor):
        np.testing.assert_allclose(model.light_intensity, [100 * factor, 200 * factor, 300])
        np.testing.assert_allclose(model.mat_emission, [0.5 * factor, 0.25 * factor, 0], atol=1e-9)
        assert (model.mat_emission[:2] >= OFF_EMISSION).all()
    np.testing.assert_array_equal(model.light_intensity, [100, 200, 300])
    np.testing.assert_array_equal(model.mat_emission, [0.5, 0.25, 0])


def test_intensities_are_restored_after_an_error(model: mujoco.MjModel) -> None:
    with pytest.raises(ZeroDivisionError), MAINS.scaled(model, 0.0):
        _ = 1 / 0
    np.testing.assert_array_equal(model.light_intensity, [100, 200, 300])
    np.testing.assert_array_equal(model.mat_emission, [0.5, 0.25, 0])


def test_nested_changes_are_restored_in_order(model: mujoco.MjModel) -> None:
    with changed_lights(model, {0: 1.0, 2: 2.0}):
        with changed_lights(model, {0: 7.0}):
            np.testing.assert_array_equal(model.light_intensity, [7, 200, 2])
        np.testing.assert_array_equal(model.light_intensity, [1, 200, 2])
    np.testing.assert_array_equal(model.light_intensity, [100, 200, 300])
