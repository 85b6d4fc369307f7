# SPDX-License-Identifier: BSD-2-Clause
"""facet.Vio: arrays in and out without copies, and clear errors."""

import sys
import threading
import time

import numpy as np
import pytest
from conftest import fly, poses

import facet

FIRST = slice(0, 30)  # frames that are enough for a pose


@pytest.fixture()
def vio(sequence):
    return facet.Vio(facet.Recording(sequence).calibration)


@pytest.fixture(scope="module")
def expected(sequence, frames):
    return poses(fly(facet.Vio(facet.Recording(sequence).calibration), frames[FIRST]))


def test_the_state_is_numpy(vio, frames):
    state = fly(vio, frames[FIRST])[-1]
    assert state.has_pose and state.status == "ok" and state.reason == ""
    np.testing.assert_allclose(state.T_WB[:3, 3], state.p)
    np.testing.assert_allclose(state.T_WB[:3, :3] @ state.T_WB[:3, :3].T, np.eye(3), atol=1e-12)
    w, x, y, z = state.q
    np.testing.assert_allclose(state.T_WB[0, 0], 1 - 2 * (y * y + z * z))
    np.testing.assert_allclose(state.T_WB[1, 0], 2 * (x * y + w * z))
    assert np.all(state.sigma_p > 0) and state.sigma_theta.shape == state.sigma_v.shape == (3,)
    assert state.t_ns == frames[FIRST][-1].t_ns and "ok" in repr(state)


def test_samples_may_come_one_by_one(vio, frames, expected):
    states = []
    for frame in frames[FIRST]:
        for t_ns, gyro, accel in zip(frame.imu_t_ns, frame.gyro, frame.accel):
            vio.add_imu(int(t_ns), list(gyro), tuple(accel))
        states.append(vio.add_stereo(frame.t_ns, frame.left, frame.right))
    np.testing.assert_array_equal(poses(states), expected)


def test_images_are_kept_for_two_more_frames_and_not_copied(sequence, frames):
    vio = facet.Vio(facet.Recording(sequence).calibration)
    images = [(np.array(frame.left), np.array(frame.right)) for frame in frames[:6]]
    before = sys.getrefcount(images[0][0])
    counts = []
    for frame, (left, right) in zip(frames, images):
        vio.add_imu(frame.imu_t_ns, frame.gyro, frame.accel)
        vio.add_stereo(frame.t_ns, left, right)
        del left, right
        counts.append(sys.getrefcount(images[0][0]))
    assert counts[:3] == [before + 1] * 3
    assert counts[3:] == [before] * 3
    del vio
    assert len({sys.getrefcount(left) for left, _ in images}) == 1


def test_copied_images_may_be_written_to_at_once(vio, frames, expected):
    left, right = np.empty_like(frames[0].left), np.empty_like(frames[0].right)

    def reused(frame):
        np.copyto(left, frame.left)
        np.copyto(right, frame.right)
        return left, right

    before = sys.getrefcount(left)
    np.testing.assert_array_equal(poses(fly(vio, frames[FIRST], reused, copy=True)), expected)
    assert sys.getrefcount(left) == before


def test_rows_may_be_apart_and_arrays_read_only(vio, frames, expected):
    def strided(frame):
        images = []
        for image in (frame.left, frame.right):
            larger = np.zeros((image.shape[0] + 3, image.shape[1] + 21), np.uint8)
            larger[2:-1, 5:-16] = image
            larger.flags.writeable = False
            images.append(larger[2:-1, 5:-16])
        return images

    np.testing.assert_array_equal(poses(fly(vio, frames[FIRST], strided)), expected)


@pytest.mark.parametrize("image, error, text", [
    ([[0, 1], [2, 3]], TypeError, "numpy.ndarray of uint8 or None, not list"),
    (np.zeros((240, 320)), TypeError, "this array is float64"),
    (np.zeros((240, 320), np.uint16), TypeError, "image >> 8"),
    (np.zeros((240, 320), np.int8), TypeError, "uint8"),
    (np.zeros((240, 320, 3), np.uint8), ValueError, r"\(240, 320, 3\); colours become grey"),
    (np.zeros((320, 240), np.uint8), ValueError, "the calibration is for 320 x 240 pixels, this image has 240 x 320"),
    (np.zeros((240, 320, 3), np.uint8)[:, :, 0], ValueError, r"numpy.ascontiguousarray\(left\)"),
    (np.zeros((320, 240), np.uint8).T, ValueError, r"numpy.ascontiguousarray\(left\)"),
    (np.zeros((240, 320), np.uint8)[::-1], ValueError, r"numpy.ascontiguousarray\(left\)"),
    (np.broadcast_to(np.zeros(320, np.uint8), (240, 320)), ValueError, r"numpy.ascontiguousarray\(left\)"),
])
def test_what_is_no_image_is_refused(calibration, image, error, text):
    vio = facet.Vio(calibration)
    with pytest.raises(error, match=text):
        vio.add_stereo(0, image, None)
    with pytest.raises(error, match="right: "):
        vio.add_stereo(0, None, image)


