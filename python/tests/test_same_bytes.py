# SPDX-License-Identifier: BSD-2-Clause
"""Python writes what the program writes."""

import json

import numpy as np
from conftest import SIMULATE, fly

import facet

MEASURED = {"summary.json", "timing.csv"}  # have times of the machine


def files_of(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_simulator_writes_what_the_program_writes(program, sequence, tmp_path):
    program("simulate", "--out", tmp_path / "flight", "--quiet", *SIMULATE)
    expected, written = files_of(tmp_path / "flight"), files_of(sequence)
    description = "simulation.txt"
    assert b"facet.simulate" in written.pop(description)
    expected.pop(description)
    assert written == expected
    assert len(written) > 100


def test_a_run_writes_what_the_program_writes(program, sequence, result, tmp_path):
    program("run", sequence, "--out", tmp_path / "result", "--quiet")
    expected, written = files_of(tmp_path / "result"), files_of(result.path)
    assert written.keys() == expected.keys()
    assert {"trajectory.tum", "map.ply", "planes.csv"} <= written.keys()
    for name in written.keys() - MEASURED:
        assert written[name] == expected[name], name


def test_options_are_those_of_the_program(program, sequence, tmp_path):
    program("run", sequence, "--out", tmp_path / "program", "--quiet", "--pipeline", "S", "--start", 0.5, "--duration",
            1.5, "--set", "mesh.map.enabled=false", "--set", "frontend.max_features=100")
    run = facet.run(sequence, tmp_path / "python", pipeline="S", start_s=0.5, duration_s=1.5,
                    mesh={"map": {"enabled": False}}, frontend={"max_features": np.int64(100)})
    for name in ("trajectory.tum", "config.yaml", "mesh.ply"):
        assert (run.path / name).read_bytes() == (tmp_path / "program" / name).read_bytes(), name
    assert not (run.path / "map.ply").exists()


def test_a_vio_that_is_fed_from_files_gives_the_trajectory_of_the_program(program, sequence, frames, tmp_path):
    program("run", sequence, "--out", tmp_path / "result", "--quiet")
    states = fly(facet.Vio(facet.Recording(sequence).calibration), frames)
    facet.Trajectory.of_states(states).write(tmp_path / "vio.tum")
    expected = (tmp_path / "result" / "trajectory.tum").read_bytes()
    assert (tmp_path / "vio.tum").read_bytes() == expected
    assert len(expected.splitlines()) > 20


def test_a_part_of_a_recording_is_the_same_part(sequence, tmp_path):
    run = facet.run(sequence, tmp_path / "result", start_s=0.5, duration_s=1.5, imu_history_s=0.2)
    recording = facet.Recording(sequence, start_s=0.5, duration_s=1.5, imu_history_s=0.2)
    facet.Trajectory.of_states(fly(facet.Vio(recording.calibration), recording)).write(tmp_path / "vio.tum")
    assert (tmp_path / "vio.tum").read_bytes() == (run.path / "trajectory.tum").read_bytes()


def test_the_evaluation_has_the_numbers_of_the_program(program, sequence, result):
    program("evaluate", result.path, "--truth", sequence)
    expected = json.loads((result.path / "evaluation.json").read_text())
    assert facet.evaluate(result, sequence) == expected
    assert result.evaluate(str(sequence), parts=["trajectory"])["ate"] == expected["ate"]
    assert expected["ate"]["rmse_m"] < 0.01


def test_trajectories_in_memory_are_judged_alike(sequence, result):
    expected = facet.evaluate(result, sequence, alignment="yaw", rpe_lengths_m=[0.2])
    judged = facet.evaluate(result.trajectory, sequence, alignment="yaw", rpe_lengths_m=[0.2])
    for part in ("ate", "rpe", "alignment"):
        assert judged[part] == expected[part]
    assert judged == facet.evaluate(result.trajectory, facet.read_truth(sequence), alignment="yaw", rpe_lengths_m=[0.2])


def test_the_configuration_has_the_text_of_the_program(program):
    assert facet.config_text() == program("config")
    assert facet.config_text(all=True, mesh={"map": {"voxel_m": 0.05}}) == program(
        "config", "--all", "--set", "mesh.map.voxel_m=0.05")
