"""A small network that names the direction of motion, as a detector for flybench.

    flybench validate --method fly --method examples.learned_direction.network:LearnedDirection

Run this in the folder of the repository, after `train.py` has written the weights.
"""

import os
from pathlib import Path

import numpy as np
import torch
from torch import nn

from detector.windowed import WindowedDetector
from flybench import Direction, MotionEstimate
from flybench.events import concatenate_events, empty_events
from scenarios.datasets import voxel_grid

WEIGHTS = "LEARNED_DIRECTION"
"""Environment variable with the path of the weights."""
DEFAULT_WEIGHTS = Path("logs/learned_direction.pt")
WINDOW_US, HOP_US, BINS = 50_000, 10_000, 5
"""Window, step between estimates [µs] and bins of the voxel grid: those of the fly, and 10 ms."""
CLASSES = (Direction.RIGHT, Direction.LEFT, Direction.UP, Direction.DOWN, Direction.NONE)
"""Classes; the first four have the numbers of the label "direction" of `EventDataset`."""


def network_input(grids: np.ndarray) -> torch.Tensor:
    """Return voxel grids, (n, bins, height, width), as sums of 2×2 pixels: half the size."""
    n, bins, height, width = grids.shape
    even = grids[:, :, : height // 2 * 2, : width // 2 * 2]
    sums = even.reshape(n, bins, height // 2, 2, width // 2, 2).sum(axis=(3, 5))
    return torch.from_numpy(sums.astype(np.float32))


class DirectionNetwork(nn.Module):
    """Three convolutions, and the mean of their result over all places that have events.

    The mean is weighted by the number of events, so that any size of image can be given.
    """

    def __init__(self) -> None:
        super().__init__()
        self.features = nn.Sequential(
            nn.Conv2d(BINS, 16, 5, stride=2, padding=2),
            nn.ReLU(),
            nn.Conv2d(16, 32, 3, stride=2, padding=1),
            nn.ReLU(),
            nn.Conv2d(32, 32, 3, padding=1),
            nn.ReLU(),
        )
        self.classify = nn.Linear(33, len(CLASSES))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Return (n, classes) logits for (n, bins, height, width) sums of 2×2 pixels."""
        features = self.features(x)
        weight = nn.functional.interpolate(
            x.abs().sum(dim=1, keepdim=True), size=features.shape[-2:], mode="area"
        )
        mean = (features * weight).sum(dim=(2, 3)) / (weight.sum(dim=(2, 3)) + 1e-6)
        rate = torch.log10(weight.mean(dim=(2, 3)) + 1e-3)
        return self.classify(torch.cat([mean, rate], dim=1))


class LearnedDirection(WindowedDetector):
    """The trained network as a detector; see `detector.Detector`."""

    def __init__(self, *, width: int, height: int) -> None:
        """Load the weights from the file that the environment variable `WEIGHTS` names."""
        super().__init__(HOP_US, WINDOW_US, width=width, height=height)
        path = Path(os.environ.get(WEIGHTS, DEFAULT_WEIGHTS))
        if not path.is_file():
            raise FileNotFoundError(f"{path} does not exist. Run train.py first.")
        self._network = DirectionNetwork()
        self._network.load_state_dict(torch.load(path, weights_only=True))
        self._hops_kept = [empty_events()] * (WINDOW_US // HOP_US)

    def _estimate(self, end_us: int, events: np.ndarray) -> MotionEstimate:
        self._hops_kept = [*self._hops_kept[1:], events]
        window = concatenate_events(self._hops_kept)
        window = window[window["t"] >= end_us - WINDOW_US]
        grid = voxel_grid(
            window,
            start_us=end_us - WINDOW_US,
            end_us=end_us,
            bins=BINS,
            width=self._width,
            height=self._height,
        )
        with torch.inference_mode():
            logits = self._network(network_input(grid[None]))
        right, left, up, down, none = torch.softmax(logits[0], dim=0).tolist()
        best = int(np.argmax([right, left, up, down]))
        is_moving = none < 0.5 and window.size > 0
        hs, vs = right - left, down - up
        return MotionEstimate(
            t_us=end_us,
            hs=hs,
            vs=vs,
            direction=CLASSES[best] if is_moving else Direction.NONE,
            strength=max(abs(hs), abs(vs)),
            response=(hs, vs),
            view_centre_px=(self._width / 2, self._height / 2),
            roi_px=None,
        )
