#!/usr/bin/python3
"""The node for ROS 1 against `facet run`: a core on loopback, `rosbag play` of eight seconds of a recording.

  node_test.py --node FACET_NODE --program FACET [--sequence FOLDER] [--keep FOLDER]

SEQUENCE is in the ASL layout; by default $FACET_DATA_DIR or ../shared/data, euroc_mh01_handheld. Exit code 77 where ROS,
the node or the recording is missing. First run: raw images, calibration from files, all that is published is compared
with the run; then one number of what was heard is changed, and the comparison must say so. Second run: compressed
images, CameraInfo, two damaged images; the node goes on, says what is wrong, and the poses differ from the run's. Then
services, and the same bag again, which begins anew.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SKIPPED = 77
sys.path.append(str(ROOT / "src/facet/testing/robot"))
SECONDS, SECONDS_DAMAGED = 8, 4
DAMAGED_LEFT, DAMAGED_RIGHT = 60, 70  # numbers of pairs


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


try:
    import numpy as np
    import rospy
    from rosgraph.masterapi import Master
    from std_srvs.srv import Trigger

    import bags
    from asl_recording import mount
    from compare_messages import Result, compare, stamp, unseen_changes
    from ros_session import Ears, Session
except ImportError as missing:
    skip(f"{missing} (scripts/setup.sh ros1)")

failures = []


def check(condition, text):
    if not condition:
        print("FAILED:", text)
        failures.append(text)


class NodeTest:
    def __init__(self, arguments, session):
        self.arguments, self.session = arguments, session
        self.master = Master("/test")

    def run_facet(self, bag, out):
        command = [self.arguments.program, "run", bag, "--calibration", self.arguments.sequence, "--imu-history", "10",
                   "--mesh-every", "1", "--quiet", "--out", out]
        subprocess.run([str(word) for word in command], check=True)
        return Result(out)

    def start_node(self, name, parameters):
        """Queues are so long that a busy machine drops nothing."""
        parameters = {"max_waiting_pairs": 1000, "image_queue": 1000, "imu_queue": 10000, **parameters}
        for key, value in parameters.items():
            self.master.setParam(f"/{name}/{key}", value)
        command = [self.arguments.node, f"__name:={name}", "imu:=/imu0"]
        for side, camera in (("left", "cam0"), ("right", "cam1")):
            command += [f"{side}/{what}:=/{camera}/{what}"
                        for what in ("image_raw", "image_raw/compressed", "camera_info")]
        ears = Ears("/" + name)
        node = self.session.start([str(word) for word in command], f"{name}.txt")
        self.session.wait_for(lambda: ears.values() or node.poll() is not None, f"{name} says nothing", 20)
        check(node.poll() is None, f"{name} has ended: {(self.session.folder / f'{name}.txt').read_text()}")
        return node, ears

    def play(self, ears, bag, num_pairs):
        """Until the node is done with all pairs. Returns its diagnostics."""
        before = int(ears.values()["done pairs"])
        player = self.session.play(bag)
        self.session.wait_for(lambda: player.poll() is not None, "rosbag play does not end", 60)
        check(player.returncode == 0, f"rosbag play: {(self.session.folder / 'play.txt').read_text()}")
        self.session.wait_for(lambda: int(ears.values()["done pairs"]) >= before + num_pairs, "pairs are missing", 20)
        told = len(ears.heard["/diagnostics"])
        self.session.wait_for(lambda: len(ears.heard["/diagnostics"]) > told, "no diagnostics any more", 10)
        return ears.values()

    def call(self, name, service):
        rospy.wait_for_service(f"/{name}/{service}", 10)
        return rospy.ServiceProxy(f"/{name}/{service}", Trigger)()

    # ---- everything that is published, against the run

    def test_outputs(self):
        bag = self.session.folder / "raw.bag"
        frame_stamps, imu_stamps = bags.write_bag(self.arguments.sequence, bag, SECONDS)
        result = self.run_facet(bag, self.session.folder / "run")
        node, ears = self.start_node("facet", {"calibration": str(self.arguments.sequence)})
        values = self.play(ears, bag, len(frame_stamps))
        check(int(values["images"]) == 2 * len(frame_stamps), f"{values['images']} images came")
        check(int(values["IMU samples"]) == len(imu_stamps), f"{values['IMU samples']} IMU samples came")
        for name in ("dropped pairs", "pairs without IMU", "lone images", "bad images", "dropped IMU samples", "bad IMU samples"):
            check(values[name] == "0", f"{name}: {values[name]}")
        check(values["status"] == "ok", f"status: {values['status']}")
        heard = ears.take()
        for difference in compare(heard, result, imu_stamps):
            check(False, difference)
        check(len(heard["pose"]) > 100, "hardly a pose")
        check(heard["map"], "no part of the map")
        check(heard["path"] and len(heard["path"][-1].poses) > 50, "no path")
        for change in unseen_changes(heard, result, imu_stamps):
            check(False, f"the comparison does not see {change}")
        ears.close()
        check(self.session.stop(node) == 0, "the node ends with an error")
        print(f"{len(heard['pose'])} poses, {len(heard['odometry'])} states, {len(heard['mesh'])} meshes, "
              f"{len(heard['map'])} parts of the map; latency at most {values['largest latency [ms]']} ms")

    # ---- damage, services, and a bag that is played again

    def test_damage(self):
        def damage(camera, index, message):
            if (camera, index) == ("cam0", DAMAGED_LEFT):
                message.data = message.data[:200]
            if (camera, index) == ("cam1", DAMAGED_RIGHT):
                message.data = b"no picture"

        files = {"make_image": bags.compressed_image, "suffix": "/compressed"}
        good, damaged = self.session.folder / "good.bag", self.session.folder / "damaged.bag"
        bags.write_bag(self.arguments.sequence, good, SECONDS_DAMAGED, **files)
        frame_stamps, imu_stamps = bags.write_bag(self.arguments.sequence, damaged, SECONDS_DAMAGED, change=damage,
                                                  with_info=True, **files)
        result = self.run_facet(good, self.session.folder / "run_good")
        T_imu_left, T_left_right = mount(self.arguments.sequence / "mav0")
        _, ears = self.start_node("facet_info", {
            "compressed": True, "T_imu_left": T_imu_left, "T_left_right": T_left_right,
            "imu_calibration": str(self.arguments.sequence / "mav0/imu0/sensor.yaml")})
        check("camera_info" in ears.values()["summary"], f"summary: {ears.values()['summary']}")
        # One left image is damaged, and the first ones may come before the calibration of both cameras.
        num_pairs = len(frame_stamps) - 4
        values = self.play(ears, damaged, num_pairs)
        check(values["bad images"] == "2", f"{values['bad images']} damaged images were counted")
        heard = ears.take()
        before = [m for m in heard["pose"] if stamp(m) < frame_stamps[DAMAGED_LEFT]]
        errors = [np.linalg.norm(np.array([m.pose.pose.position.x, m.pose.pose.position.y, m.pose.pose.position.z]) -
                                 result.pose(stamp(m))[0]) for m in before]
        check(len(errors) > 30 and max(errors) < 0.02, f"before the damage {len(errors)} poses, up to {max(errors)} m off")
        check(len(heard["pose"]) > len(before) + 10, "the node does not go on after the damage")
        check(compare(heard, result, imu_stamps), "the comparison does not see damaged images")
        said = (self.session.folder / "facet_info.txt").read_text()
        check("left image: " in said and "right image: " in said, f"the damage is not told: {said}")
        self.test_services(ears, damaged, num_pairs)
        ears.close()

    def test_services(self, ears, bag, num_pairs):
        check(not self.call("facet_info", "start").success, "it starts twice")
        check(self.call("facet_info", "stop").success, "it does not stop")
        check(self.call("facet_info", "start").success, "it does not start")
        check(self.call("facet_info", "reset").success, "it does not reset")
        ears.take()
        self.session.wait_for(lambda: ears.values().get("restarts") == "1", "no diagnostics after the reset", 10)
        self.play(ears, bag, num_pairs)
        self.session.wait_for(lambda: len(ears.heard["pose"]) > 50, "no poses after a reset", 10)
        self.play(ears, bag, num_pairs - 3)
        check(int(ears.values()["restarts"]) == 2, f"restarts: {ears.values()['restarts']}")
        check("gone back" in (self.session.folder / "facet_info.txt").read_text(), "the restart is not told")

    # ---- wrong parameters

    def test_parameters(self):
        for name, parameters, code, text in (
                ("wrong_1", {"calibration": "/nowhere/camchain.yaml"}, 3, "~calibration"),
                ("wrong_2", {"colour": "red"}, 2, "~colour is not a parameter"),
                ("wrong_3", {}, 2, "~T_imu_left"),
                ("wrong_4", {"T_imu_left": [0, 0, 0, 0, 0, 0, 1], "set": ["mesh.colour=red"]}, 2, "mesh.colour"),
                ("wrong_5", {"T_imu_left": [1, 2, 3]}, 2, "[x, y, z, qx, qy, qz, qw]")):
            for key, value in parameters.items():
                self.master.setParam(f"/{name}/{key}", value)
            run = subprocess.run([str(self.arguments.node), f"__name:={name}"], env=self.session.environment,
                                 capture_output=True, text=True, timeout=20)
            check(run.returncode == code and text in run.stderr, f"{parameters}: {run.returncode}, {run.stderr}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument("--program", type=Path, required=True)
    data = Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")
    parser.add_argument("--sequence", type=Path, default=data / "euroc_mh01_handheld")
    parser.add_argument("--keep", type=Path, help="a folder for what is written, which is then kept")
    arguments = parser.parse_args()
    if not arguments.node.exists():
        skip(f"no {arguments.node}: it is built where roscpp is (scripts/setup.sh ros1)")
    if not arguments.sequence.exists():
        skip(f"no recorded data \"{arguments.sequence.name}\": set FACET_DATA_DIR to the folder that holds it")
    if not shutil.which("roscore") or not shutil.which("rosbag"):
        skip("no roscore or rosbag (scripts/setup.sh ros1)")
    folder = arguments.keep or Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with Session(folder) as session:
            Master("/test").setParam("/use_sim_time", True)
            rospy.init_node("node_test", disable_signals=True, anonymous=True)
            test = NodeTest(arguments, session)
            test.test_parameters()
            test.test_outputs()
            test.test_damage()
    finally:
        if not arguments.keep:
            shutil.rmtree(folder)
    print(f"{len(failures)} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
