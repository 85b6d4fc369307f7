#!/bin/sh
# scripts/demo.sh [SEQUENCE]: runs and evaluates one sequence and says where everything lies.
# Without a sequence it first simulates a flight of 20 s through a furnished room; that is done once.
set -eu
cd "$(dirname "$0")/.."
sequence=${1:-}
if [ -z "$sequence" ]; then
  sequence="runs/demo-room"
  if [ ! -f "$sequence/simulation.txt" ]; then
    echo "demo: simulating a 20 s flight through a room (once; about a minute)"
    if ! build/facet simulate --out "$sequence" --scene room --trajectory gentle --duration 20 --seed 1 \
        --set image.rays_per_pixel=3; then
      cat >&2 <<TEXT
demo: without the simulator, give a recording in the EuRoC layout (a folder that holds mav0/):
  make demo SEQUENCE=path/to/MH_01_easy
EuRoC sequences: https://projects.asl.ethz.ch/datasets/doku.php?id=kmavvisualinertialdatasets (download "ASL format", unzip)
Your own recording: the layout is described in README.md.
TEXT
      exit 3
    fi
  fi
fi

out="runs/demo"
build/facet run "$sequence" --out "$out"
truth="$sequence/mav0"
[ -d "$truth" ] || truth="$sequence"
echo
if [ -f "$truth/state_groundtruth_estimate0/data.csv" ]; then
  build/facet evaluate "$out" --truth "$sequence" >"$out/evaluation.txt"
  echo "demo: how good the run is, against the exact truth (all figures: $out/evaluation.txt)"
else
  echo "demo: the sequence has no ground truth, so there is nothing to compare with"
fi
# Debian's Python: another one that is first on the PATH need not have numpy.
python=python3
[ ! -x /usr/bin/python3 ] || python=/usr/bin/python3
"$python" scripts/run_figures.py "$out"
echo
if "$python" -c 'import numpy, matplotlib' 2>/dev/null && "$python" scripts/run_picture.py "$out" --sequence "$sequence"; then
  picture="$out/picture.png"
  echo "demo: LOOK AT $picture: the mesh coloured by plane, beside what the camera saw"
  if [ -t 1 ] && [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ] && command -v xdg-open >/dev/null; then
    xdg-open "$picture" >/dev/null 2>&1 &
  fi
else
  build/facet picture "$out" "$out/picture.png"
  echo "demo: LOOK AT $out/picture.png: the mesh coloured by plane (what the camera saw: only with python3-matplotlib)"
fi
echo "demo: in the browser, to turn and measure: build/facet view $out"
echo "demo: the mesh itself, for MeshLab or Blender: $out/map.ply; what each file holds: docs/tutorial.md"
