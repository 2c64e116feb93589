"""Write the APS frames of a recording as luminance, to emulate a sensor that sees the same scene.

    python examples/own_frames.py real.aedat4 frames        # writes frames.npy and frames.txt
    flybench emulate frames.npy --times frames.txt --time-unit us --interpolate --out made.aedat4
    flybench compare real.aedat4 made.aedat4 --plot compared.png

1. Levels become luminance with the parameters of flybench's DAVIS346: electrons per level,
   electrons per lux and second, the exposure of each frame, and the lens. A level of 10 bits is
   assumed to hold 1/680 of the full well, as in flybench.
2. The noise of the frames must not become events. A pixel that varies by no more than five standard
   deviations of this noise and one step of 8 bits gets the mean of all frames.
3. The time of a frame is the middle of its exposure.
"""

import argparse
from pathlib import Path

import numpy as np

from emulator.pixel.optics import lux_per_cd_m2
from flybench import ApsFrame, SensorConfig, open_events

DEVIATIONS = 5.0
"""Standard deviations of the noise within which a pixel is still (assumed)."""
STEP_DN = 4
"""Step of frames that were stored with 8 bits [DN of 10 bits]."""


def electrons_per_dn(config: SensorConfig) -> float:
    """Return the electrons of one level."""
    return config.aps.full_well_e / config.aps.saturation_dn


def without_noise(levels: np.ndarray, config: SensorConfig) -> np.ndarray:
    """Return (frames, height, width) levels in which pixels that vary like noise are constant."""
    mean = levels.mean(axis=0)
    per_dn = electrons_per_dn(config)
    noise_dn = np.sqrt(mean * per_dn + config.aps.read_noise_e**2) / per_dn
    still = np.ptp(levels, axis=0) <= DEVIATIONS * noise_dn + STEP_DN
    return np.where(still, mean, levels)


def luminance(levels: np.ndarray, exposures_us: np.ndarray, config: SensorConfig) -> np.ndarray:
    """Return the luminance of the scene for levels of these exposures [cd/m²]."""
    optics = lux_per_cd_m2(f_number=config.f_number, transmission=config.transmission)
    exposures_s = exposures_us[:, np.newaxis, np.newaxis] * 1e-6
    lux = levels * electrons_per_dn(config) / (config.aps.electrons_per_lux_s * exposures_s)
    return (lux / optics).astype(np.float32)


def read_frames(path: Path) -> list[ApsFrame]:
    """Return all frames of a recording."""
    with open_events(path) as file:
        return [frame for chunk in file for frame in chunk.frames]


def main() -> None:
    """Write the luminance and the times of the frames."""
    parser = argparse.ArgumentParser(description="Write the APS frames of a recording as luminance")
    parser.add_argument("recording", type=Path)
    parser.add_argument("name", help="name of the two files, without an ending")
    arguments = parser.parse_args()
    frames, config = read_frames(arguments.recording), SensorConfig()
    if len(frames) < 2:
        parser.error(f"{arguments.recording} contains {len(frames)} frames. Allowed are 2 or more.")
    levels = np.stack([frame.image for frame in frames]).astype(np.float64)
    exposures_us = np.array([frame.end_us - frame.start_us for frame in frames])
    times_us = [(frame.start_us + frame.end_us) // 2 for frame in frames]
    values = luminance(without_noise(levels, config), exposures_us, config)
    np.save(f"{arguments.name}.npy", values)
    Path(f"{arguments.name}.txt").write_text("".join(f"{t}\n" for t in times_us))
    print(f"{len(frames)} frames, {np.median(values):.3g} cd/m² (median), up to {values.max():.3g}")


if __name__ == "__main__":
    main()
