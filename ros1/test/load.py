#!/usr/bin/python3
"""Does the node lose messages, and what does it cost? A recording of raw images is played again and again.

  load.py --node FACET_NODE --program FACET [--sequence FOLDER] [--seconds S] [--passes N] [--listen]

With --listen somebody subscribes to everything. Default parameters and queues. After each pass the node begins anew,
because the stamps go back. Prints the messages that were sent and that came, what the node has dropped, and its
processor time per pass beside that of `facet run` on the same bag, as fast as it can and at recorded speed, which are
run in between because the machine is not the same all the time. Needs ROS (scripts/setup.sh ros1).
"""

import argparse
import json
import os
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import rospy
from rosgraph.masterapi import Master

import bags
from ros_session import Ears, Session

ROOT = Path(__file__).resolve().parents[2]
EVERY = 3  # passes of the node between two runs of the program
LOSSES = ("dropped pairs", "lone images", "repeated images", "bad images", "dropped IMU samples", "bad IMU samples",
          "pairs without IMU")


def cpu_of(process):
    """Seconds of processor time, of all its threads."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def cpu_of_run(arguments, bag, folder, *options):
    """The program's own figure."""
    command = [arguments.program, "run", bag, "--calibration", arguments.sequence, "--imu-history", "10", "--quiet",
               "--out", folder / "run", *options]
    subprocess.run([str(word) for word in command], check=True)
    return json.loads((folder / "run" / "summary.json").read_text())["cpu_s"]


def play(session, bag, node):
    """Returns the node's processor time."""
    before = cpu_of(node)
    player = session.play(bag)
    while player.poll() is None:
        time.sleep(0.2)
    if player.returncode != 0:
        raise RuntimeError(f"rosbag play: {(session.folder / 'play.txt').read_text()}")
    return cpu_of(node) - before


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--node", type=Path, required=True)
    parser.add_argument("--program", type=Path, required=True)
    data = Path(os.environ.get("FACET_DATA_DIR") or ROOT.parent / "shared" / "data")
    parser.add_argument("--sequence", type=Path, default=data / "euroc_mh01_handheld")
    parser.add_argument("--seconds", type=float, default=16)
    parser.add_argument("--passes", type=int, default=38)
    parser.add_argument("--listen", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name, Session(Path(name)) as session:
        bag = session.folder / "raw.bag"
        frame_stamps, imu_stamps = bags.write_bag(arguments.sequence, bag, arguments.seconds)
        Master("/load").setParam("/use_sim_time", True)
        Master("/load").setParam("/facet/calibration", str(arguments.sequence))
        rospy.init_node("load", disable_signals=True, anonymous=True)
        ears = Ears("/facet") if arguments.listen else Ears("/nobody")
        command = [arguments.node, "__name:=facet", "imu:=/imu0", "left/image_raw:=/cam0/image_raw",
                   "right/image_raw:=/cam1/image_raw"]
        node = session.start([str(word) for word in command], "facet.txt")
        session.wait_for(ears.values, "the node says nothing", 20)
        begin, node_s, fast_s, slow_s = time.monotonic(), [], [], []
        for number in range(arguments.passes):
            node_s.append(play(session, bag, node))
            if number % EVERY == 0:
                fast_s.append(cpu_of_run(arguments, bag, session.folder))
                slow_s.append(cpu_of_run(arguments, bag, session.folder, "--realtime"))
        duration_s = time.monotonic() - begin
        time.sleep(2.5)  # the newest diagnostics
        values = ears.values()
        session.stop(node)
        sent = arguments.passes * 2 * len(frame_stamps), arguments.passes * len(imu_stamps)
        print(f"{duration_s:.0f} s, {arguments.passes} passes; images sent {sent[0]}, came {values['images']}; "
              f"IMU samples sent {sent[1]}, came {values['IMU samples']}")
        print("; ".join(f"{loss}: {values[loss]}" for loss in LOSSES))
        print(f"restarts: {values['restarts']}; largest latency: {values['largest latency [ms]']} ms")
        cpu_s, fast_s, slow_s = map(statistics.median, (node_s, fast_s, slow_s))
        print(f"processor time per pass, medians: node {cpu_s:.2f} s, facet run {fast_s:.2f} s "
              f"(node {cpu_s / fast_s:.2f} x), at recorded speed {slow_s:.2f} s (node {cpu_s / slow_s:.2f} x)")
        return 0 if (values["images"], values["IMU samples"]) == tuple(map(str, sent)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