def test_missing_images_are_no_error(calibration):
    state = facet.Vio(calibration).add_stereo(0, None, None)
    assert not state.has_pose and state.status == "initialising"


@pytest.mark.parametrize("samples, error, text", [
    ((0.5, [0, 0, 0], [0, 0, 9.8]), TypeError, "stamps are integers, nanoseconds"),
    ((np.array([0.0, 1.0]), np.zeros((2, 3)), np.zeros((2, 3))), TypeError, "1e9 . seconds"),
    ((0, [0, 0], [0, 0, 9.8]), ValueError, r"gyro: the shape \(3,\) is expected, here it is \(2,\)"),
    ((np.arange(4), np.zeros((4, 3)), np.zeros((3, 3))), ValueError, r"accel: the shape \(4, 3\) is expected"),
    ((0, "fast", [0, 0, 9.8]), (TypeError, ValueError), "gyro"),
    ((np.zeros((2, 2), int), np.zeros((4, 3)), np.zeros((4, 3))), ValueError, "t_ns: one stamp, or a row"),
])
def test_what_are_no_samples_is_refused(calibration, samples, error, text):
    with pytest.raises(error, match=text):
        facet.Vio(calibration).add_imu(*samples)


def test_samples_that_are_not_finite_are_no_error(calibration):
    vio = facet.Vio(calibration)
    vio.add_imu(np.arange(3) * 5_000_000, np.full((3, 3), np.nan), np.full((3, 3), np.inf))
    assert not vio.add_stereo(0, None, None).has_pose


def test_meshes_are_views_that_outlive_the_rest(vio, frames):
    fly(vio, frames)
    mesh = vio.mesh()
    vertices, faces, plane_ids = mesh.vertices, mesh.faces, mesh.plane_ids
    assert vertices.dtype == np.float64 and faces.dtype == np.int32 and plane_ids.dtype == np.int64
    assert vertices.shape[1] == faces.shape[1] == 3 and len(plane_ids) == len(faces) == len(mesh) > 100
    assert np.shares_memory(vertices, mesh.vertices) and vertices.base is mesh
    assert faces.min() == 0 and faces.max() < len(vertices)
    copies = vertices.copy(), faces.copy(), plane_ids.copy()
    planes = vio.planes()
    outline = planes[0].outline
    del mesh, vio, planes
    for view, copy in zip((vertices, faces, plane_ids), copies):
        np.testing.assert_array_equal(view, copy)
    assert outline.shape[1] == 3 and len(outline) >= 3


def test_planes_are_on_the_mesh(vio, frames):
    fly(vio, frames)
    mesh, planes = vio.map(), {plane.id: plane for plane in vio.planes()}
    assert planes
    for plane in planes.values():
        np.testing.assert_allclose(np.linalg.norm(plane.n), 1)
        corners = mesh.vertices[mesh.faces[mesh.plane_ids == plane.id]]
        assert plane.area_m2 > 0 and len(corners) > 10
        assert np.median(np.abs(corners @ plane.n - plane.d)) < 0.03, plane


