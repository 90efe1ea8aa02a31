#!/usr/bin/env bash
# Builds every mesh given with both rules, checks the blobs, traces a million rays (camera, chords, vertices, edges)
# through each on one thread, and compares every answer with the list's, byte for byte. Prints a Markdown table.
#
#   benches/meshes.sh ../shared/meshes/*.obj [spd:balls ..]
#
# RAYS=100000 takes fewer rays. The list is slow: a million rays through 70,000 triangles take some ten minutes a core.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cargo build --quiet --release --locked --features cli --manifest-path "$root/Cargo.toml"
flashray=${CARGO_TARGET_DIR:-$root/target}/release/flashray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rays=${RAYS:-1000000}

# The number behind a key of a flat JSON object.
number() { grep -o "\"$2\":[0-9.e+-]*" <<<"$1" | head -n 1 | cut -d: -f2; }

echo "| input | rule | primitives | nodes | depth | bytes/primitive | SAH cost | Mrays/s | over list | $rays answers |"
echo "|---|---|---|---|---|---|---|---|---|---|"
for input in "$@"; do
  name=$(basename "$input" .obj)
  "$flashray" build "$input" -o "$work/list.fray" --structure list >/dev/null
  "$flashray" rays "$work/list.fray" -o "$work/rays" --count "$rays" >/dev/null
  "$flashray" rays "$work/list.fray" -o "$work/few" --count $((rays / 200 + 1000)) >/dev/null
  slow=$(number "$("$flashray" trace "$work/list.fray" --rays "$work/few" -o "$work/few.hits" --threads 1 --json)" mrays_per_second)
  "$flashray" trace "$work/list.fray" --rays "$work/rays" -o "$work/list.hits" >/dev/null
  for rule in seed sah; do
    "$flashray" build "$input" -o "$work/bvh.fray" --rule "$rule" >/dev/null
    "$flashray" check "$work/bvh.fray" >/dev/null
    info=$("$flashray" info "$work/bvh.fray" --json)
    traced=$("$flashray" trace "$work/bvh.fray" --rays "$work/rays" -o "$work/bvh.hits" --threads 1 --json)
    same=$(cmp -s "$work/list.hits" "$work/bvh.hits" && echo equal || echo DIFFERENT)
    fast=$(number "$traced" mrays_per_second)
    printf '| %s | %s | %s | %s | %s | %.1f | %.1f | %.2f | %.0f | %s |\n' "$name" "$rule" \
      "$(number "$info" primitives)" "$(number "$info" nodes)" "$(number "$info" depth)" \
      "$(number "$info" bytes_per_primitive)" "$(number "$info" sah_cost)" "$fast" \
      "$(awk -v a="$fast" -v b="$slow" 'BEGIN { print a / b }')" "$same"
  done
done
