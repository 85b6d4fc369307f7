#!/bin/sh
# scripts/demo.sh [SEQUENCE]: runs and evaluates one sequence and says where everything lies.
set -eu
cd "$(dirname "$0")/.."
sequence=${1:-}
data=${FACET_DATA_DIR:-../shared/data}
if [ -z "$sequence" ]; then
  sequence="$data/euroc_mh01_handheld"
  if [ ! -d "$sequence/mav0" ]; then
    cat >&2 <<TEXT
demo: no sequence found. Give a folder in the EuRoC layout (it holds mav0/):
  make demo SEQUENCE=path/to/MH_01_easy
EuRoC sequences: https://projects.asl.ethz.ch/datasets/doku.php?id=kmavvisualinertialdatasets (download "ASL format", unzip)
Your own recording: the layout is described in README.md.
TEXT
    exit 3
  fi
fi

out="runs/demo"
build/facet run "$sequence" --out "$out"
truth="$sequence/mav0"
[ -d "$truth" ] || truth="$sequence"
if [ -f "$truth/state_groundtruth_estimate0/data.csv" ]; then
  build/facet evaluate "$out" --truth "$sequence"
  if /usr/bin/python3 -c 'import numpy, matplotlib' 2>/dev/null; then
    /usr/bin/python3 scripts/plot_run.py "$out" --truth "$sequence" --out "$out/trajectory.png"
  fi
else
  echo "demo: the sequence has no ground truth, so there is nothing to compare with"
fi
echo
echo "demo: results in $out:"
ls -1 "$out" | sed 's/^/  /'
