#!/bin/sh
# scripts/format.sh: formats every C++ file in place. --check: changes nothing, lists what would change and fails.
set -eu
cd "$(dirname "$0")/.."
files=$(find src apps bench studies python ros1 ros2 dds examples -name '*.h' -o -name '*.cpp' | sort)
if [ "${1:-}" != --check ]; then
  echo "$files" | xargs clang-format -i
  exit 0
fi
unformatted=""
for file in $files; do
  clang-format "$file" | cmp -s - "$file" || unformatted="$unformatted $file"
done
if [ -n "$unformatted" ]; then
  echo "format: run 'make format'; it would change:" >&2
  printf '  %s\n' $unformatted >&2
  exit 1
fi
echo "format: $(echo "$files" | wc -l) files, all formatted"
