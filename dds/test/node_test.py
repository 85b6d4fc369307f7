#!/usr/bin/python3
"""facet-dds against `facet run`: eight seconds of a recording are sent to it between processes, over DDS on loopback.

  node_test.py --node FACET_DDS --peer DDS_PEER --program FACET [--sequence FOLDER] [--keep FOLDER]

SEQUENCE is in the ASL layout; by default $FACET_DATA_DIR or ../shared/data, euroc_mh01_handheld. Exit code 77 where the
recording is missing. The bytes of all messages are made and read by ros2_messages.py, and read once more by an
independent codec where npm's packages are there (`npm ci` in dds/test). First run: raw images, calibration from files;
all that is published is compared with the run; then one number of what was heard is changed, and the comparison must
say so. Second run: compressed images, CameraInfo, two damaged images. Then services, and the same data again, which
begin anew.
"""

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SKIPPED = 77
SECONDS, SECONDS_DAMAGED = 8, 4
DAMAGED_LEFT, DAMAGED_RIGHT = 60, 70  # numbers of pairs
sys.path.append(str(ROOT / "src/facet/testing/robot"))


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


try:
    import numpy as np
    from PIL import Image as Picture

    from asl_recording import CAMERAS, frames, mount, rows, sensor
except ImportError as missing:
    skip(f"{missing} (scripts/setup.sh test)")

from compare_messages import Result, compare, stamp, unseen_changes
from ros2_messages import RecordFile, decode, encode, record

# One machine, one network that is always there, no multicast.
CYCLONE = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>
<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""
OUTPUTS = {"odometry": "nav_msgs/msg/Odometry", "pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
           "path": "nav_msgs/msg/Path", "mesh": "visualization_msgs/msg/Marker", "map": "visualization_msgs/msg/Marker",
           "points": "sensor_msgs/msg/PointCloud2", "planes": "visualization_msgs/msg/MarkerArray"}
GLOBALS = {"/tf": "tf2_msgs/msg/TFMessage", "/tf_static": "tf2_msgs/msg/TFMessage",
           "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray"}
LATCHED = ("path", "planes", "/tf_static")
failures = []


def check(condition, text):
    if not condition:
        print("FAILED:", text)
        failures.append(text)


def wait_for(condition, text, seconds):
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(f"{text} within {seconds} s")
        time.sleep(0.1)


# ---- what is sent

def image_message(file, is_compressed):
    if is_compressed:
        return "sensor_msgs/msg/CompressedImage", {"format": file.suffix[1:], "data": file.read_bytes()}
    picture = Picture.open(file).convert("L")
    return "sensor_msgs/msg/Image", {"height": picture.height, "width": picture.width, "encoding": "mono8",
                                     "step": picture.width, "data": picture.tobytes()}


def camera_info(mav0, camera):
    values = sensor(mav0, camera)
    fx, fy, cx, cy = values["intrinsics"]
    return {"width": values["resolution"][0], "height": values["resolution"][1], "distortion_model": "plumb_bob",
            "d": [*values["distortion_coefficients"], 0.0], "k": [fx, 0, cx, 0, fy, cy, 0, 0, 1],
            "r": [1, 0, 0, 0, 1, 0, 0, 0, 1]}


