"""What a node of ROS has published against the result folder of `facet run` on the same data."""

import copy
import csv
from pathlib import Path

import numpy as np

ADD, DELETE = 0, 2  # visualization_msgs/Marker


def stamp(message):
    return message.header.stamp.to_nsec()


def rotation(q):
    """Of a quaternion x y z w, as a matrix."""
    x, y, z, w = q
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def pose_of(pose):
    p, q = pose.position, pose.orientation
    return np.array([p.x, p.y, p.z]), rotation([q.x, q.y, q.z, q.w])


def angle(R):
    """Of a small turn; the trace would lose half the digits."""
    return np.linalg.norm([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2


class Result:
    """states.csv, the sizes of meshes/*.ply, and the ids of planes.csv."""

    def __init__(self, folder):
        self.states = {}
        with open(Path(folder) / "states.csv", newline="") as stream:
            for row in csv.DictReader(stream):
                if row["px"].strip():
                    self.states[int(row["timestamp_ns"])] = row
        self.meshes = {int(file.stem): self.sizes(file) for file in (Path(folder) / "meshes").glob("*.ply")}
        with open(Path(folder) / "planes.csv", newline="") as stream:
            self.planes = {int(row["id"]) for row in csv.DictReader(stream)}

    @staticmethod
    def sizes(file):
        """(vertices, faces) by the head of a PLY file."""
        found = {}
        with open(file, "rb") as stream:
            for line in stream:
                words = line.split()
                if words[:1] == [b"element"]:
                    found[words[1].decode()] = int(words[2])
                if words == [b"end_header"]:
                    return found["vertex"], found["face"]

    def numbers(self, t, *names):
        return np.array([float(self.states[t][name]) for name in names])

    def pose(self, t):
        return self.numbers(t, "px", "py", "pz"), rotation(self.numbers(t, "qx", "qy", "qz", "qw"))


def compare_poses(poses, result):
    """The pose of each pair is that of the run, with its covariance about the fixed axes."""
    expected, stamps = set(result.states), [stamp(m) for m in poses]
    if stamps != sorted(expected):
        yield f"poses: {len(stamps)} stamps, {len(expected - set(stamps))} of the run's {len(expected)} are missing"
    for message in poses:
        t = stamp(message)
        if t not in expected:
            continue
        p, R = pose_of(message.pose.pose)
        p_run, R_run = result.pose(t)
        if np.abs(p - p_run).max() > 2e-9 or angle(R.T @ R_run) > 1e-9:
            yield f"pose at {t}: {np.abs(p - p_run).max():.2g} m and {angle(R.T @ R_run):.2g} rad from the run's"
        covariance = np.array(message.pose.covariance).reshape(6, 6)
        sigma_p = result.numbers(t, "sigma_px", "sigma_py", "sigma_pz")
        sigma_r = result.numbers(t, "sigma_rx", "sigma_ry", "sigma_rz")
        in_body = R.T @ covariance[3:, 3:] @ R
        stated = np.sqrt(np.concatenate([covariance.diagonal()[:3], in_body.diagonal()]))
        if not np.allclose(stated, np.concatenate([sigma_p, sigma_r]), rtol=1e-4, atol=1e-9):
            yield f"covariance at {t}: sigmas {stated}, of the run {sigma_p} {sigma_r}"


def compare_odometry(odometry, result, imu_stamps):
    """One message for each IMU sample, near the poses on either side, with velocity along the body's axes."""
    stamps = [stamp(m) for m in odometry]
    if not stamps:
        yield "odometry: none"
        return
    expected = [t for t in imu_stamps if stamps[0] <= t]
    if stamps != expected:
        yield f"odometry: {len(stamps)} messages for {len(expected)} IMU samples, or other stamps"
    frames = np.array(sorted(result.states))
    positions = np.array([result.pose(t)[0] for t in frames])
    errors, velocity_errors = [], []
    for message in odometry:
        t = stamp(message)
        if not frames[0] <= t <= frames[-1]:
            continue
        p, R = pose_of(message.pose.pose)
        errors.append(np.linalg.norm(p - [np.interp(t, frames, positions[:, i]) for i in range(3)]))
        nearest = int(frames[np.abs(frames - t).argmin()])
        v = message.twist.twist.linear
        if abs(nearest - t) < 3_000_000:
            v_run = result.numbers(nearest, "vx", "vy", "vz")
            velocity_errors.append(np.linalg.norm(R @ [v.x, v.y, v.z] - v_run))
        for name, matrix in (("pose", message.pose.covariance), ("twist", message.twist.covariance)):
            matrix = np.array(matrix).reshape(6, 6)
            if not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix)[0] <= 0:
                yield f"odometry at {t}: the covariance of its {name} is none"
    if not errors or max(errors) > 0.05 or np.median(errors) > 0.01:
        yield f"odometry: {np.median(errors):.4f} m (median), {max(errors):.4f} m (at most) from the run's poses"
    if not velocity_errors or max(velocity_errors) > 0.2 or np.median(velocity_errors) > 0.05:
        yield f"odometry: velocity {np.median(velocity_errors):.3f} m/s (median) from the run's"


def compare_meshes(heard, result):
    """Faces and points of every keyframe that was published; nearly all are."""
    meshes = {stamp(m): len(m.points) // 3 for m in heard["mesh"] if m.action == ADD}
    points = {stamp(m): m.width for m in heard["points"]}
    full = {t: size for t, size in result.meshes.items() if size[1] > 0}
    if len(meshes) < 0.8 * len(full):
        yield f"mesh: {len(meshes)} of {len(full)} keyframes"
    for t, faces in meshes.items():
        if t not in result.meshes or faces != result.meshes[t][1]:
            yield f"mesh at {t}: {faces} faces, of the run {result.meshes.get(t)}"
    for t, width in points.items():
        if t not in result.meshes or width != result.meshes[t][0]:
            yield f"points at {t}: {width}, vertices of the run {result.meshes.get(t)}"
    if not points:
        yield "points: none"


def compare_planes(heard, result):
    """No plane that the run does not know, unless it is gone again."""
    shown = set()
    for array in heard["planes"]:
        for marker in array.markers:
            if marker.action == ADD:
                shown.add(marker.id)
            elif marker.action == DELETE:
                shown.discard(marker.id)
    if shown - result.planes:
        yield f"planes {sorted(shown - result.planes)} are not among the run's {sorted(result.planes)}"


def compare_transforms(heard):
    """odom to base_link as in the odometry; map to odom is the identity."""
    static = [t for m in heard["/tf_static"] for t in m.transforms]
    if [(t.header.frame_id, t.child_frame_id, t.transform.rotation.w) for t in static] != [("map", "odom", 1.0)]:
        yield "tf_static: not one identity from map to odom"
    moving = {t.header.stamp.to_nsec(): t for m in heard["/tf"] for t in m.transforms}
    if {(t.header.frame_id, t.child_frame_id) for t in moving.values()} != {("odom", "base_link")}:
        yield "tf: other frames than odom and base_link"
    for message in heard["odometry"]:
        transform = moving.get(stamp(message))
        if transform is None or transform.transform.translation.x != message.pose.pose.position.x:
            yield f"tf at {stamp(message)}: not that of the odometry"
            return


def compare(heard, result, imu_stamps):
    """A line for each difference."""
    return [*compare_poses(heard["pose"], result), *compare_odometry(heard["odometry"], result, imu_stamps),
            *compare_meshes(heard, result), *compare_planes(heard, result), *compare_transforms(heard)]


def unseen_changes(heard, result, imu_stamps):
    """Changes single numbers of what was heard, one at a time, and yields the names of the changes that `compare` does not
    see: a comparison that finds nothing proves nothing, unless it finds what is there."""
    def change_position(poses):
        poses[50].pose.pose.position.y += 1e-6

    def change_rotation(poses):
        poses[50].pose.pose.orientation.x += 1e-5

    def change_covariance(poses):
        covariance = list(poses[50].pose.covariance)
        covariance[28] *= 1.01
        poses[50].pose.covariance = covariance

    def change_stamp(poses):
        poses[50].header.stamp.nsecs += 1

    def change_faces(meshes):
        message = [m for m in meshes if m.points][3]
        message.points = message.points[3:]

    def lose_state(odometry):
        del odometry[200]

    def turn_twist(odometry):
        for message in odometry:
            v = message.twist.twist.linear
            v.x, v.y = v.y, -v.x

    def change_parent(transforms):
        transforms[10].transforms[0].header.frame_id = "map"

    for topic, change in (("pose", change_position), ("pose", change_rotation), ("pose", change_covariance),
                          ("pose", change_stamp), ("mesh", change_faces), ("odometry", lose_state),
                          ("odometry", turn_twist), ("/tf", change_parent)):
        changed = {**heard, topic: copy.deepcopy(heard[topic])}
        change(changed[topic])
        if not compare(changed, result, imu_stamps):
            yield change.__name__
