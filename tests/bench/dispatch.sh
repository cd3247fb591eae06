#!/usr/bin/env bash
# One emulated CPU model: what the library sees, which table it chooses, and, counted by the plugin, which kernels then ran.
#   dispatch.sh MODEL "EXPECTED LINE" PLUGIN DISPATCH WORKLOAD SHADOW_WORKLOAD SHADOW_FILE EMULATOR...
# An illegal instruction anywhere ends the emulator with SIGILL, which is a failure.
set -euo pipefail
model=$1 expected=$2 plugin=$3 dispatch=$4 workload=$5 shadow=$6 file=$7
shift 7
emulator=("$@" -cpu "$model")

found=$("${emulator[@]}" "$dispatch")
echo "$model: $found"
[[ $found == "$expected" ]] || { echo "expected: $expected"; exit 1; }

# The control: this model has dot products exactly when it says so.
status=0
"${emulator[@]}" "$dispatch" sdot >/dev/null 2>&1 || status=$?
if [[ $found == *'dotprod 1'* ]]; then expected_status=0; else expected_status=$((128 + 4)); fi
((status == expected_status)) || { echo "an SDOT ended with $status, not $expected_status"; exit 1; }

# The kernels that ran, by name: of a whole frame, and of a shadow's texture.
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT
# ran_only PATTERN NAMESPACE KERNELS PROGRAM...
ran_only() {
  local pattern=$1 namespace=$2 kernels=$3 ran kernel
  shift 3
  "${emulator[@]}" -plugin "$plugin,out=$counts" "$@" >/dev/null
  ran=$(c++filt <"$counts" | grep -oE "sandglass::$pattern::[a-z_]+" | sort -u)
  echo "ran:" $ran
  if grep -qv "^sandglass::$namespace::" <<<"$ran"; then echo "kernels of another table ran"; exit 1; fi
  for kernel in $kernels; do
    grep -qx "sandglass::$namespace::$kernel" <<<"$ran" || { echo "$kernel did not run"; exit 1; }
  done
}
ran_only 'simd_[a-z0-9_]+' "simd_$(awk '{print $8}' <<<"$found")" 'contact_solve neighbour_lists refine_grains' "$workload" 0 0 1
ran_only 'int8_[a-z0-9_]+' "int8_$(awk '{print $10}' <<<"$found")" shadow_texels "$shadow" "$file"