class Flight:
    """The first seconds of a recording as messages in the order of their stamps, images behind IMU samples."""

    def __init__(self, sequence, seconds, is_compressed=False, with_info=False, change=None):
        mav0 = sequence / "mav0"
        suffix = "/compressed" if is_compressed else ""
        self.messages = []
        for order, camera in enumerate(CAMERAS):
            images = frames(mav0, camera, seconds)
            info = camera_info(mav0, camera)
            for index, (t, file) in enumerate(images):
                if with_info:
                    self.add(t, 1, f"{camera}/camera_info", "sensor_msgs/msg/CameraInfo", info)
                kind, values = image_message(file, is_compressed)
                if change:
                    change(camera, index, values)
                self.add(t, 2 + order, f"{camera}/image_raw{suffix}", kind, values)
            if camera == "cam0":
                self.frame_stamps = [t for t, _ in images]
        begin, end = self.frame_stamps[0], self.frame_stamps[-1] + 100_000_000
        self.imu_stamps = []
        for row in rows(mav0 / "imu0/data.csv"):
            t, six = int(row[0]), [float(value) for value in row[1:7]]
            if begin - 500_000_000 <= t <= end:
                self.imu_stamps.append(t)
                self.add(t, 0, "imu0", "sensor_msgs/msg/Imu",
                         {"angular_velocity": dict(zip("xyz", six[:3])), "linear_acceleration": dict(zip("xyz", six[3:]))})
        self.messages.sort(key=lambda message: message[:2])

    def add(self, t, order, topic, kind, values):
        values = {"header": {"stamp": t, "frame_id": topic.split("/")[0]}, **values}
        self.messages.append((t, order, f"rt/{topic}", kind, encode(kind, values)))

    def write(self, file):
        file.write_bytes(b"".join(record(t, topic, kind, data) for t, _, topic, kind, data in self.messages))
        return file

    def write_folder(self, sequence, folder):
        """The same as an ASL folder, for `facet run`: images are links."""
        for camera in CAMERAS:
            (folder / "mav0" / camera).mkdir(parents=True)
            (folder / "mav0" / camera / "data").symlink_to((sequence / "mav0" / camera / "data").resolve())
            shutil.copy(sequence / "mav0" / camera / "sensor.yaml", folder / "mav0" / camera)
            lines = [row for row in rows(sequence / "mav0" / camera / "data.csv")
                     if int(row[0]) <= self.frame_stamps[-1]]
            self.write_csv(folder / "mav0" / camera / "data.csv", lines)
        (folder / "mav0/imu0").mkdir()
        shutil.copy(sequence / "mav0/imu0/sensor.yaml", folder / "mav0/imu0")
        wanted = set(self.imu_stamps)
        self.write_csv(folder / "mav0/imu0/data.csv",
                       [row for row in rows(sequence / "mav0/imu0/data.csv") if int(row[0]) in wanted])
        return folder

    @staticmethod
    def write_csv(file, lines):
        file.write_text("".join(",".join(row) + "\n" for row in lines))


# ---- what is heard

class Ears:
    """What a node publishes, in a process of its own."""

    def __init__(self, test, name, label=""):
        self.file = test.folder / f"{name}{label}.heard"
        self.name = name
        self.records, self.begin = RecordFile(self.file), {}
        self.names = {self.topic(topic): topic for topic in [*OUTPUTS, *GLOBALS]}
        self.heard = {topic: [] for topic in self.names.values()}
        words = []
        for topic, kind in [*OUTPUTS.items(), *GLOBALS.items()]:
            words += [self.topic(topic) + ("!" if topic in LATCHED else ""), kind]
        self.process = test.start([test.arguments.peer, "listen", self.file, *words], f"{name}{label}.ears.txt")

    def topic(self, topic):
        return f"rt{topic}" if topic in GLOBALS else f"rt/{self.name}/{topic}"

    def update(self):
        for topic, kind, data in self.records.new():
            self.heard[self.names[topic]].append((kind, data))

    def take(self):
        """{topic: messages}, of all since the last time."""
        self.update()
        heard = {topic: [decode(*message) for message in messages[self.begin.get(topic, 0):]]
                 for topic, messages in self.heard.items()}
        self.begin = {topic: len(messages) for topic, messages in self.heard.items()}
        return heard

    def diagnostics(self):
        self.update()
        return [decode(*message) for message in self.heard["/diagnostics"]]

    def values(self):
        """The newest diagnostics of the node: {name: text}, with its level and summary."""
        statuses = [status for array in self.diagnostics() for status in array.status if status.hardware_id == "facet"]
        if not statuses:
            return {}
        return {"level": statuses[-1].level, "summary": statuses[-1].message,
                **{pair.key: pair.value for pair in statuses[-1].values}}


