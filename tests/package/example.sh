#!/usr/bin/env bash
# An example that apps are to copy: at most 80 lines, the README's 40; it runs, and its output holds what its head claims.
#   example.sh NAME SOURCE_FOLDER OUTPUT_FOLDER PROGRAM...
set -euo pipefail
name=$1 root=$2 output=$3
shift 3
program=("$@")
mkdir -p "$output"
light=$root/models/lights/room.light shadow=$root/models/shadows/chair.shadow said=$output/$name.said

fail() { echo "$name: $1"; exit 1; }
# run ARGUMENT...: the program's output goes to $said too.
run() { "${program[@]}" "$@" | tee "$said"; }
# holds AWK_CONDITION: of the numbers in the output, in the order printed: n[1], n[2], ...
holds() {
  grep -oE -- '-?[0-9]+[.]?[0-9]*' "$said" | awk -v FS=' ' '{n[NR] = $1} END {exit !('"$1"')}' || fail "not so: $1"
}
# refuses FILE ARGUMENT...: exit status 1, and a sentence about that file.
refuses() {
  local file=$1 code=0
  shift
  "${program[@]}" "$@" 2>"$said.refused" || code=$?
  ((code == 1)) || fail "'$*' ended with $code"
  grep -q "$file: ." "$said.refused" || fail "no sentence about $file"
}

example_hello() {
  run
  # 512 particles, 2 s: a block of 0.16 m fell, spread and came to rest.
  holds 'n[1] == 512 && n[2] == 2 && n[3] > 0.02 && n[3] < 0.12 && n[4] < 0.1'
}

example_pour() {
  run
  # Whatever the machine affords in 4 ms a frame: of the four seconds, those that are no time debt pour at the rate of the
  # nozzle's lattice, pi sqrt(2) R^2 v / (2.02 r)^3 = 431 particles a second, less the sites at its rim. No heap has less
  # surface than half a ball of its volume, (4/3) pi r^3 n / 0.6; a vertex stands for r^2 of it; half may still fly. Where
  # more than a second is owed the skin is behind, too.
  holds 'n[1] > 300 * (4 - n[NR]) - 60 && n[1] < 450 * (4 - n[NR]) + 60 && (n[NR] > 1 || n[2] > 3.14 * (3.33 * n[1] / 2) ^ (2 / 3))'
}

example_bodies() {
  run
  # Sand 0.1 m deep bears the box, whose middle is at least 0.03 m from each of its faces; it lies still.
  holds 'n[1] > 0.10 && n[1] < 0.16 && n[2] > -0.02 && n[2] < 0.02'
  local hashes
  hashes=$(grep -oE '0x[0-9a-f]{16}' "$said" | sort -u | wc -l)
  ((hashes == 1)) || fail "the restored scene ends in another state"
}

example_carried_box() {
  run
  # All of the sand is in it, whatever the machine affords; the box was put 0.3 m aside.
  holds 'n[1] == n[2] && n[2] > 300 && n[3] > 0.29 && n[3] < 0.31 && n[4] > 0'
}

example_shadow_alone() {
  run "$shadow"
  # For every light the shadow falls to the other side.
  [[ $(grep -c 'away from the light by 0[.][0-9]*[1-9]' "$said") == 8 ]] || fail "a shadow falls towards its light"
  [[ $(tail -24 "$said" | grep -c '[%@]') -gt 2 ]] || fail "the last texture has no umbra"
  refuses "$light" "$light"
}

example_camera_app() {
  local source=$root/models/examples/camera_app.cpp room=$output/camera_app.room folder
  rm -f "$room"
  run "$shadow" "$room"
  # The made-up camera's lamp is at (1.6, 2.6, 0.2) m above the chair: (0.52, 0.85, 0.07). It is found by short images, and
  # casts a shadow; before, the app asks its user to look around. The chair's back keeps light from its seat, which else
  # shows what an open floor does: its irradiance over pi.
  holds 'n[1] > 0.8 && n[2] > 0.4 && n[3] > 0.7 && n[4]^2 < 0.04 && n[5] > 0.05 && n[7] > 0 && n[8] > 0'
  holds 'n[9] > 0.5 * n[6] / 3.1416 && n[9] < 0.97 * n[6] / 3.1416'
  # The room that was saved is known from the first frame on.
  run "$shadow" "$room"
  holds 'n[1] > 0.8 && n[5] > 0.05 && n[7] == 0'
  # What is no shadow, no room, no file or a folder is refused with its sentence.
  folder=$output/folder
  mkdir -p "$folder"
  refuses "$source" "$source" "$room"
  refuses "$source" "$shadow" "$source"
  refuses "$source.missing" "$source.missing" "$room"
  refuses "$folder" "$folder" "$room"
}

lines=$(cat "$root/models/examples/$name".c* | wc -l) most=80
[[ $name != pour ]] || most=40  # it is the README's
((lines > 0 && lines <= most)) || fail "it has $lines lines; an example must have 1 to $most"
"example_$name"
