# SPDX-License-Identifier: BSD-2-Clause
"""facet.run, facet.Recording, facet.evaluate and facet.simulate: results, and clear errors."""

import os
import signal

import numpy as np
import pytest
from conftest import fly

import facet


def test_a_result_is_arrays(result, frames):
    assert result.summary["frames"] == len(frames)
    trajectory, keyframes = result.trajectory, result.keyframes
    assert len(trajectory) == result.summary["frames_with_pose"] and len(keyframes) == result.summary["keyframes"]
    assert trajectory.p.shape == (len(trajectory), 3) and trajectory.q.shape == (len(trajectory), 4)
    states = result.states
    assert states["timestamp_ns"].dtype == np.int64
    assert list(states["timestamp_ns"]) == [frame.t_ns for frame in frames]
    assert set(states["status"]) <= {"initialising", "ok", "degraded", "lost"}
    assert result.timing["total"].dtype == np.float64
    assert len(result.planes["id"]) == result.summary["planes_total"]
    assert len(result.mesh()) == result.summary["mesh_faces"] and len(result.map()) == result.summary["map_faces"]
    assert os.fspath(result) == str(result.path)


def test_progress_is_told_and_may_stop(sequence, tmp_path, frames):
    told = []
    facet.run(sequence, tmp_path / "all", mesh={"enabled": False}, pipeline="S",
              progress=lambda done, total: told.append((done, total)))
    assert [done for done, _ in told] == list(range(1, len(frames) + 1)) and told[-1][1] == len(frames)

    def stop(done, total):
        if done == 20:
            raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        facet.run(sequence, tmp_path / "part", progress=stop)
    assert facet.Result(tmp_path / "part").summary["frames"] == 20


def test_one_command_at_a_time(sequence, tmp_path):
    def run_another(done, total):
        facet.run(sequence, tmp_path / "inner", pipeline="S")

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(facet.Error, match="one command at a time"):
        facet.run(sequence, tmp_path / "outer", pipeline="S", progress=run_another)
    assert signal.getsignal(signal.SIGINT) is before
    facet.run(sequence, tmp_path / "after", mesh={"enabled": False}, pipeline="S")


def test_control_c_ends_in_good_order(sequence, tmp_path):
    handler = signal.getsignal(signal.SIGINT)

    def interrupt(done, total):
        if done == 20:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        facet.run(sequence, tmp_path / "part", progress=interrupt)
    assert 20 <= facet.Result(tmp_path / "part").summary["frames"] < 30
    assert signal.getsignal(signal.SIGINT) is handler
    with pytest.raises(KeyboardInterrupt):
        os.kill(os.getpid(), signal.SIGINT)
        for _ in range(1000):
            pass
    assert len(facet.run(sequence, tmp_path / "after", duration_s=1.5).trajectory) > 0


def test_a_run_that_cannot_start_has_a_result(sequence, tmp_path):
    with (pytest.raises(facet.RunEnded, match="could not start") as caught,
          pytest.warns(UserWarning, match="planes are found in the mesh")):  # it is told all the same
        facet.run(sequence, tmp_path / "result", duration_s=0.1, mesh={"enabled": False})
    assert caught.value.exit_code == 4
    assert len(caught.value.result.trajectory) == 0
    assert isinstance(caught.value, facet.Error)


def test_what_cannot_be_run_is_refused(sequence, tmp_path):
    out = tmp_path / "result"
    with pytest.raises(facet.InputError, match="nowhere"):
        facet.run("nowhere", out)
    with pytest.raises(facet.ConfigError, match="unknown key"):
        facet.run(sequence, out, mesh={"map": {"voxels": 1}})
    with pytest.raises(facet.ConfigError, match="no stereo pair there"):
        facet.run(sequence, out, start_s=100)
    with pytest.raises(ValueError, match="start_s"):
        facet.run(sequence, out, start_s=-1)
    with pytest.raises(ValueError, match="threads"):
        facet.run(sequence, out, threads=0)
    with pytest.raises(ValueError, match="mesh_format"):
        facet.run(sequence, out, mesh_format="obj")
    with pytest.raises(ValueError, match="mesh_every"):
        facet.run(sequence, out, mesh_every=-1)
    (tmp_path / "file").write_text("")
    with pytest.raises(facet.ConfigError, match="cannot be created"):
        facet.run(sequence, tmp_path / "file" / "result", duration_s=0.5)
    assert not out.exists()
    with pytest.raises(facet.InputError, match="summary.json"):
        facet.Result(tmp_path)


def test_warnings_of_a_run_are_warnings(sequence, tmp_path):
    with pytest.warns(UserWarning, match="planes are found in the mesh"):
        facet.run(sequence, tmp_path / "result", mesh={"enabled": False})


def test_a_recording_is_arrays(sequence, frames):
    recording = facet.Recording(sequence)
    assert recording.name == "flight" and recording.warnings == []
    assert [frame.t_ns for frame in recording] == [frame.t_ns for frame in recording]  # begins again
    frame = frames[1]
    assert frame.left.dtype == np.uint8 and frame.left.shape == frame.right.shape == (480, 752)
    assert frame.t_right_ns == frame.t_ns and len(frame.imu_t_ns) == len(frame.gyro) == len(frame.accel) == 10
    assert np.all(np.diff(frame.imu_t_ns) == 5_000_000) and abs(np.linalg.norm(frame.accel[0]) - 9.8) < 3
    kept = frame.left.copy()
    next(iter(recording))
    np.testing.assert_array_equal(frame.left, kept)