class NodeTest:
    def __init__(self, arguments, folder):
        self.arguments, self.folder, self.processes = arguments, folder, []
        self.environment = dict(os.environ, CYCLONEDDS_URI=CYCLONE, ROS_DOMAIN_ID=str(random.randrange(1, 100)))

    def start(self, command, log):
        with open(self.folder / log, "w") as out:
            process = subprocess.Popen([str(word) for word in command], env=self.environment, stdout=out,
                                       stderr=subprocess.STDOUT)
        self.processes.append(process)
        return process

    def stop(self, process):
        process.terminate()
        try:
            return process.wait(15)
        except subprocess.TimeoutExpired:
            process.kill()
            return process.wait()

    def run_facet(self, sequence, out):
        command = [self.arguments.program, "run", sequence, "--imu-history", "10", "--mesh-every", "1", "--quiet", "--out",
                   out]
        subprocess.run([str(word) for word in command], check=True)
        return Result(out)

    def start_node(self, name, parameters, suffix=""):
        """Queues are so long that a busy machine drops nothing."""
        parameters = {"max_waiting_pairs": 1000, "image_queue": 1000, "imu_queue": 10000, "reliable": "true", **parameters}
        command = [self.arguments.node, "--ros-args", "-r", f"__node:={name}", "-r", "imu:=/imu0"]
        for side, camera in (("left", "cam0"), ("right", "cam1")):
            command += ["-r", f"{side}/image_raw{suffix}:=/{camera}/image_raw{suffix}",
                        "-r", f"{side}/camera_info:=/{camera}/camera_info"]
        for key, value in parameters.items():
            command += ["-p", f"{key}:={value}"]
        ears = Ears(self, name)
        node = self.start(command, f"{name}.txt")
        wait_for(lambda: ears.values() or node.poll() is not None, f"{name} says nothing", 30)
        check(node.poll() is None, f"{name} has ended: {(self.folder / f'{name}.txt').read_text()}")
        return node, ears

    def play(self, ears, file, num_pairs, in_the_middle=None):
        """Until the node is done with all pairs. Returns its diagnostics."""
        before = int(ears.values()["done pairs"])
        player = self.start([self.arguments.peer, "play", file, "1"], "play.txt")
        if in_the_middle:
            time.sleep(SECONDS / 2)
            in_the_middle()
        wait_for(lambda: player.poll() is not None, "the player does not end", 60)
        check(player.returncode == 0, f"dds_peer play: {(self.folder / 'play.txt').read_text()}")
        wait_for(lambda: int(ears.values()["done pairs"]) >= before + num_pairs, "pairs are missing", 30)
        told = len(ears.diagnostics())
        wait_for(lambda: len(ears.diagnostics()) > told + 1, "no diagnostics any more", 10)
        return ears.values()

    def call(self, name, service):
        run = subprocess.run([self.arguments.peer, "call", f"/{name}/{service}"], env=self.environment,
                             capture_output=True, text=True, timeout=30)
        return run.stdout.strip() or run.stderr.strip()

    # ---- everything that is published, against the run

    def test_outputs(self):
        flight = Flight(self.arguments.sequence, SECONDS)
        file = flight.write(self.folder / "raw.records")
        result = self.run_facet(flight.write_folder(self.arguments.sequence, self.folder / "raw"), self.folder / "run")
        node, ears = self.start_node("facet", {"calibration": self.arguments.sequence})
        late = []
        values = self.play(ears, file, len(flight.frame_stamps), lambda: late.append(Ears(self, "facet", "_late")))
        check(int(values["images"]) == 2 * len(flight.frame_stamps), f"{values['images']} images came")
        check(int(values["IMU samples"]) == len(flight.imu_stamps), f"{values['IMU samples']} IMU samples came")
        for name in ("dropped pairs", "pairs without IMU", "lone images", "bad images", "dropped IMU samples",
                     "bad IMU samples", "dropped messages"):
            check(values[name] == "0", f"{name}: {values[name]}")
        check(values["status"] == "ok", f"status: {values['status']}")
        heard = ears.take()
        for difference in compare(heard, result, flight.imu_stamps):
            check(False, difference)
        check(len(heard["pose"]) > 100, "hardly a pose")
        check(heard["map"], "no part of the map")
        check(heard["path"] and len(heard["path"][-1].poses) > 50, "no path")
        for change in unseen_changes(heard, result, flight.imu_stamps):
            check(False, f"the comparison does not see {change}")
        self.test_late_listener(late[0], heard)
        self.test_codec(ears)
        check(self.stop(node) == 0, "the node ends with an error")
        self.stop(ears.process)
        print(f"{len(heard['pose'])} poses, {len(heard['odometry'])} states, {len(heard['mesh'])} meshes, "
              f"{len(heard['map'])} parts of the map; latency at most {values['largest latency [ms]']} ms")

    def test_late_listener(self, late, heard):
        """Who comes in the middle is told the path, the planes, the fixed transform, and all of the map."""
        messages = late.take()
        check(map_of(messages) == map_of(heard) and map_of(heard), "another map than who was there from the beginning")
        check(len(messages["path"][-1].poses) == len(heard["path"][-1].poses), "another path")
        check([t.child_frame_id for m in messages["/tf_static"] for t in m.transforms] == ["odom"], "no fixed transform")
        check(0 < len(messages["pose"]) < len(heard["pose"]), f"{len(messages['pose'])} poses of the past")
        self.stop(late.process)

    def test_best_effort(self):
        """As drivers send and the node listens where nothing else is said."""
        flight = Flight(self.arguments.sequence, SECONDS_DAMAGED, is_compressed=True)
        file = flight.write(self.folder / "best_effort.records")
        node, ears = self.start_node("facet_best_effort", {"calibration": self.arguments.sequence, "compressed": "true",
                                                           "reliable": "false"}, "/compressed")
        values = self.play(ears, file, len(flight.frame_stamps) * 4 // 5)
        check(int(values["images"]) > 1.6 * len(flight.frame_stamps), f"only {values['images']} images came")
        check(len(ears.take()["pose"]) > len(flight.frame_stamps) // 2, "hardly a pose")
        check(self.stop(node) == 0, "the node ends with an error")
        self.stop(ears.process)

    def test_codec(self, ears):
        """An independent codec with ROS 2's own definitions reads the same numbers."""
        if not shutil.which("node"):
            print("independent codec: not tried, there is no Node")
            return
        run = subprocess.run(["node", ROOT / "dds/test/decode.mjs", ears.file], capture_output=True, text=True)
        if run.returncode == SKIPPED:
            print(f"independent codec: not tried, {run.stdout.strip()}")
            return
        check(run.returncode == 0, f"independent codec: {run.stderr}")
        ears.update()
        topics = 0
        for line in run.stdout.splitlines():
            topic, kind, count, text = line.split(" ", 3)
            own_kind, data = ears.heard[ears.names[topic]][int(count) - 1]
            check(own_kind == kind, f"{topic}: {kind}")
            check(plain(decode(kind, data)) == plain(json.loads(text)), f"{topic}: other numbers by the independent codec")
            topics += 1
        check(topics == len(ears.names), f"only {topics} topics were read by the independent codec")
        print(f"independent codec: the same numbers in {topics} topics")

    # ---- damage, services, and data that come again

    def test_damage(self):
        def damage(camera, index, values):
            if (camera, index) == ("cam0", DAMAGED_LEFT):
                values["data"] = values["data"][:200]
            if (camera, index) == ("cam1", DAMAGED_RIGHT):
                values["data"] = b"no picture"

        sequence = self.arguments.sequence
        flight = Flight(sequence, SECONDS_DAMAGED, is_compressed=True, with_info=True, change=damage)
        file = flight.write(self.folder / "damaged.records")
        result = self.run_facet(flight.write_folder(sequence, self.folder / "good"), self.folder / "run_good")
        T_imu_left, T_left_right = mount(sequence / "mav0")
        node, ears = self.start_node("facet_info", {
            "compressed": "true", "T_imu_left": T_imu_left, "T_left_right": T_left_right,
            "imu_calibration": sequence / "mav0/imu0/sensor.yaml"}, "/compressed")
        check("camera_info" in ears.values()["summary"], f"summary: {ears.values()['summary']}")
        # One left image is damaged, and the first ones may come before the calibration of both cameras.
        num_pairs = len(flight.frame_stamps) - 4
        values = self.play(ears, file, num_pairs)
        check(values["bad images"] == "2", f"{values['bad images']} damaged images were counted")
        heard = ears.take()
        before = [m for m in heard["pose"] if stamp(m) < flight.frame_stamps[DAMAGED_LEFT]]
        errors = [np.linalg.norm(position(m) - result.pose(stamp(m))[0]) for m in before if stamp(m) in result.states]
        check(len(errors) > 30 and max(errors) < 0.02, f"before the damage {len(errors)} poses, {errors[-1:]} m off")
        check(all(stamp(m) != flight.frame_stamps[DAMAGED_LEFT] for m in heard["pose"]), "a pose without an image")
        check(len(heard["pose"]) > num_pairs - 15, f"{len(heard['pose'])} poses")
        # The first messages of the second time are what it is recognised by, and are not used.
        restarts = int(ears.values()["restarts"])
        values = self.play(ears, file, num_pairs - 5)
        check(int(values["restarts"]) == restarts + 1, f"{values['restarts']} restarts after {restarts}")
        again = ears.take()
        check(len(again["pose"]) > num_pairs - 15, f"the second time {len(again['pose'])} poses")
        check(any(m.action == 3 for m in again["map"]), "the old map is not removed")
        self.test_services(ears)
        check(self.stop(node) == 0, "the node ends with an error")

    def test_services(self, ears):
        for service, running in (("stop", False), ("start", True), ("reset", True), ("stop", False), ("start", True)):
            answer = self.call(ears.name, service)
            check(answer.startswith("true"), f"{service}: {answer}")
            told = len(ears.diagnostics())
            wait_for(lambda: len(ears.diagnostics()) > told + 1, "no diagnostics any more", 10)
            is_stopped = "stopped" in ears.values()["summary"]
            check(is_stopped != running, f"after {service}: {ears.values()['summary']}")

    def test_arguments(self):
        turned = "[0, 0, 0, 0, 0, 0, 1]"
        for words, code, text in (
                ([], 2, "~T_imu_left"),
                (["-p", "calibration:=no/such/file.yaml"], 3, "no/such/file.yaml"),
                (["-p", f"T_imu_left:={turned}", "-p", "colour:=red"], 2, "~colour is not a parameter"),
                (["-p", f"T_imu_left:={turned}", "-p", "imu_queue:=many"], 2, "~imu_queue is of the wrong type"),
                (["-p", f"T_imu_left:={turned}", "-p", "set:=[mesh.colour=red]"], 2, "mesh.colour"),
                (["-p", "T_imu_left:=[1, 2, 3]"], 2, "[x, y, z, qx, qy, qz, qw]"),
                (["--calibration", "x"], 2, "--calibration"),
                (["--help"], 0, "usage: facet-dds")):
            run = subprocess.run([str(self.arguments.node), *words], env=self.environment, capture_output=True, text=True,
                                 timeout=20)
            check(run.returncode == code and text in run.stderr + run.stdout, f"{words}: {run.returncode}, {run.stderr}")


def plain(value):
    """Messages as dictionaries, times as seconds and nanoseconds."""
    if isinstance(value, dict):
        if set(value) == {"sec", "nsec"} or set(value) == {"sec", "nanosec"}:
            return list(value.values())
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, bytes)):
        return [plain(inner) for inner in value]
    if hasattr(value, "to_nsec"):
        return [value.secs, value.nsecs]
    return {key: plain(inner) for key, inner in vars(value).items()} if hasattr(value, "__dict__") else value


def map_of(messages):
    """{id: number of corners} of the parts that are shown at the end."""
    parts = {marker.id: len(marker.points) for marker in messages["map"]}
    return {number: corners for number, corners in parts.items() if corners > 0}


def position(message):
    p = message.pose.pose.position
    return np.array([p.x, p.y, p.z])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument("--peer", type=Path, required=True)
    parser.add_argument("--program", type=Path, required=True)
    data = Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")
    parser.add_argument("--sequence", type=Path, default=data / "euroc_mh01_handheld")
    parser.add_argument("--keep", type=Path, help="a folder for what is written, which is then kept")
    arguments = parser.parse_args()
    if not arguments.sequence.exists():
        skip(f"no recorded data \"{arguments.sequence.name}\": set FACET_DATA_DIR to the folder that holds it")
    folder = arguments.keep or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    test = NodeTest(arguments, folder)
    try:
        test.test_arguments()
        test.test_outputs()
        test.test_damage()
        test.test_best_effort()
    finally:
        for process in test.processes:
            if process.poll() is None:
                test.stop(process)
        if not arguments.keep:
            shutil.rmtree(folder)
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
