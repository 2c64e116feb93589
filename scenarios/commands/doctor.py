"""`flybench doctor`: what renders here, how fast, and what is missing."""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version

from rich.console import Console
from rich.table import Table

from scenarios.output.terminal import script
from sim import Crossing, CrossingConfig
from sim.render.vulkan import INSTALL_COMMAND, vulkan_devices

FRAMES = 20
_LIBRARIES = ("mujoco", "numba", "rerun-sdk", "h5py", "tyro")


@dataclass(frozen=True)
class Doctor:
    """Say what renders on this machine, how fast, and what to install if nothing does."""

    def execute(self) -> int:
        """Print the findings; the status is 1 where nothing renders."""
        table = Table(show_header=False)
        table.add_row("python", f"{platform.python_version()} on {platform.platform()}")
        table.add_row("processors", str(os.cpu_count()))
        for name in _LIBRARIES:
            table.add_row(name, version(name))
        devices = vulkan_devices()
        for device in devices:
            kind = "software" if device.is_software else "hardware"
            table.add_row("Vulkan device", f"{device.name} ({kind})")
            table.add_row("its driver", device.driver)
        missing = sys.platform.startswith("linux") and not devices
        if not missing:
            fps = luminance_frames_per_second(FRAMES)
            table.add_row("luminance frames", f"{fps:.1f} per second (346×260, 2×2 supersampled)")
        Console().print(table)
        if missing:
            print(f"No Vulkan driver was found. Install one with: sudo {INSTALL_COMMAND}")
            return 1
        print("Nothing is missing.")
        return 0


def luminance_frames_per_second(frames: int) -> float:
    """Rate at which whole 346×260 frames of the street by day are drawn, from the median time."""
    crossing = Crossing(CrossingConfig())
    times_s = []
    with crossing.full_frame_renderer() as draw:
        for k in range(frames + 1):
            start = time.perf_counter()
            draw(k * 1000)
            times_s.append(time.perf_counter() - start)
    return 1 / statistics.median(times_s[1:])


if __name__ == "__main__":
    script(Doctor)
