#!/bin/sh
# scripts/bench.sh [DATA]: the kernels one by one, then the end-to-end table over every sequence found.
set -eu
cd "$(dirname "$0")/.."
data=${1:-${FACET_DATA_DIR:-../shared/data}}
mkdir -p bench-out
for bench in build/bench/*_bench; do
  [ -x "$bench" ] || continue
  echo "== $bench"
  taskset -c 0 "$bench" --benchmark_min_time=0.2 \
    --benchmark_out="bench-out/$(basename "$bench").json" --benchmark_out_format=json
done
echo "== end to end"
/usr/bin/python3 scripts/run_all.py "$data" --json bench-out/end_to_end.json
