"""Trajectory files and errors for the scripts, on top of scripts/naive_ate.py."""

import csv
from pathlib import Path

import numpy as np

import naive_ate


def truth_file(sequence):
    """Ground truth of a sequence folder (or the file itself), or None."""
    path = Path(sequence)
    if path.is_file():
        return path
    for mav0 in (path / "mav0", path):
        file = mav0 / "state_groundtruth_estimate0" / "data.csv"
        if file.is_file():
            return file
    return None


def find_sequences(folders):
    """Every folder among and directly below `folders` that holds mav0/."""
    found = []
    for folder in map(Path, folders):
        inside = folder.iterdir() if folder.is_dir() else []
        candidates = [folder] + sorted(p for p in inside if p.is_dir() and not p.name.startswith("."))
        found += [p for p in candidates if (p / "mav0" / "cam0").is_dir()]
    return list(dict.fromkeys(found))


class Truth:
    """Ground truth that is read once and asked often."""

    def __init__(self, sequence):
        self._data = naive_ate.read_trajectory(truth_file(sequence))

    def pairs(self, trajectory):
        """Association of a trajectory file, as {stamp: (p, q, p_true, q_true)}."""
        rows = naive_ate.associate(naive_ate.read_trajectory(trajectory), self._data)
        return {row[0]: row[1:] for row in rows}


def aligned_positions(pairs):
    """Stamps, aligned estimate (n,3) and truth (n,3) of an association."""
    stamps = sorted(pairs)
    p = np.array([pairs[t][0] for t in stamps])
    g = np.array([pairs[t][2] for t in stamps])
    R, scale, t = naive_ate.align(p, g)
    return stamps, (scale * (R @ p.T)).T + t, g


def ate_rmse_on(pairs, stamps):
    """ATE rmse over those frames alone, aligned on them alone."""
    _, p, g = aligned_positions({t: pairs[t] for t in stamps})
    return float(np.sqrt(np.mean(np.sum((p - g) ** 2, axis=1))))


def read_columns(file):
    """A csv file with a header as {column: [text]}."""
    with open(file, encoding="utf-8", newline="") as stream:
        rows = list(csv.reader(stream))
    header = [name.strip().lstrip("#").strip() for name in rows[0]]
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(header)}