def test_meshes_are_written_and_read(vio, frames, tmp_path):
    fly(vio, frames[FIRST])
    mesh = vio.mesh()
    mesh.write(tmp_path / "mesh.ply")
    read = facet.read_mesh(tmp_path / "mesh.ply")
    np.testing.assert_allclose(read.vertices, mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(read.faces, mesh.faces)
    np.testing.assert_array_equal(read.plane_ids, mesh.plane_ids)


def test_parameters_are_keyword_arguments(sequence, frames, tmp_path):
    calibration = facet.Recording(sequence).calibration
    vio = facet.Vio(calibration, pipeline="S", mesh={"map.enabled": False})
    fly(vio, frames[FIRST])
    assert len(vio.map()) == 0 and vio.planes() == []
    (tmp_path / "mine.yaml").write_text("mesh: {enabled: false}\n")
    vio = facet.Vio(calibration, config=tmp_path / "mine.yaml")
    fly(vio, frames[FIRST])
    assert len(vio.mesh()) == 0
    with pytest.raises(facet.Error, match="unknown key"):
        facet.Vio(calibration, frontend={"max_feature": 7})
    with pytest.raises(facet.Error, match="allowed"):
        facet.Vio(calibration, frontend={"max_features": -7})
    with pytest.raises(TypeError, match="frontend.max_features: a parameter is a number"):
        facet.Vio(calibration, frontend={"max_features": [7]})
    with pytest.raises(facet.Error, match="nowhere.yaml"):
        facet.Vio(calibration, config="nowhere.yaml")
    with pytest.warns(UserWarning, match="truncation_m"):
        facet.Vio(calibration, mesh={"map": {"truncation_m": 0.16}})


def test_the_pose_comes_first(vio, frames):
    told = []
    vio.on_pose(lambda state: told.append(state.t_ns))
    for number, frame in enumerate(frames[:5]):
        vio.add_stereo(frame.t_ns, frame.left, frame.right)
        assert told == [f.t_ns for f in frames[:number + 1]]
    vio.on_pose(None)
    vio.add_stereo(frames[5].t_ns, None, None)
    assert len(told) == 5


def test_what_an_observer_raises_is_raised(vio, frames):
    def stumble(state):
        raise KeyError("not mine")

    vio.on_pose(stumble)
    with pytest.raises(KeyError, match="not mine"):
        vio.add_stereo(frames[0].t_ns, frames[0].left, frames[0].right)
    vio.on_pose(lambda state: vio.mesh())
    with pytest.raises(facet.Error, match="on_pose may not call"):
        vio.add_stereo(frames[1].t_ns, frames[1].left, frames[1].right)
    vio.on_pose(lambda state: vio.on_pose(None))
    for _ in range(2):  # what was refused has changed nothing
        with pytest.raises(facet.Error, match="on_pose may not call"):
            vio.add_stereo(frames[1].t_ns, frames[1].left, frames[1].right)
    vio.on_pose(None)
    for stamp in (1.5, np.float32(2), np.array([2.7])):
        with pytest.raises(TypeError, match="stamps are integers"):
            vio.add_stereo(stamp, None, None)
    assert vio.add_stereo(frames[2].t_ns, None, None).t_ns == frames[2].t_ns


def test_other_threads_go_on_meanwhile(vio, frames):
    """No thread is made to yield for 1000 s, so the counter moves only where the lock is given back."""
    count, is_done = [0], threading.Event()

    def work():
        while not is_done.is_set():
            count[0] += 1
            time.sleep(1e-4)

    interval = sys.getswitchinterval()
    worker = threading.Thread(target=work)
    try:
        sys.setswitchinterval(1000)
        worker.start()
        before = count[0]
        for frame in frames[:20]:
            vio.add_stereo(frame.t_ns, frame.left, frame.right)
        after = count[0]
    finally:
        is_done.set()
        sys.setswitchinterval(interval)
        worker.join()
    assert after > before


def test_several_threads_may_call(vio, frames):
    def read():
        for _ in range(20):
            assert len(vio.mesh()) >= 0

    readers = [threading.Thread(target=read) for _ in range(2)]
    for reader in readers:
        reader.start()
    states = fly(vio, frames[FIRST])
    for reader in readers:
        reader.join()
    assert states[-1].has_pose


def test_calibrations_are_plain_data(sequence, calibration):
    read = facet.read_calibration(sequence)
    assert (read.left.width, read.left.height, read.left.distortion) == (752, 480, "radtan")
    assert read.gyro_noise > 0 and not read.has_covariance
    T_BC = read.left.T_BC
    read.left.T_BC = T_BC
    np.testing.assert_allclose(read.left.T_BC, T_BC, atol=1e-12)
    assert calibration.left.coefficients.shape == (8,)
    assert not calibration.left.lens_modes.any() and calibration.left.lens_modes.shape == (10,)
    read.right.lens_modes = np.arange(10) / 100
    assert read.right.lens_modes[3] == 0.03
    with pytest.raises(ValueError, match="not a rigid motion"):
        calibration.left.T_BC = 2 * np.eye(4)
    with pytest.raises(ValueError, match="known: none, radtan"):
        calibration.left.distortion = "fisheye"
    with pytest.raises(ValueError, match="up to 8"):
        calibration.left.coefficients = [0] * 9
    calibration.right.T_BC = calibration.left.T_BC
    with pytest.raises(facet.Error, match="same place"):
        facet.Vio(calibration)
    with pytest.raises(facet.Error, match="nowhere"):
        facet.read_calibration("nowhere")
