#!/usr/bin/env bash
# What each structure takes on a Cortex-M4F: code, and instructions per ray under QEMU. Prints a Markdown table.
#
#   benches/firmware.sh ../shared/meshes/{spot,teapot}.obj [spd:balls:2 ..]
#
# Code is what a program grows by if it parses and walks this structure alone (`examples/firmware/src/only.rs`): the
# list's is the tests of a ray against every kind of primitive, which all others have in them too.
# KINDS="bvh grid" takes only these; "wide4" is wide with nodes of four.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}
cargo build --quiet --release --locked --features cli --manifest-path "$root/Cargo.toml"
flashray=$target/release/flashray
export CARGO_TARGET_DIR=$target/nested/firmware
images=$CARGO_TARGET_DIR/thumbv7em-none-eabihf/release
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
kinds=${KINDS:-$(grep -o '(Kind::[A-Za-z]*, "[a-z]*")' "$root/src/blob/header.rs" | cut -d'"' -f2)}

# The blob of input $1 in structure $2 as a module for the firmware.
scene() {
  local section=() width=()
  if [ "$2" = wide4 ]; then width=(--width 4); fi
  "$flashray" build "$1" -o "$work/scene.fray" --structure "${2%4}" "${width[@]}" >/dev/null
  if [ "$(stat -c %s "$work/scene.fray")" -gt 3500000 ]; then section=(--section .xip); fi
  "$flashray" emit "$work/scene.fray" --as rust -o "$work/scene.rs" "${section[@]}" >/dev/null
}

# Builds an image of the firmware; arguments are cargo's.
image() { (cd "$root/examples/firmware" && FLASHRAY_SCENE=$work/scene.rs cargo build --quiet --release --locked "$@"); }

# Bytes of code and constants in the image that has structure $1 alone.
size() {
  FLASHRAY_ONLY=$1 image --features only --bin only
  local sum=0 hex
  for hex in $(readelf -SW "$images/only" | sed -n 's/^ *\[ *[0-9]*\] \.\(text\|rodata\) *PROGBITS *[0-9a-f]* [0-9a-f]* \([0-9a-f]*\) .*/\2/p'); do
    sum=$((sum + 0x$hex))
  done
  echo "$sum"
}

# The number behind a key of a report.
number() { sed -n "s/^$1=\([0-9]*\).*/\1/p" "$work/report"; }

scene spd:balls:1 list
none=$(size '')
declare -A code
for kind in $kinds; do code[$kind]=$(($(size "$kind") - none)); done

echo "| structure | code, bytes | scene | blob, bytes | camera | chords | full check | start | stack of a query | of the check |"
echo "|---|---|---|---|---|---|---|---|---|---|"
for input in "$@"; do
  for kind in $kinds; do
    scene "$input" "$kind"
    image --bin flashray-firmware
    qemu-system-arm -M mps2-an386 -nographic -semihosting-config enable=on,target=native -icount shift=0 \
      -kernel "$images/flashray-firmware" </dev/null 2>&1 | tr -d '\r' >"$work/report"
    echo "| $kind | ${code[$kind]} | $(basename "$input" .obj) | $(number blob_bytes) |" \
      "$(number camera_instructions_per_ray) | $(number chords_instructions_per_ray) | $(number check_instructions) |" \
      "$(number start_instructions) | $(number query_stack_bytes) | $(number check_stack_bytes) |"
  done
done
echo
echo "Every image: $(number flash_bytes) bytes of flash without the blob, $(number static_ram_bytes) of static RAM."
