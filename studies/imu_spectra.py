#!/usr/bin/python3
"""Question: how strong is what an IMU measured (1-sigma, rad/s and m/s^2), by axis and band of frequency? Below about 5 Hz
  it is the motion itself, above it vibration and noise.
Command: studies/imu_spectra.py IMU[:from:to]...
  Each argument is an imu0/data.csv, or a sequence; :from:to cuts out seconds after the first sample.
Answer: the sizes in src/facet/sim/vibration.cpp, within 0.9 to 2.0 times the recorded ones
  (docs/notebook/simulator_figures.md, "IMU").
Date: 2026-11-21.
"""

import sys
from pathlib import Path

import numpy as np

BANDS = [(0.2, 1), (1, 3), (3, 10), (10, 20), (20, 40), (40, 60), (60, 80), (80, 100)]
AXES = ["gyro x", "gyro y", "gyro z", "accel x", "accel y", "accel z"]


def load(text):
    name, *cut = text.split(":")
    path = Path(name)
    if path.is_dir():
        path = path / "mav0" / "imu0" / "data.csv"
    data = np.genfromtxt(path, delimiter=",", comments="#")
    seconds = (data[:, 0] - data[0, 0]) * 1e-9
    if cut:
        data = data[(seconds >= float(cut[0])) & (seconds < float(cut[1]))]
    return 1e9 / np.median(np.diff(data[:, 0])), data[:, 1:7]


def band_sigmas(rate, samples, length=512):
    """Welch's method with a Hann window and half overlap."""
    length = min(length, len(samples))
    window = np.hanning(length)[:, None]
    power, count = 0, 0
    for begin in range(0, len(samples) - length + 1, length // 2):
        part = samples[begin:begin + length]
        power = power + np.abs(np.fft.rfft((part - part.mean(0)) * window, axis=0)) ** 2
        count += 1
    power = power / count * 2 / (rate * (window**2).sum())
    frequency = np.fft.rfftfreq(length, 1 / rate)
    step = frequency[1]
    return np.array([np.sqrt(power[(frequency >= a) & (frequency < b)].sum(0) * step) for a, b in BANDS])


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    results = [(text, band_sigmas(*load(text))) for text in sys.argv[1:]]
    print(f"{'':9}{'':32}" + "".join(f"{f'{a:g}-{b:g} Hz':>11}" for a, b in BANDS))
    for axis, name in enumerate(AXES):
        for text, sigmas in results:
            print(f"{name:9}{text[-30:]:32}" + "".join(f"{s:11.4f}" for s in sigmas[:, axis]))


if __name__ == "__main__":
    main()
