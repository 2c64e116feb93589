"""Datasets that `flybench dataset` made, as samples for training: `EventDataset`."""

from scenarios.datasets.collate import collate
from scenarios.datasets.event_dataset import EventDataset, Representation
from scenarios.datasets.slicing import Slicing
from scenarios.datasets.voxel_grid import voxel_grid

__all__ = ["EventDataset", "Representation", "Slicing", "collate", "voxel_grid"]