def test_unusable_images_are_passed_over(sequence, tmp_path):
    import shutil

    copy = shutil.copytree(sequence, tmp_path / "copy")
    images = sorted((copy / "mav0" / "cam0" / "data").iterdir())
    images[3].write_bytes(images[3].read_bytes()[:100])
    sorted((copy / "mav0" / "cam1" / "data").iterdir())[5].unlink()
    recording = facet.Recording(copy)
    read = list(recording)
    assert len(read) == len(images) - 1
    assert len(read[3].imu_t_ns) == 20 and read[4].right is None
    assert any(images[3].name in warning for warning in recording.warnings)
    states = fly(facet.Vio(recording.calibration), read)
    assert states[-1].has_pose


def test_what_cannot_be_read_is_refused(sequence, tmp_path):
    with pytest.raises(facet.InputError, match="nowhere"):
        facet.Recording("nowhere")
    with pytest.raises(facet.InputError):
        facet.Recording(tmp_path)
    with pytest.raises(facet.ConfigError, match="topic"):
        facet.Recording(sequence, topics={"left": "/cam0"})
    with pytest.raises(facet.ConfigError, match="no stereo pair there"):
        list(facet.Recording(sequence, start_s=100))
    with pytest.raises(ValueError, match="duration_s"):
        facet.Recording(sequence, duration_s=float("nan"))


def test_what_cannot_be_judged_is_refused(sequence, result):
    with pytest.raises(facet.InputError, match="nowhere"):
        facet.evaluate(result, "nowhere")
    with pytest.raises(facet.ConfigError, match="se3, yaw or sim3"):
        facet.evaluate(result, sequence, alignment="affine")
    with pytest.raises(ValueError, match="parts: colour is unknown"):
        facet.evaluate(result, sequence, parts=["colour"])
    with pytest.raises(ValueError, match="rpe_lengths_m"):
        facet.evaluate(result, sequence, rpe_lengths_m=[0])
    with pytest.raises(ValueError, match="need a result folder"):
        facet.evaluate(result.trajectory, sequence, align_time=True)
    with pytest.raises(ValueError, match="read_trajectory"):
        facet.evaluate(result, result.trajectory)
    late = facet.Trajectory(result.trajectory.t_ns + 10**12, result.trajectory.p, result.trajectory.q)
    with pytest.raises(facet.InputError, match="overlap"):
        facet.evaluate(late, sequence)


def test_trajectories_are_written_and_read(result, tmp_path):
    trajectory = result.trajectory
    trajectory.write(tmp_path / "copy.tum")
    # Quaternions are normalised where they are read, which may move their last digit.
    copy, original = ((folder / name).read_text().splitlines()
                      for folder, name in ((tmp_path, "copy.tum"), (result.path, "trajectory.tum")))
    assert copy[0] == original[0] and len(copy) == len(original)
    for line, before in zip(copy[1:], original[1:]):
        assert line.split()[:4] == before.split()[:4]
        np.testing.assert_allclose([float(word) for word in line.split()[4:]],
                                   [float(word) for word in before.split()[4:]], rtol=0, atol=1.1e-12)
    with pytest.raises(ValueError, match="stamps must rise"):
        facet.Trajectory(trajectory.t_ns[::-1], trajectory.p, trajectory.q).write(tmp_path / "no.tum")
    with pytest.raises(ValueError, match="unit length"):
        facet.Trajectory(trajectory.t_ns, trajectory.p, 2 * trajectory.q).write(tmp_path / "no.tum")
    with pytest.raises(ValueError, match="p: the shape"):
        facet.Trajectory(trajectory.t_ns, trajectory.p[1:], trajectory.q).write(tmp_path / "no.tum")
    with pytest.raises(facet.OutputError):
        trajectory.write(tmp_path / "nowhere" / "no.tum")


def test_simulated_frames_are_arrays_without_a_folder_that_stays(sequence):
    with facet.simulated(duration_s=0.5, imu={"add_noise": False}, clean_images=False) as recording:
        frames = list(recording)
        path = recording.path
        assert len(facet.read_truth(path)) > 50
    assert 10 <= len(frames) <= 11 and frames[0].left.std() > 5 and not path.exists()


def test_what_cannot_be_simulated_is_refused(sequence, tmp_path):
    with pytest.raises(facet.ConfigError, match="exists already"):
        facet.simulate(sequence)
    with pytest.raises(facet.Error, match="room"):
        facet.simulate(tmp_path / "out", scene="moon")
    with pytest.raises(facet.ConfigError, match="unknown key"):
        facet.simulate(tmp_path / "out", imu={"noise": 1})
    with pytest.raises(ValueError, match="duration_s"):
        facet.simulate(tmp_path / "out", duration_s=-1)
    assert not (tmp_path / "out").exists()
