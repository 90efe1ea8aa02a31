#!/usr/bin/env bash
# Bytes and operations per ray beside what a core of this machine can do at best. Prints the tables of docs/performance.md,
# within five minutes for two scenes once the program is built.
#
#   benches/roofline.sh IN ..
#
# An IN is what `flashray build` takes. RAYS=16384 of each kind are counted, and timed in ROUNDS=5, of which the better
# quartile counts; WITH="taskset -c 1" goes before what is timed. DOCS=1 puts the tables into the page. Wants valgrind,
# addr2line and objdump, and x86-64 with AVX2.
#
# operations: f32 additions, multiplications, divisions, extremes and comparisons, also of distances as whole numbers, in
#   every lane of each instruction executed, whether the lane counts or not.
# touched: nodes visited and blocks or triangles tested, of single rays.
# moved: what instructions read and write, by the sizes of their operands: between the first cache and the core.
# from L2, from beyond: lines of 64 bytes that callgrind's caches miss, which have the sizes of this machine's first and
#   second; the blob is cold at the start, so a scene's first fetch is in it.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
target=${CARGO_TARGET_DIR:-$root/target}/profile
CARGO_PROFILE_RELEASE_DEBUG=1 cargo build --quiet --release --locked --features cli --bin flashray \
  --manifest-path "$root/Cargo.toml" --target-dir "$target"
flashray=$target/release/flashray
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# shellcheck source=benches/phases.sh
source "$root/benches/phases.sh"
rustc --edition 2024 -O -o "$work/peaks" "$root/benches/peaks.rs"

# A cache of this machine: bytes, ways, line.
cache() {
  local index=/sys/devices/system/cpu/cpu0/cache/index$1
  echo "$(($(sed 's/K$/*1024/' "$index/size"))),$(cat "$index/ways_of_associativity"),$(cat "$index/coherency_line_size")"
}
l1=$(cache 0) l2=$(cache 2)

# What each instruction of the program does: address, operations, bytes that it reads or writes.
objdump -d -M intel --no-show-raw-insn "$flashray" | awk '
  /^ *[0-9a-f]+:\t/ {
    a = $1; sub(/:$/, "", a); name = $2; lanes = 0; bytes = 0
    if (name ~ /^v?(add|sub|mul|div|min|max|sqrt|cmp[a-z]*)ps$/ || name ~ /^v?(pmin[su]d|pmax[su]d|pcmpgtd)$/)
      lanes = /ymm/ ? 8 : 4
    else if (name ~ /^v?(add|sub|mul|div|min|max|sqrt|cmp[a-z]*|u?comi)ss$/) lanes = 1
    if (name !~ /^(lea|nop|prefetch)/) {
      if (/YMMWORD PTR/) bytes = 32
      else if (/XMMWORD PTR/) bytes = 16
      else if (/QWORD PTR/) bytes = 8
      else if (/DWORD PTR/) bytes = 4
      else if (/WORD PTR/) bytes = 2
      else if (/BYTE PTR/) bytes = 1
      else if (name ~ /^(push|pop|call|ret)$/) bytes = 8
    }
    if (lanes || bytes) print a, lanes, bytes
  }' >"$work/does"

# Operations, bytes moved, bytes from the second cache and from beyond it, of all queries in a callgrind file.
sums() {
  awk '/^events:/ { for (i = 2; i <= NF; i++) at[$i] = i + 1 }
    /^ob=/ { ours = /flashray$/ }
    /^calls=/ { skip = 1; next }
    /^0x/ { if (ours && !skip) { n[$1] += $at["Ir"]; first[$1] += $at["D1mr"] + $at["D1mw"]; last[$1] += $at["DLmr"] + $at["DLmw"] } skip = 0 }
    END { for (a in n) print a, n[a], first[a] + 0, last[a] + 0 }' "$work/calls" >"$work/lines"
  cut -d' ' -f1,2 "$work/lines" | phases list >"$work/phased"
  awk -v FS='[ \t]' '
    function short(a) { sub(/^0x0*/, "", a); return a }
    FILENAME ~ /does$/ { ops[$1] = $2; bytes[$1] = $3; next }
    FILENAME ~ /phased$/ { if ($2 != "other") ours[short($1)] = 1; next }
    { a = short($1); if (a in ours) { o += $2 * ops[a]; b += $2 * bytes[a]; f += $3; l += $4 } }
    END { print o, b, 64 * f, 64 * l }' "$work/does" "$work/phased" "$work/lines"
}

