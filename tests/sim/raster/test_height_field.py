"""Height fields as triangles."""

from collections import Counter

import mujoco
import numpy as np
import numpy.typing as npt

from sim.raster.height_field import height_field_triangles


def field(elevation: str) -> npt.NDArray[np.float64]:
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><asset>
      <hfield name="h" nrow="2" ncol="3" size="2 1 3 .5" elevation="{elevation}"/></asset>
      <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>""")
    return height_field_triangles(model, 0)


def test_it_is_closed_and_encloses_its_volume() -> None:
    triangles = field("0 .5 1  .5 1 0")
    ends = np.round(triangles, 9)[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 6) + 0.0
    walls_and_top = ends[:-6]  # the floor has longer edges than the walls
    there = Counter(tuple(edge) for edge in walls_and_top)
    open_edges = [edge for edge in there if (*edge[3:], *edge[:3]) not in there]
    assert all(edge[2] == edge[5] == -0.5 for edge in open_edges)
    volume = np.linalg.det(triangles).sum() / 6
    # Rows of 0, 1.5, 3 and 1.5, 3, 0 m. One diagonal of each cell is level, at 1.5 and at 3 m. The
    # mean height of four triangles is a sixth of the sum of the corners plus a third of the middle.
    cells = [(0 + 1.5 + 3 + 1.5) / 6 + 1.5 / 3, (1.5 + 3 + 0 + 3) / 6 + 3 / 3]
    np.testing.assert_allclose(volume, 2 * 2 * sum(cells) + 4 * 2 * 0.5, rtol=1e-6)


def test_a_cell_with_one_level_diagonal_consists_of_two_flat_halves() -> None:
    top = field("0 1 1  1 .5 1")[:8]
    middles = top[::2, 2]
    np.testing.assert_allclose(np.unique(middles[:, 2]), [3.0])


def test_the_middle_of_a_cell_is_the_higher_of_its_diagonals() -> None:
    middle = field("0 .6 1  .4 .2 1")[0, 2]  # diagonals with the means 0.1 and 0.5
    np.testing.assert_allclose(middle, [-1, 0, 1.5], rtol=1e-6)
