"""Batches of samples for PyTorch's DataLoader."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

TENSOR_KINDS = "biuf"
"""Kinds of NumPy arrays that tensors can hold: bool, whole numbers and floats."""


def collate(samples: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Join samples to a batch; pass this as `collate_fn`.

    Args:
        samples: samples of an `EventDataset`, at least one.

    Returns:
        By name: a tensor with the samples along its first axis, if all have arrays or numbers of
        equal shape; else a list with one entry for each sample, such as for events and boxes.
    """
    import torch

    batch: dict[str, Any] = {}
    for name in samples[0]:
        values = [sample[name] for sample in samples]
        arrays = [np.asarray(value) for value in values]
        fits = arrays[0].dtype.kind in TENSOR_KINDS and len({a.shape for a in arrays}) == 1
        batch[name] = torch.from_numpy(np.stack(arrays)) if fits else values
    return batch
