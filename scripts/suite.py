#!/usr/bin/python3
"""How accurate is Facet under the calibrations that one has? The scenes of config/suite.yaml, with the exact calibration
and with drawn ones (docs/simulator.md, "What is simulated").

  suite.py make                             renders every scene once (variant a) and once through lenses that their model
                                            describes to 0.13 px only (variant b); skips what is there
  suite.py run                              pipelines S and SPR, exact and drawn calibrations, variant a
  suite.py run --variant b --draws 10 --starts 3 --scene office --set estimator.window.max_pose_keyframes=5
  suite.py run --against other/facet        another program on the same sequences, and the ratio to it
  suite.py second                           besides, a second flight of each rig: with the calibration.yaml that its flight
                                            through the scene before wrote
  suite.py run --duration 20                what is known of the calibration after 20 s
  suite.py attribution                      which part of the drawn calibration costs what: lens, imu, time, scale, all
  suite.py run --suite config/planes_suite.yaml --out runs/planes_suite         where planes could harm

A figure of a scene is the median over its starts (0, 0.1, 0.2 ... s) and draws; NEES and what is left of the errors of
the calibration at the ends of the runs are means, or the worst run where that is said. The exact calibration has as
many starts as there are draws, so that one lucky start is not what the draws are divided by. The last columns have the
median over the scenes, the worst one and the mean, which for NEES is that of all draws. Sequences and results go to
--out.
"""

import argparse
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import debian_python  # noqa: F401 (first: it may start another Python)

import yaml

import run_all

ROOT = Path(__file__).resolve().parent.parent
PARTS = ["lens", "imu", "time", "scale"]


@dataclass
class Scene:
    """A line of the suite's file."""

    name: str
    scene: str
    flight: str
    seed: int
    duration: float
    start: float = 0
    max_rays: int = 16
    set: tuple = ()  # more options of `facet simulate --set`

    @property
    def source(self):
        """What `facet simulate --scene` is told: a name, or a file relative to the repository."""
        return ROOT / self.scene if self.scene.endswith(".yaml") else self.scene

    def draw_seed(self, draw):
        return 100 * self.seed + draw


@dataclass
class Case:
    """A sequence and the kind of calibration that it has: exact, drawn, or some parts drawn."""

    scene: Scene
    kind: str
    sequence: Path
    name: str = ""  # of the folder of results; empty: that of the sequence
    words: tuple = ()  # more arguments of `facet run`, by pipeline
    seed: int = 0  # of the draw


def read_suite(file):
    with open(file, encoding="utf-8") as stream:
        suite = yaml.safe_load(stream)
    scenes = [Scene(name, **values) for name, values in suite["scenes"].items()]
    return suite, scenes


def flight_arguments(scene):
    """Of `facet simulate`; None where the recorded flight is missing."""
    data = Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data") / "euroc_flights"
    if not scene.flight[0].isupper():
        return ["--trajectory", scene.flight]
    folder = data / scene.flight
    if not (folder / "groundtruth.csv").is_file():
        print(f"suite: {scene.name} is skipped: no {folder}", file=sys.stderr)
        return None
    return ["--trajectory", folder / "groundtruth.csv", "--imu", folder / "imu.csv", "--start", str(scene.start)]


def rendered(arguments, scene, variant):
    return arguments.out / "sequences" / (scene.name + ("-misfit" if variant == "b" else ""))


def simulate(program, out, options):
    out.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run([program, "simulate", "--quiet", "--out", out, *map(str, options)], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"suite: {out.name}: {done.stderr.strip()}")


def render(arguments, suite, scene, variant):
    out, flight = rendered(arguments, scene, variant), flight_arguments(scene)
    if flight is None or (out / "simulation.txt").exists():
        return
    options = ["--scene", scene.source, *flight, "--seed", scene.seed, "--duration", scene.duration, "--threads", 1,
               "--set", f"image.rays_per_pixel={suite['rays_per_pixel']}",
               "--set", f"image.max_rays_per_pixel={scene.max_rays}", "--set", "truth.points_per_m2=500"]
    for setting in scene.set:
        options += ["--set", setting]
    if variant == "b":
        options += ["--lens-misfit", scene.seed, "--set", f"image.lens_misfit_px={suite['lens_misfit']}"]
    sys.stderr.write(f"suite: rendering {out.name}\n")
    simulate(arguments.maker, out, options)


