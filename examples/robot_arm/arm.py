"""Simulate a robot arm in front of an event camera, and estimate its motion with the fly detector.

    python examples/robot_arm/arm.py --picture arm.png

Motors swing the arm from left to right. `EventCamera` is stepped after every step of the physics.
It renders only when something has moved far enough in the image.
"""

import argparse
from pathlib import Path

import mujoco
import numpy as np
from matplotlib.figure import Figure

from flybench import EventCamera, FlyDetector, open_model
from scenarios.output.colours import OFF, ON

MODEL = Path(__file__).with_name("arm.xml")
AIM = np.array([0.0, 0.75, 0.45, 0.3])
"""Target angles of the motors, the mirror image of the start [rad]."""
SWING_S = 0.5
"""Duration of the swing [s]."""
SHOWN_US = 20_000
"""Events of this last part of the run are plotted [µs]."""


def run(seconds: float, step_px: float):
    """Swing the arm.

    Args:
        seconds: simulated time [s].
        step_px: largest motion in the image between two rendered samples [px].

    Returns:
        Events, last APS frame or None, last luminance image [cd/m²], and all estimates.
    """
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
        print(f"{seconds:g} s of physics, rendered {camera.samples} times")
        return np.concatenate(events), frame, camera.luminance, estimates


def plot(path: Path, events, frame, luminance, estimate) -> None:
    """Plot the luminance, the events of 20 ms with the fly's region, and the APS frame."""
    figure = Figure(figsize=(12, 3.05), layout="constrained")
    scene, recent, aps = figure.subplots(1, 3)
    shown = scene.imshow(luminance, cmap="gray", norm="log", vmin=2)
    figure.colorbar(shown, ax=scene, label="cd/m²", shrink=0.8)
    scene.set_title("luminance")
    image = np.ones((*luminance.shape, 3))
    last = events[events["t"] > events["t"][-1] - SHOWN_US]
    image[last["y"], last["x"]] = np.where(last["p"][:, None], ON, OFF) / 255
    recent.imshow(image, interpolation="nearest")
    recent.set_title("events of 20 ms: ON blue, OFF orange")
    if estimate is not None:
        recent.set_title(f"events of 20 ms, fly's estimate: {estimate.direction}")
        if estimate.roi_px is not None:
            x0, y0, x1, y1 = estimate.roi_px
            recent.plot([x0, x1, x1, x0, x0], [y0, y0, y1, y1, y0], color="#00A884")
    if frame is not None:
        aps.imshow(frame.image, cmap="gray", interpolation="nearest")
        aps.set_title(f"APS frame, exposure {frame.exposure_us / 1000:.1f} ms")
    for axes in (scene, recent, aps):
        axes.set_xticks([])
        axes.set_yticks([])
    figure.savefig(path, dpi=110)


def main() -> None:
    """Run the simulation, print estimates, and plot the end of the run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--seconds", type=float, default=0.45, help="simulated time [s] (default: %(default)g)"
    )
    parser.add_argument(
        "--step-px",
        type=float,
        default=1.0,
        help="farthest motion between two samples [px] (default: %(default)g)",
    )
    parser.add_argument("--picture", type=Path, help="PNG file to write")
    arguments = parser.parse_args()
    events, frame, luminance, estimates = run(arguments.seconds, arguments.step_px)
    print(f"{events.size:,} events, {np.mean(events['p']):.0%} ON")
    for estimate in estimates[:: max(1, len(estimates) // 8)]:
        hs, vs = f"{estimate.hs:+.2f}", f"{estimate.vs:+.2f}"
        print(f"{estimate.t_us / 1000:5.0f} ms  HS {hs}  VS {vs}  {estimate.direction}")
    if arguments.picture:
        plot(arguments.picture, events, frame, luminance, estimates[-1] if estimates else None)


if __name__ == "__main__":
    main()