# Levels of memory: a half of the first and of the second cache, well beyond the second, and well beyond all.
"$work/peaks" $((${l1%%,*} / 2)) $((${l2%%,*} / 2)) $((16 * ${l2%%,*})) $((1 << 30)) >"$work/best"
[[ -z ${DOCS:-} ]] || exec > >(tee "$work/tables")
peak() { awk -v key="$1" -v row="$2" '$1 == key && ++n == row { print $NF }' "$work/best"; }
echo "| a core at best | first cache | second | beyond it, 32 MiB | memory, 1 GiB |"
echo "|---|---|---|---|---|"
echo "| read in order, GB/s | $(peak read 1) | $(peak read 2) | $(peak read 3) | $(peak read 4) |"
echo "| wait for an address, ns | $(peak chase 1) | $(peak chase 2) | $(peak chase 3) | $(peak chase 4) |"
printf '\nAnd %s G f32 operations a second.\n' "$(peak operations 1)"

printf '\n| | operations | touched, B | moved, B | from L2, B | from beyond, B | operations per B moved | at the roof, ns | the roof | measured, ns | share | waits for L2, ns |\n'
echo "|---|---|---|---|---|---|---|---|---|---|---|---|"
for input in "$@"; do
  name=$(basename "${input%.*}")
  # shellcheck disable=SC2086
  ${WITH:-} "$flashray" bench "$input" --structure wide,bvh --rays "${RAYS:-16384}" --rounds "${ROUNDS:-5}" 2>/dev/null >"$work/speeds"
  for structure in wide bvh; do
    "$flashray" build "$input" -o "$work/scene.fray" --structure $structure >/dev/null
    for mode in single group; do
      column=0
      for kind in camera diffuse shadow chord; do
        column=$((column + 1))
        any=$([[ $kind != shadow ]] || echo --any)
        "$flashray" rays "$work/scene.fray" -o "$work/rays" --kind $kind --count "${RAYS:-16384}" >/dev/null
        rays=$(($(stat -c %s "$work/rays") / 32))
        # shellcheck disable=SC2086
        valgrind --quiet --tool=callgrind --dump-instr=yes --compress-pos=no --compress-strings=no --cache-sim=yes \
          --D1="$l1" --LL="$l2" --callgrind-out-file="$work/calls" \
          "$flashray" trace "$work/scene.fray" --rays "$work/rays" -o "$work/hits" --threads 1 --mode $mode $any \
          >/dev/null 2>&1
        awk -v title="$name, $structure, $mode, $kind" -v rays="$rays" -v sums="$(sums)" -v structure=$structure -v mode=$mode \
          -v column=$column -v ops_peak="$(peak operations 1)" -v b1="$(peak read 1)" -v b2="$(peak read 2)" -v b3="$(peak read 3)" \
          -v wait="$(peak chase 2)" '
          $1 == structure && $3 == mode && ($2 == "avx2" || $2 == "-") { rate = $(6 + 3 * (column - 1)) }
          # Bytes and seconds a primitive come first; without the seconds of a blob.
          $1 == structure && NF == 11 { nodes = $(3 + column); tests = $(7 + column) }
          END {
            split(sums, s, " ")
            for (i = 1; i <= 4; i++) s[i] /= rays
            # A node has 256 bytes or 64, a block of four triangles 160, a triangle 36.
            touched = structure == "wide" ? nodes * 256 + tests * 40 : nodes * 64 + tests * 36
            roof = s[1] / ops_peak; which = "operations"
            if (s[2] / b1 > roof) { roof = s[2] / b1; which = "first cache" }
            if (s[3] / b2 > roof) { roof = s[3] / b2; which = "second cache" }
            if (s[4] / b3 > roof) { roof = s[4] / b3; which = "beyond" }
            ns = 1000 / rate
            printf "| %s | %.0f | %s | %.0f | %.0f | %.0f | %.2f | %.1f | %s | %.1f | %.2f | %.1f |\n", title, s[1],
              mode == "single" ? sprintf("%.0f", touched) : "", s[2], s[3], s[4], s[1] / s[2], roof, which, ns, roof / ns, s[3] / 64 * wait
          }' "$work/speeds"
      done
    done
  done
done

# What stands between the two marks makes place for what was measured.
if [[ -n ${DOCS:-} ]]; then
  sleep 1 # tee writes by itself
  page=$root/docs/performance.md
  awk -v tables="$work/tables" '
    /^<!-- end of roofline -->$/ { off = 0 }
    !off { print }
    /^<!-- roofline -->$/ { off = 1; while ((getline line < tables) > 0) print line }' "$page" >"$work/page"
  cp "$work/page" "$page"
fi
