#!/usr/bin/env bash
# Draws the pictures of docs/structures.md anew and fills its tables: `flashray compare` on a small teapot for the
# pictures, and on the scenes given, or on procedural ones and two meshes, for the numbers.
#
#   benches/structures.sh [IN ..]
#
# ROUNDS=1 and RAYS=1000 make it quick; PICTURES=only leaves the tables as they are.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
cargo build --quiet --release --locked --features cli --manifest-path "$root/Cargo.toml"
flashray=${CARGO_TARGET_DIR:-$root/target}/release/flashray
page=$root/docs/structures.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$flashray" compare spd:teapot:3 --slice y --at 0.49 --rays 16 --rounds 1 -o "$work" >/dev/null
mkdir -p "$root/docs/img/slices"
cp "$work"/*.svg "$root/docs/img/slices/"
[ "${PICTURES:-}" = only ] && exit

if [ $# -eq 0 ]; then
  cd "$root"
  set -- spd:teapot spd:balls spd:lattice spd:shells:3
  # Meshes too large for the repository.
  for mesh in ../shared/meshes/{bunny,kitchen}.obj; do
    [ ! -f $mesh ] || set -- "$@" $mesh
  done
fi
# What the columns mean, once: it is the paragraph that begins with "bytes: ".
for input in "$@"; do
  "$flashray" compare "$input" --rounds "${ROUNDS:-9}" --rays "${RAYS:-50000}" >"$work/one"
  awk '/^bytes: / { exit } { print }' "$work/one"
done >"$work/all"
{
  echo '```text'
  cat "$work/all"
  awk '/^bytes: / { on = 1 } on { print }' "$work/one"
  echo '```'
} >"$work/tables"
# What stands between the two marks makes place for what was measured.
awk -v tables="$work/tables" '
  /<!-- end of tables -->/ { skip = 0 }
  !skip { print }
  /<!-- tables -->/ { skip = 1; while ((getline line < tables) > 0) print line }
' "$page" >"$work/page"
cp "$work/page" "$page"
