#!/usr/bin/env bash
# What a capability weighs in an app after the linker has dropped unused sections: the program's code and constant data less
# those of an empty one.
#   footprint.sh NOTHING CAPABILITY PROGRAM LIMIT_KIB FORBIDDEN_SYMBOLS
# Fails above the limit, and when a symbol of another capability (an extended regular expression) came along.
# NM and SIZE name the tools of the target.
set -euo pipefail
nothing=$1 capability=$2 program=$3 limit=$4 forbidden=$5

bytes() { "$SIZE" "$1" | awk 'NR == 2 {print $1 + $2}'; }

weight=$(($(bytes "$program") - $(bytes "$nothing")))
printf '%s: %d bytes of code and constants, limit %d KiB\n' "$capability" "$weight" "$limit"
if "$NM" -C "$program" | grep -E "$forbidden" >&2; then
  echo "a capability that the app does not use was linked: the symbols above"
  exit 1
fi
((weight <= limit * 1024)) || { echo "heavier than the limit"; exit 1; }
