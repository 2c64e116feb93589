"""Which elements of a model are rendered: by their group, and by the opacity of their colour."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

Bools = npt.NDArray[np.bool_]

KINDS = ("geom", "site", "flex", "skin", "tendon")
"""Kinds of elements with a colour and a group of their own, as named in MuJoCo's arrays."""
UNSET_RGBA = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour. An element that has it and a material takes the material's colour."""
HIDDEN_GROUP = 5
"""A group that is not rendered. MuJoCo's default options show the groups 0 to 2."""


def rendered(model: mujoco.MjModel, kind: str) -> Bools:
    """Return which elements of one kind are rendered.

    Args:
        model: the model.
        kind: one of `KINDS`.

    Returns:
        (n,) bool: True if the group is 0, 1 or 2, and the colour is not fully transparent.
    """
    groups = np.clip(_array(model, kind, "group"), 0, HIDDEN_GROUP)
    shown = np.asarray(mujoco.MjvOption().geomgroup, bool)
    return np.asarray(shown[groups] & (element_rgba(model, kind)[:, 3] > 0), bool)


def element_rgba(model: mujoco.MjModel, kind: str) -> npt.NDArray[np.float32]:
    """Return the (n, 4) colours of all elements of one kind: their own, or their material's."""
    rgba = _array(model, kind, "rgba").copy()
    material = _array(model, kind, "matid")[: len(rgba)]  # MuJoCo 4.0.0 gives flexes too many
    from_material = (material >= 0) & np.all(rgba == np.array(UNSET_RGBA, np.float32), axis=1)
    rgba[from_material] = model.mat_rgba[material[from_material]]
    return np.asarray(rgba, np.float32)


def hide(model: mujoco.MjModel) -> None:
    """Move everything that is not rendered to `HIDDEN_GROUP`, in place.

    The renderer itself leaves out groups only. A transparent element would cast a full shadow.
    """
    for kind in KINDS:
        _array(model, kind, "group")[~rendered(model, kind)] = HIDDEN_GROUP


def _array(model: mujoco.MjModel, kind: str, name: str) -> Any:
    return getattr(model, f"{kind}_{name}")
