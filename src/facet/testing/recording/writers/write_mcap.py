#!/usr/bin/python3
"""write_mcap.py SEQUENCE OUT.mcap DURATION [CHUNK_SIZE]: an MCAP file by npm's @mcap/core, fed with CDR from here.

The package is looked for in $NODE_PATH (npm install @mcap/core). Exit code 77 where it or node is missing.
"""

import base64
import json
import shutil
import subprocess
import sys
from pathlib import Path

from asl_folder import events
from write_db3 import message


def main():
    sequence, out, duration_s = sys.argv[1], sys.argv[2], float(sys.argv[3])
    if shutil.which("node") is None:
        print("no node")
        sys.exit(77)
    writer = subprocess.Popen(["node", Path(__file__).with_name("write_mcap.mjs"), out, *sys.argv[4:]],
                              stdin=subprocess.PIPE, text=True)
    try:
        for stamp, sensor, what in events(sequence, duration_s):
            topic, kind, data = message(stamp, sensor, what)
            line = {"topic": topic, "type": kind, "stamp": str(stamp), "data": base64.b64encode(data).decode()}
            writer.stdin.write(json.dumps(line) + "\n")
        writer.stdin.close()
    except BrokenPipeError:
        pass
    sys.exit(writer.wait())


if __name__ == "__main__":
    main()
