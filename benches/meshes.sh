#!/usr/bin/env bash
# Builds every input given as every structure with both rules, checks the blobs, traces a million rays through each on
# one thread, and compares every answer with the list's, byte for byte. Half of the rays come from a camera, between
# points around the scene, through vertices and through edges; half are hostile: along the lines and in the planes of
# every structure's cells, from their corners, from inside and from very far away, with odd intervals. The speed is that
# of the first half. Any hit is asked for a tenth as many rays of either sort, since the list is slow there as well, and
# compared too. Prints a Markdown table; exits with 1 if an answer is not the list's.
#
#   benches/meshes.sh ../shared/meshes/*.obj [spd:balls ..]
#
# RAYS=100000 takes fewer rays, HOSTILE=20000 so many hostile ones among them; STRUCTURES="bvh grid" fewer structures.
# The list is slow: a million rays through 70,000 triangles take some five minutes a core.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cargo build --quiet --release --locked --features cli --manifest-path "$root/Cargo.toml"
flashray=${CARGO_TARGET_DIR:-$root/target}/release/flashray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
rays=${RAYS:-1000000}
hostile=${HOSTILE:-$((rays / 2))}
fair=$((rays - hostile))
all=$("$flashray" build --help | sed -n '/--structure/,/possible/s/.*possible values: \(.*\)\].*/\1/p' | tr -d , | head -n 1)
structures=${STRUCTURES:-${all#list }}
bad=0

# The number behind a key of a flat JSON object.
number() { grep -o "\"$2\":[0-9.e+-]*" <<<"$1" | head -n 1 | cut -d: -f2; }

echo "| input | structure | rule | primitives | nodes | cells | depth | references/primitive | bytes/primitive | cost | Mrays/s | over list | $rays answers |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
for input in "$@"; do
  name=$(basename "$input" .obj)
  "$flashray" build "$input" -o "$work/list.fray" --structure list >/dev/null
  blobs=()
  for structure in $structures; do
    for rule in seed sah; do
      "$flashray" build "$input" -o "$work/$structure-$rule.fray" --structure "$structure" --rule "$rule" >/dev/null
      "$flashray" check "$work/$structure-$rule.fray" >/dev/null
      blobs+=("$work/$structure-$rule.fray")
    done
  done
  "$flashray" rays "$work/list.fray" -o "$work/fair" --count $fair >/dev/null
  "$flashray" rays "$work/list.fray" "${blobs[@]}" -o "$work/hostile" --hostile --count $hostile >/dev/null
  "$flashray" rays "$work/list.fray" -o "$work/few" --count $((rays / 200 + 1000)) >/dev/null
  slow=$(number "$("$flashray" trace "$work/list.fray" --rays "$work/few" -o "$work/few.hits" --threads 1 --json)" mrays_per_second)
  "$flashray" rays "$work/list.fray" -o "$work/any-fair" --count $((fair / 10)) --seed 2 >/dev/null
  "$flashray" rays "$work/list.fray" "${blobs[@]}" -o "$work/any-hostile" --hostile --count $((hostile / 10)) --seed 2 >/dev/null
  for kind in fair hostile; do
    "$flashray" trace "$work/list.fray" --rays "$work/$kind" -o "$work/list.$kind" >/dev/null
    "$flashray" trace "$work/list.fray" --rays "$work/any-$kind" -o "$work/list.any-$kind" --any >/dev/null
  done
  for blob in "${blobs[@]}"; do
    info=$("$flashray" info "$blob" --json)
    traced=$("$flashray" trace "$blob" --rays "$work/fair" -o "$work/fair.hits" --threads 1 --json)
    "$flashray" trace "$blob" --rays "$work/hostile" -o "$work/hostile.hits" >/dev/null
    same=equal
    cmp -s "$work/list.fair" "$work/fair.hits" || same=DIFFERENT
    cmp -s "$work/list.hostile" "$work/hostile.hits" || same=DIFFERENT
    for kind in any-fair any-hostile; do
      "$flashray" trace "$blob" --rays "$work/$kind" -o "$work/any.hits" --any >/dev/null
      cmp -s "$work/list.$kind" "$work/any.hits" || same=DIFFERENT
    done
    [ $same = equal ] || bad=1
    fast=$(number "$traced" mrays_per_second)
    pair=$(basename "$blob" .fray)
    prims=$(number "$info" primitives)
    printf '| %s | %s | %s | %s | %s | %s | %s | %.2f | %.1f | %.1f | %.2f | %.0f | %s |\n' "$name" "${pair%-*}" "${pair#*-}" \
      "$prims" "$(number "$info" nodes)" "$(number "$info" leaves)" "$(number "$info" depth)" \
      "$(awk -v a="$(number "$info" references)" -v b="$prims" 'BEGIN { print a / b }')" \
      "$(number "$info" bytes_per_primitive)" "$(number "$info" sah_cost)" "$fast" \
      "$(awk -v a="$fast" -v b="$slow" 'BEGIN { print a / b }')" "$same"
  done
done
exit $bad
