#!/usr/bin/env python3
"""Prints the ten figures of a run that say most; all others are in its summary.json and evaluation.json.

scripts/run_figures.py RESULT

Figures that need ground truth are left out if `facet evaluate` has not been run.
"""

import argparse
import json
from pathlib import Path


def value_at(data, path):
    for name in path.split("/"):
        data = data.get(name) if isinstance(data, dict) else None
    return data


# What, where, unit, factor to it, digits.
FIGURES = [
    ("position error, root mean square", "evaluation/ate/rmse_m", "mm", 1e3, 1),
    ("position error at most", "evaluation/ate/max_m", "mm", 1e3, 1),
    ("drift, of the path", "evaluation/drift_percent", "%", 1, 2),
    ("mesh within 3 m: distance to the true surface, median", "evaluation/mesh/within_3m/accuracy_median_m", "mm", 1e3, 1),
    ("map: distance to the true surface, median", "evaluation/map/accuracy_median_m", "mm", 1e3, 1),
    ("true surface within 10 cm of the map", "evaluation/map/completeness_10cm", "%", 100, 0),
    ("plane area found, of what was seen", "evaluation/planes/recall", "%", 100, 0),
    ("planes found that are true", "evaluation/planes/precision", "%", 100, 0),
    ("one core's time for a stereo frame, mean", "summary/stages/total_without_decode/mean_ms", "ms", 1, 1),
    ("memory at most", "summary/peak_rss_mb", "MB", 1, 0),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", type=Path)
    result = parser.parse_args().result
    data = {}
    for name in ("summary", "evaluation"):
        file = result / f"{name}.json"
        data[name] = json.loads(file.read_text()) if file.exists() else {}
    if not data["summary"]:
        raise SystemExit(f"{result} holds no summary.json: is it the result of `facet run`?")
    for text, path, unit, factor, digits in FIGURES:
        value = value_at(data, path)
        if value is not None:
            print(f"  {text:54s} {value * factor:8.{digits}f} {unit}")


if __name__ == "__main__":
    main()
