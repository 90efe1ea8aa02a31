#!/usr/bin/env bash
# Time of queries in WebAssembly under Node.js, with and without simd128, in turns. Prints Markdown tables, ns a ray.
#
#   benches/wasm.sh ../shared/meshes/{bunny,kitchen}.obj
#
# KINDS="bvh wide" takes these structures, ROUNDS=9 gives each figure so many rounds, COUNT=100000 so many rays; BESIDE=DIR
# times the library of another checkout beside, on the same blobs and rays.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
cargo build --quiet --release --locked --features cli --manifest-path "$root/Cargo.toml"
flashray=$target/release/flashray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# Module $1 of the library in $2, with compiler flags $3.
modules=()
module() {
  mkdir -p "$work/$1"
  cp -r "$root/benches/wasm/." "$work/$1"
  sed -i "s|path = \"../..\"|path = \"$2\"|" "$work/$1/Cargo.toml"
  RUSTFLAGS="$3" CARGO_TARGET_DIR="$target/nested/wasm-$1" cargo build --quiet --release \
    --manifest-path "$work/$1/Cargo.toml" --target wasm32-unknown-unknown
  cp "$target/nested/wasm-$1/wasm32-unknown-unknown/release/flashray_wasm_bench.wasm" "$work/$1.wasm"
  modules+=("$1=$work/$1.wasm")
}
module plain "$root" ""
module simd128 "$root" "-C target-feature=+simd128"
if [ -n "${BESIDE:-}" ]; then
  beside=$(cd "$BESIDE" && pwd)
  module plain-beside "$beside" ""
  module simd128-beside "$beside" "-C target-feature=+simd128"
fi

for input in "$@"; do
  scenes=() rays=()
  for kind in ${KINDS:-bvh wide}; do
    "$flashray" build "$input" -o "$work/$kind.fray" --structure "$kind" >/dev/null
    scenes+=("$kind=$work/$kind.fray")
  done
  for kind in camera diffuse shadow chord; do
    "$flashray" rays "${scenes[0]#*=}" -o "$work/$kind.rays" --kind "$kind" --count "${COUNT:-100000}" >/dev/null
    rays+=("$kind=$work/$kind.rays")
  done
  echo "$(basename "$input" .obj)"
  echo
  echo "| structure | module | query | camera | diffuse | shadow | chord |"
  echo "|---|---|---|---|---|---|---|"
  node "$root/benches/wasm/run.mjs" "${ROUNDS:-9}" "${modules[@]}" -- "${scenes[@]}" -- "${rays[@]}"
  echo
done
