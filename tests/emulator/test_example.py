"""The example of the README, run as a user would run it, in a process of its own."""

import subprocess
import sys

EXAMPLE = '''\
import numpy as np
from emulator import Davis346, SensorConfig, luminance_of

config = SensorConfig(width=128, height=96)

def video():
    """A bright bar that crosses a dark street at 200 px/s: 8-bit frames at 1 kHz."""
    for k in range(500):
        image = np.full((96, 128), 60, np.uint8)
        image[:, int(0.2 * k) : int(0.2 * k) + 10] = 200
        yield k * 1000, luminance_of(image, white_cd_m2=200.0, transfer="srgb")

sensor = Davis346(config, seed=1)
for output in sensor.stream(video()):
    events, causes = output.events, output.causes       # t [µs], x, y, p; signal, leak, shot, hot
    for frame in output.aps_frames:
        print(f"{frame.end_us} µs: frame of {frame.exposure_us} µs, {frame.image.mean():.0f} DN")
print(f"{events.size} events in the last step, {output.readout.dropped} lost at the arbiter")
'''


def test_the_example_runs_without_the_renderer() -> None:
    code = f"import sys\nsys.modules['mujoco'] = None\n{EXAMPLE}"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) >= 10
    assert "frame of" in lines[0]
    assert "events in the last step, 0 lost at the arbiter" in lines[-1]
    assert int(lines[-1].split()[0]) > 0


def test_the_example_is_short() -> None:
    assert len(EXAMPLE.splitlines()) <= 20
