"""`flybench doctor`: check the renderer of this machine."""

from __future__ import annotations

import os
import platform
import statistics
import sys
import time
from dataclasses import dataclass
from importlib.metadata import version

from rich.table import Table

from scenarios.output.streams import SafeConsole, say
from scenarios.output.terminal import run_cli
from sim import Crossing, CrossingConfig
from sim.render.vulkan import INSTALL_COMMAND, VECTOR_WIDTH, vector_width_problem, vulkan_devices

FRAMES = 20
_LIBRARIES = ("mujoco", "numba", "rerun-sdk", "h5py", "tyro")


@dataclass(frozen=True)
class Doctor:
    """Show the renderer of this machine, or what is missing."""

    def execute(self) -> int:
        """Print the table; the exit status is 1 if this machine cannot render."""
        table = Table(show_header=False)
        table.add_row("python", f"{platform.python_version()} on {platform.platform()}")
        table.add_row("CPU cores", str(os.cpu_count()))
        for name in _LIBRARIES:
            table.add_row(name, version(name))
        devices = vulkan_devices()
        for device in devices:
            kind = "software" if device.is_software else "hardware"
            table.add_row("Vulkan device", f"{device.name} ({kind})")
            table.add_row("driver", device.driver)
        no_driver = sys.platform.startswith("linux") and not devices
        problem = vector_width_problem()
        if problem:
            table.add_row(VECTOR_WIDTH, os.environ[VECTOR_WIDTH])
        if not (no_driver or problem):
            fps = luminance_frames_per_second(FRAMES)
            table.add_row("luminance frames", f"{fps:.1f} per second (346×260, 2×2 supersampled)")
        SafeConsole().print(table)
        if no_driver:
            say(f"No Vulkan driver was found. Install one with: sudo {INSTALL_COMMAND}")
            return 1
        if problem:
            say(f"This machine cannot render: {problem}")
            return 1
        say("This machine can render. Nothing is missing.")
        return 0


def luminance_frames_per_second(frames: int) -> float:
    """Return how many full 346×260 frames of the street by day are rendered per second.

    Args:
        frames: number of frames to take the median time of; one more is rendered first, untimed.
    """
    crossing = Crossing(CrossingConfig())
    times_s = []
    with crossing.full_frame_renderer() as render:
        for k in range(frames + 1):
            start = time.perf_counter()
            render(k * 1000)
            times_s.append(time.perf_counter() - start)
    return 1 / statistics.median(times_s[1:])


if __name__ == "__main__":
    run_cli(Doctor)