def make(arguments, suite, scenes):
    todo = [(scene, variant) for variant in arguments.variant for scene in scenes]
    with ThreadPoolExecutor(min(2, arguments.jobs)) as pool:
        list(pool.map(lambda item: render(arguments, suite, *item), todo))


def copy_drawn(arguments, source, name, seed, parts):
    """A copy with a drawn calibration, whose images are links; made if it is not there."""
    out = arguments.out / "drawn" / name
    what = f"--draw-calibration {seed} --draw-parts {','.join(parts)}"
    made = out / "simulation.txt"
    if not made.exists() or what not in made.read_text(encoding="utf-8"):  # or by a version with other parts
        shutil.rmtree(out, ignore_errors=True)
        simulate(arguments.maker, out, ["--of", source, *what.split()])
    return out


def drawn(arguments, scene, variant, draw, parts):
    source = rendered(arguments, scene, variant)
    name = f"{source.name}-draw{draw}" + ("" if parts == PARTS else "-" + "-".join(parts))
    return copy_drawn(arguments, source, name, scene.draw_seed(draw), parts)


def list_cases(arguments, scenes, variant, kinds):
    """`kinds`: {name: parts that are drawn}. Second flights are no sequences of their own (second_flights)."""
    for scene in scenes:
        source = rendered(arguments, scene, variant)
        if not (source / "simulation.txt").exists():
            print(f"suite: {source.name} is skipped: make renders it", file=sys.stderr)
            continue
        yield Case(scene, "exact", source)
        for kind, parts in kinds.items():
            for draw in [] if kind == "second" else range(1, arguments.draws + 1):
                yield Case(scene, kind, drawn(arguments, scene, variant, draw, parts), seed=scene.draw_seed(draw))


def fingerprint(run):
    """Equal where a run would do the same again."""
    program = os.stat(shutil.which(run.config.program) or run.config.program)
    made = os.stat(run.sequence / "simulation.txt")
    return json.dumps([run.config.program, program.st_mtime_ns, program.st_size, str(run.sequence), made.st_mtime_ns,
                       run.start, run.config.arguments])


def execute(run):
    """Runs and evaluates against poses, velocities and biases; surfaces would take longer than the run. What is there
    already, from the same program with the same arguments, is read."""
    mark = run.folder / "suite_run.json"
    run.evaluation = run_all.read_json(run.folder / "evaluation.json")
    if run.ate() is not None and mark.exists() and mark.read_text(encoding="utf-8") == fingerprint(run):
        return
    run.evaluation = {}
    shutil.rmtree(run.folder, ignore_errors=True)
    run.folder.parent.mkdir(parents=True, exist_ok=True)
    done = subprocess.run([run.config.program, "run", run.sequence, "--out", run.folder, "--start", f"{run.start:g}",
                           "--quiet", *run.config.arguments], capture_output=True, text=True, check=False)
    if (run.folder / "trajectory.tum").exists():
        subprocess.run([run.config.program, "evaluate", run.folder, "--truth", run.sequence, "--parts", "consistency"],
                       capture_output=True, check=False)
        run.evaluation = run_all.read_json(run.folder / "evaluation.json")
    if run.ate() is None:
        print(f"suite: {run.folder.name}: {done.stderr.strip() or done.returncode}", file=sys.stderr, flush=True)
    else:
        mark.write_text(fingerprint(run), encoding="utf-8")
    for file in ("map.ply", "mesh.ply", "timing.csv", "landmarks.ply", "keyframes.tum"):
        (run.folder / file).unlink(missing_ok=True)


def folder_of(arguments, label, name, pipeline, start):
    return arguments.out / "runs" / label / f"{name}-{pipeline}-{start}"


def second_flights(arguments, cases, label):
    """Each scene flown through by the rig of the scene before, with its IMU and what it has learnt there."""
    drawn_cases = [case for case in cases if case.kind == "drawn"]
    scenes = {case.scene.name: case for case in cases if case.kind == "exact"}
    names = list(scenes)
    for first in drawn_cases:
        second = scenes[names[(names.index(first.scene.name) + 1) % len(names)]]
        learnt = {pipeline: ("--calibration",
                             str(folder_of(arguments, label, first.sequence.name, pipeline, 0) / "calibration.yaml"))
                  for pipeline in arguments.pipelines}
        name = f"{second.sequence.name}-after-{first.sequence.name}"
        sequence = copy_drawn(arguments, second.sequence, name, first.seed, ["scale"])
        yield Case(second.scene, "second", sequence, name, tuple(learnt.items()))


