"""A robot arm before an event camera: physics, events, APS frames, and what the fly says of it.

    python examples/robot_arm/arm.py --picture arm.png

The arm swings from left to right, driven by its motors; `EventCamera` is stepped beside the
physics, and decides by itself when to draw.
"""

import argparse
from pathlib import Path

import mujoco
import numpy as np
from matplotlib.figure import Figure

from detector.fly.detector import FlyDetector
from scenarios.pipeline.event_camera import EventCamera
from sim import open_model

MODEL = Path(__file__).with_name("arm.xml")
AIM = np.array([0.0, 0.75, 0.45, 0.3])
"""Where the motors are told to go: as far to the right as they stand to the left [rad]."""
SWING_S = 0.5
"""How long they are given for it [s]."""
PICTURE_US = 20_000
ON, OFF = (0.84, 0.19, 0.12), (0.1, 0.62, 0.47)


def run(seconds: float, step_px: float):
    """Swing the arm; returns events, the last APS frame, light in cd/m², and the estimates."""
    model = open_model(MODEL)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    fly, estimates, events, frame = FlyDetector(), [], [], None
    with EventCamera(model, "eye", seed=1, step_px=step_px) as camera:
        while data.time < seconds:
            data.ctrl[:] = -AIM * np.cos(np.pi * min(data.time / SWING_S, 1.0))
            mujoco.mj_step(model, data)
            output = camera.step(data)
            events.append(output.events)
            estimates += fly.push(output.events)
            frame = output.aps_frames[-1] if output.aps_frames else frame
        print(f"{seconds:g} s of physics, drawn {camera.samples} times")
        return np.concatenate(events), frame, camera.luminance, estimates


def draw(path: Path, events, frame, luminance, estimate) -> None:
    """The light, the events of 20 ms with the fly's region, and the APS frame, side by side."""
    figure = Figure(figsize=(12, 3.05), layout="constrained")
    light, middle, aps = figure.subplots(1, 3)
    shown = light.imshow(luminance, cmap="gray", norm="log", vmin=2)
    figure.colorbar(shown, ax=light, label="cd/m²", shrink=0.8)
    light.set_title("light")
    image = np.ones((*luminance.shape, 3))
    last = events[events["t"] > events["t"][-1] - PICTURE_US]
    image[last["y"], last["x"]] = np.where(
        last["p"][:, None], (0.84, 0.19, 0.12), (0.1, 0.62, 0.47)
    )
    middle.imshow(image, interpolation="nearest")
    middle.set_title("events of 20 ms: ON red, OFF green")
    if estimate is not None:
        middle.set_title(f"events of 20 ms: the fly says {estimate.direction}")
        if estimate.roi_px is not None:
            x0, y0, x1, y1 = estimate.roi_px
            middle.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="#1f6eb4")
    if frame is not None:
        aps.imshow(frame.image, cmap="gray", interpolation="nearest")
        aps.set_title(f"APS frame, exposed for {frame.exposure_us / 1000:.1f} ms")
    for axes in (light, middle, aps):
        axes.set_xticks([])
        axes.set_yticks([])
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=0.45, help="how long the physics runs")
    parser.add_argument("--step-px", type=float, default=1.0, help="farthest between two drawings")
    parser.add_argument("--picture", type=Path, help="PNG to write")
    arguments = parser.parse_args()
    events, frame, luminance, estimates = run(arguments.seconds, arguments.step_px)
    print(f"{events.size:,} events, {np.mean(events['p']):.0%} ON")
    for estimate in estimates[:: max(1, len(estimates) // 8)]:
        hs, vs = f"{estimate.hs:+.2f}", f"{estimate.vs:+.2f}"
        print(f"{estimate.t_us / 1000:5.0f} ms  HS {hs}  VS {vs}  {estimate.direction}")
    if arguments.picture:
        draw(arguments.picture, events, frame, luminance, estimates[-1] if estimates else None)


if __name__ == "__main__":
    main()
