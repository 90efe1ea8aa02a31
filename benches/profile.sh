#!/usr/bin/env bash
# Where the time of a query goes: instructions per ray in each phase of the walk, counted by callgrind, and shares of
# time, sampled by perf from the clock. Prints the tables of docs/performance.md.
#
#   benches/profile.sh IN ..
#
# An IN is what `flashray build` takes. STRUCTURE=wide, MODE=single or group, COUNT=20000 rays for callgrind; SAMPLED=0
# leaves the sampling out; WITH="taskset -c 1" goes before perf. Wants valgrind, perf and addr2line. Phases are told apart by
# the functions that an instruction was inlined from.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/profile
structure=${STRUCTURE:-wide} mode=${MODE:-single}
# Line tables change no instruction.
CARGO_PROFILE_RELEASE_DEBUG=1 cargo build --quiet --release --locked --features cli --bin flashray \
  --manifest-path "$root/Cargo.toml" --target-dir "$target"
flashray=$target/release/flashray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# shellcheck source=benches/phases.sh
source "$root/benches/phases.sh"

order='preparation
box test
node fetch and order
stack
triangle test
call'

# A table row from lines "phase count" and what to divide by; "share" makes hundredths of all phases.
row() {
  awk -F'\t' -v title="$1" -v by="$2" -v order="$order" '
    { n[$1] = $2 }
    END {
      k = split(order, p, "\n")
      for (i = 1; i <= k; i++) all += n[p[i]]
      printf "| %s |", title
      for (i = 1; i <= k; i++) printf " %.1f |", by == "share" ? 100 * n[p[i]] / all : n[p[i]] / by
      printf " %.1f |\n", by == "share" ? 100 : all / by
    }'
}

heading() {
  printf '\n%s\n\n| |' "$1"
  while read -r phase; do printf ' %s |' "$phase"; done <<<"$order"
  printf ' all |\n|---|---|---|---|---|---|---|---|\n'
}

for input in "$@"; do
  name=$(basename "${input%.*}")
  "$flashray" build "$input" -o "$work/scene.fray" --structure "$structure" >/dev/null
  for kind in camera diffuse shadow chord; do
    any=$([[ $kind != shadow ]] || echo --any)
    # shellcheck disable=SC2086
    trace() { "$@" "$flashray" trace "$work/scene.fray" --rays "$work/rays" -o "$work/hits" --threads 1 --mode "$mode" $any >/dev/null; }
    "$flashray" rays "$work/scene.fray" -o "$work/rays" --kind $kind --count "${COUNT:-20000}" >/dev/null
    rays=$(($(stat -c %s "$work/rays") / 32))
    trace valgrind --quiet --tool=callgrind --dump-instr=yes --compress-pos=no --compress-strings=no \
      --callgrind-out-file="$work/calls" 2>/dev/null
    # Self costs: an address, a line, a count; the line after "calls=" is the callee's.
    awk '/^ob=/ { ours = /flashray$/ } /^calls=/ { skip = 1; next } /^0x/ { if (ours && !skip) n[$1] += $3; skip = 0 }
      END { for (a in n) print a, n[a] }' "$work/calls" | phases | row "$name, $kind" "$rays" >>"$work/instructions"
    [[ ${SAMPLED:-} != 0 ]] || continue
    # Rays enough for a second or so.
    "$flashray" rays "$work/scene.fray" -o "$work/rays" --kind $kind --count "${SAMPLED:-4000000}" >/dev/null
    trace ${WITH:-} perf record --quiet -F 4000 -e cpu-clock -o "$work/perf" 2>/dev/null
    # Where the program was loaded: an address of the file is one of memory less that.
    perf script -i "$work/perf" --show-mmap-events -F comm,event,ip 2>/dev/null >"$work/samples"
    readelf -lW "$flashray" | awk '$1 == "LOAD" && /R E/ { print $2, $3 }' >"$work/segment"
    awk -v segment="$(cat "$work/segment")" '
      function hex(s, x, i) { sub(/^0x/, "", s); x = 0; for (i = 1; i <= length(s); i++) x = x * 16 + index("0123456789abcdef", substr(s, i, 1)) - 1; return x }
      function text(x, s) { s = ""; while (x > 0) { s = substr("0123456789abcdef", x % 16 + 1, 1) s; x = int(x / 16) } return "0x" s }
      /PERF_RECORD_MMAP/ && /r-xp .*\/flashray$/ {
        match($0, /\[0x[0-9a-f]+\(0x[0-9a-f]+\) @ [0-9a-fx]+/)
        split(substr($0, RSTART + 1, RLENGTH - 1), f, /[ ()@]+/)
        split(segment, s, " ")
        start = hex(f[1]); size = hex(f[2]); offset = f[3] == "0" ? 0 : hex(f[3])
        shift = start - offset + hex(s[1]) - hex(s[2])
        next
      }
      { a = hex($NF); if (start && a >= start && a < start + size) n[text(a - shift)]++ }
      END { for (a in n) print a, n[a] }' "$work/samples" | phases | row "$name, $kind" share >>"$work/shares"
  done
done
heading "Instructions per ray, \`$structure\`, mode \`$mode\` (callgrind):"
cat "$work/instructions"
[[ ${SAMPLED:-} != 0 ]] || exit 0
heading "Hundredths of the time of a query (perf, samples of the clock):"
cat "$work/shares"
