"""A roscore on loopback, a node, a player and ears: what the tests of the node share."""

import os
import socket
import subprocess
import threading
import time
import xmlrpc.client

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

OUTPUTS = {"odometry": Odometry, "pose": PoseWithCovarianceStamped, "path": Path, "mesh": Marker, "map": Marker,
           "points": PointCloud2, "planes": MarkerArray}
GLOBALS = {"/tf": TFMessage, "/tf_static": TFMessage, "/diagnostics": DiagnosticArray}
BUFFER = 1 << 24  # bytes; rospy drops nothing as long as it keeps up


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Session:
    """with Session(folder) as session: the core; `start` and `play` are processes that end with it."""

    def __init__(self, folder):
        self.folder = folder
        self.uri = f"http://127.0.0.1:{free_port()}"
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri, ROS_IP="127.0.0.1", ROS_HOME=str(folder),
                                ROS_LOG_DIR=str(folder / "log"))
        os.environ.update(self.environment)
        self.processes = []

    def __enter__(self):
        self.start(["roscore", "-p", self.uri.rsplit(":", 1)[1]], "roscore.txt")
        self.wait_for(self.has_core, "roscore does not come up", 30)
        return self

    def __exit__(self, *unused):
        rospy.signal_shutdown("the test is over")
        for process in reversed(self.processes):
            self.stop(process)

    def has_core(self):
        try:
            return xmlrpc.client.ServerProxy(self.uri).getPid("/test")[0] == 1
        except OSError:
            return False

    def start(self, command, log):
        with open(self.folder / log, "w") as out:
            process = subprocess.Popen(command, env=self.environment, stdout=out, stderr=subprocess.STDOUT)
        self.processes.append(process)
        return process

    def stop(self, process):
        if process.poll() is None:
            process.send_signal(2)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        return process.returncode

    def play(self, bag, *options):
        return self.start(["rosbag", "play", "--clock", "--quiet", "--wait-for-subscribers", *options, str(bag)],
                          "play.txt")

    @staticmethod
    def wait_for(condition, text, seconds):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"{text} within {seconds} s")
            time.sleep(0.05)


class Ears:
    """What a node publishes, by topic, in the order in which it came."""

    def __init__(self, node):
        self.heard = {name: [] for name in [*OUTPUTS, *GLOBALS]}
        self.lock = threading.Lock()
        types = [(name, f"{node}/{name}", kind) for name, kind in OUTPUTS.items()]
        types += [(name, name, kind) for name, kind in GLOBALS.items()]
        self.subscribers = [rospy.Subscriber(topic, kind, self.hear, name, None, BUFFER, True)
                            for name, topic, kind in types]

    def hear(self, message, name):
        with self.lock:
            self.heard[name].append(message)

    def take(self):
        with self.lock:
            heard, self.heard = self.heard, {name: [] for name in self.heard}
            return heard

    def values(self):
        """The newest diagnostics of the node: {name: text}, with its level and summary."""
        with self.lock:
            statuses = [status for array in self.heard["/diagnostics"] for status in array.status
                        if status.hardware_id == "facet"]
        if not statuses:
            return {}
        return {"level": statuses[-1].level, "summary": statuses[-1].message,
                **{pair.key: pair.value for pair in statuses[-1].values}}

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()