def num_starts(arguments, case):
    return arguments.exact_starts if case.kind == "exact" else arguments.starts


def execute_all(arguments, cases, label, program):
    """{(scene, kind, pipeline): runs}, in the order of the cases."""
    groups, runs = {}, []
    duration = ["--duration", f"{arguments.duration:g}"] if arguments.duration else []
    for case in cases:
        for pipeline in arguments.pipelines:
            words = ["--pipeline", pipeline, *duration, *(w for text in arguments.set for w in ("--set", text)),
                     *dict(case.words).get(pipeline, ())]
            config = run_all.Config(pipeline, program, words)
            for i in range(num_starts(arguments, case)):
                folder = folder_of(arguments, label, case.name or case.sequence.name, pipeline, i)
                run = run_all.Run(case.sequence, config, 0.1 * i, folder)
                runs.append(run)
                groups.setdefault((case.scene.name, case.kind, pipeline), []).append(run)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(execute, runs))
    return groups


# ------------------------------------------------------------------------------------------------ figures

def median(values):
    """A run without a result is an infinite error."""
    return statistics.median(math.inf if v is None else v for v in values)


def ate_mm(runs):
    return 1e3 * median([run.ate() for run in runs])


def nees(runs, part):
    values = [run.evaluation.get("consistency", {}).get(part, {}).get("nees") for run in runs]
    values = [v for v in values if v is not None]
    return statistics.mean(values) if values else math.nan


CALIBRATION = {  # key of evaluation.json: name of the figure
    "disparity_mean_px": "disparity error at infinity [px]",
    "disparity_rms_px": "disparity error, rms [px]",
    "vertical_rms_px": "vertical error, rms [px]",
    "time_offset_ms": "time offset error [ms]",
    "nees": "calibration NEES",
}


def sizes(values):
    """Absolute values of those that there are; NaN without any, as where the calibration was held. What has failed is in
    the errors of position."""
    return [abs(v) for v in values if v is not None] or [math.nan]


def calibration_figures(runs):
    """What is left of the errors at the ends of the runs."""
    figures = {}
    for key, name in CALIBRATION.items():
        values = sizes(run.evaluation.get("calibration", {}).get(key) for run in runs)
        figures[name] = statistics.mean(values)
        if key == "time_offset_ms":
            figures["time offset error, worst run [ms]"] = max(values)
    scales = sizes(run.evaluation.get("scale_error_percent") for run in runs)
    figures["error of scale [%]"] = statistics.mean(scales)
    figures["error of scale, worst run [%]"] = max(scales)
    return figures


def figures_of(groups, scene, kinds, pipelines):
    """A row of figures: {column: value}."""
    row = {}
    for pipeline in pipelines:
        exact = ate_mm(groups[scene, "exact", pipeline])
        row[f"{pipeline} exact mm"] = exact
        for kind in kinds:
            error = ate_mm(groups[scene, kind, pipeline])
            row[f"{pipeline} {kind} mm"] = error
            row[f"{pipeline} {kind}/exact"] = error / exact
            worst = max(ate_mm([run]) for run in groups[scene, kind, pipeline])
            row[f"{pipeline} {kind}/exact, worst run"] = worst / exact
        for kind in ["exact", *kinds]:
            for part in ("position", "orientation"):
                row[f"{pipeline} {part} NEES {kind}"] = nees(groups[scene, kind, pipeline], part)
        for kind in ["exact", *kinds]:
            for name, value in calibration_figures(groups[scene, kind, pipeline]).items():
                row[f"{pipeline} {kind}: {name}"] = value
    if "S" in pipelines and "SPR" in pipelines:
        for kind in ["exact", *kinds]:
            pairs = zip(groups[scene, kind, "SPR"], groups[scene, kind, "S"], strict=True)
            ratios = [a.ate() / b.ate() if a.ate() and b.ate() else None for a, b in pairs]
            row[f"SPR/S {kind}"] = median(ratios)
            row[f"SPR/S {kind}, worst run"] = max(r if r is not None else math.inf for r in ratios)
    return row


def overall(table, column):
    """Median over the scenes, and the worst: NEES may be too small as well as too large."""
    values = [row[column] for row in table.values()]
    worst = max(values, key=lambda v: abs(math.log(v)) if "NEES" in column and v > 0 else v)
    return statistics.median(values), worst


