#!/usr/bin/env bash
# How large a capability is in an app after the linker has dropped unused sections: the code and constant data of a
# shared library less those of an empty one.
#   footprint.sh EMPTY CAPABILITY APP FIGURE FORBIDDEN_SYMBOLS
# FIGURE is the size in KiB, or the name of a row of the table in $README. Fails if the size is more than a quarter
# above it, if a symbol of another capability (an extended regular expression) was linked, or if the library exports
# functions of Sandglass. With ROUNDING=PERCENT the figure must be right to within PERCENT. NM and SIZE name the
# tools of the target.
set -euo pipefail
empty=$1 capability=$2 app=$3 figure=$4 forbidden=$5

bytes() {
  [[ -f $1 ]] || { echo "$1 was not built" >&2; return 1; }
  "$SIZE" "$1" | awk 'NR == 2 {print $1 + $2}'
}

number='^[0-9]+([.][0-9])?$'
if [[ ! $figure =~ $number ]]; then
  row=$figure
  figure=$(awk -F ' *[|] *' -v row="$row" '$2 == row {print $3}' "$README")
  [[ $figure =~ $number ]] || { echo "README has no figure for '$row': '$figure'"; exit 1; }
fi
all=$(bytes "$app")
none=$(bytes "$empty")
weight=$((all - none))
claimed=$(awk -v kib="$figure" 'BEGIN {printf "%d", 1024 * kib}')
limit=$((claimed * 5 / 4))
printf '%s: %d bytes of code and constants (%d KiB), limit %d\n' "$capability" "$weight" $(((weight + 512) / 1024)) "$limit"
if "$NM" -C "$app" | grep -E "$forbidden" >&2; then
  echo "a capability that the app does not use was linked: the symbols above"
  exit 1
fi
if "$NM" -D --defined-only "$app" | grep sandglass_ >&2; then
  echo "the app's library exports functions of Sandglass, the symbols above: a linker keeps them, used or not"
  exit 1
fi
((weight <= limit)) || { echo "heavier than the limit, a quarter above $figure KiB"; exit 1; }
if [[ -n ${ROUNDING-} ]]; then
  wrong=$((weight - claimed))
  ((${wrong#-} * 100 <= claimed * ROUNDING)) ||
    { echo "the figure of $figure KiB is wrong by more than $ROUNDING %: $(((weight + 512) / 1024)) KiB"; exit 1; }
fi
