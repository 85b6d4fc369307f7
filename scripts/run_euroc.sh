#!/bin/sh
# scripts/run_euroc.sh FOLDER [options of facet compare]: the paper's Tables I and II for every EuRoC
# sequence below FOLDER (folders MH_01_easy ... V2_03_difficult, each with mav0/ inside).
#   scripts/run_euroc.sh ~/EuRoC --jobs 4 --starts 9
# Results go to runs/euroc (or --out DIR); a study that was interrupted goes on where it stopped.
set -eu
if [ $# -lt 1 ]; then
  sed -n '2,5s/^# //p' "$0" >&2
  exit 2
fi
folder=$1
shift
root=$(cd "$(dirname "$0")/.." && pwd)
program=${FACET:-$root/build/facet}
if [ ! -x "$program" ]; then
  echo "run_euroc: $program: no such program; run 'make build'" >&2
  exit 2
fi

found=""
set -- "$@" --
for name in MH_01_easy MH_02_easy MH_03_medium MH_04_difficult MH_05_difficult \
  V1_01_easy V1_02_medium V1_03_difficult V2_01_easy V2_02_medium V2_03_difficult; do
  # The download puts them directly into the folder or into one folder per place; unpacking adds a
  # folder at times.
  packed=""
  for candidate in "$folder/$name" "$folder"/*/"$name" "$folder/$name/$name" "$folder"/*/"$name/$name"; do
    if [ -d "$candidate/mav0" ]; then
      found="$found $name"
      packed=""
      set -- "$@" "$candidate"
      break
    fi
    [ ! -d "$candidate" ] || packed=$candidate
  done
  [ -z "$packed" ] || echo "run_euroc: $packed: no mav0/ in it (not unpacked?), left out" >&2
done
if [ -z "$found" ]; then
  echo "run_euroc: $folder: no EuRoC sequence (MH_01_easy/mav0 ...) in it" >&2
  exit 3
fi
echo "run_euroc: sequences:$found"
case " $* " in
  *" --out "* | *" --out="*) ;;
  *) set -- --out "$root/runs/euroc" "$@" ;;
esac
exec "$program" compare "$@"