def form(column, value):
    if any(unit in column for unit in ("[px]", "[ms]", "[%]")):
        return f"{value:.3f}"
    return f"{value:.2f}" if "mm" not in column or value < 9.95 else f"{value:.1f}"


def print_table(title, table):
    """A line for each figure, a column for each scene."""
    if not table:
        sys.exit("suite: nothing to run")
    columns = list(next(iter(table.values())))
    print(f"\n{title}\n\n| | {' | '.join(table)} | median | worst | mean |\n|---|{'---|' * (len(table) + 3)}")
    for column in columns:
        cells = [form(column, row[column]) for row in table.values()]
        mean = statistics.mean(row[column] for row in table.values())
        cells += [form(column, value) for value in (*overall(table, column), mean)]
        print(f"| {column} | {' | '.join(cells)} |")


def ratio_table(table, reference):
    """ATE over that of the reference."""
    return {scene: {column.replace(" mm", " ATE ratio"): value / reference[scene][column]
                    for column, value in row.items() if column.endswith(" mm")}
            for scene, row in table.items()}


def run_variant(arguments, scenes, variant, kinds):
    cases = list(list_cases(arguments, scenes, variant, kinds))
    until = f"-{arguments.duration:g}s" if arguments.duration else ""
    names = list(dict.fromkeys(case.scene.name for case in cases))
    programs = {"program": arguments.program}
    if arguments.against:
        programs["against"] = arguments.against
    tables = {}
    for label, program in programs.items():
        label_of_runs = f"{label}-{variant}{until}"
        groups = execute_all(arguments, cases, label_of_runs, program)
        if "second" in kinds:
            again = list(second_flights(arguments, cases, label_of_runs))
            groups.update(execute_all(arguments, again, label_of_runs, program))
        tables[label] = {name: figures_of(groups, name, kinds, arguments.pipelines) for name in names}
        print_table(f"Variant {variant}, {program}, {arguments.starts} start(s) of {arguments.draws} draws, "
                    f"{arguments.exact_starts} of the exact calibration",
                    tables[label])
    if arguments.against:
        print_table("Ratio of the first program to the second", ratio_table(tables["program"], tables["against"]))
    (arguments.out / f"figures-{variant}{until}.json").write_text(json.dumps(tables, indent=1) + "\n", encoding="utf-8")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["make", "run", "second", "attribution"])
    parser.add_argument("--suite", type=Path, default=ROOT / "config" / "suite.yaml")
    parser.add_argument("--out", type=Path, default=ROOT / "runs" / "suite")
    parser.add_argument("--scene", action="append", help="a part of its name; repeatable; all")
    parser.add_argument("--variant", help="a, b or ab (make: ab, otherwise a)")
    parser.add_argument("--pipelines", default="S,SPR", type=lambda text: text.split(","))
    parser.add_argument("--starts", type=int, default=1)
    parser.add_argument("--exact-starts", type=int, help="with the exact calibration (as many as starts or draws)")
    parser.add_argument("--duration", type=float, help="of the runs, in seconds (all)")
    parser.add_argument("--draws", type=int, help="of each scene (as the suite's file says)")
    parser.add_argument("--program", default=str(ROOT / "build" / "facet"))
    parser.add_argument("--against", help="another program")
    parser.add_argument("--maker", default=str(ROOT / "build" / "facet"), help="the program that simulates")
    parser.add_argument("--set", action="append", default=[], help="option of facet run, key=value; repeatable")
    parser.add_argument("--jobs", type=int, default=min(2, os.cpu_count() or 1))
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    suite, scenes = read_suite(arguments.suite)
    if arguments.scene:
        scenes = [scene for scene in scenes if any(text in scene.name for text in arguments.scene)]
    arguments.draws = suite["draws"] if arguments.draws is None else arguments.draws
    arguments.exact_starts = arguments.exact_starts or max(arguments.starts, arguments.draws)
    arguments.variant = arguments.variant or ("ab" if arguments.what == "make" else "a")
    if arguments.what == "make":
        make(arguments, suite, scenes)
        return
    kinds = {"drawn": PARTS} if arguments.draws > 0 else {}
    if arguments.what == "attribution":
        kinds = {**{part: [part] for part in PARTS}, "drawn": PARTS}
    if arguments.what == "second":
        kinds = {"drawn": PARTS, "second": []}
    for variant in arguments.variant:
        run_variant(arguments, scenes, variant, kinds)


if __name__ == "__main__":
    main()
