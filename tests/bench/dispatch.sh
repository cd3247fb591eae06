#!/usr/bin/env bash
# One emulated CPU model: what the library sees, which table it chooses, and, counted by the plugin, which kernels then ran.
#   dispatch.sh MODEL "EXPECTED LINE" NAMESPACE PLUGIN DISPATCH WORKLOAD EMULATOR...
# An illegal instruction anywhere ends the emulator with SIGILL, which is a failure.
set -euo pipefail
model=$1 expected=$2 namespace=$3 plugin=$4 dispatch=$5 workload=$6
shift 6
emulator=("$@" -cpu "$model")

found=$("${emulator[@]}" "$dispatch")
echo "$model: $found"
[[ $found == "$expected" ]] || { echo "expected: $expected"; exit 1; }

# The control: this model has dot products exactly when it says so.
status=0
"${emulator[@]}" "$dispatch" sdot >/dev/null 2>&1 || status=$?
if [[ $found == *'dotprod 1'* ]]; then expected_status=0; else expected_status=$((128 + 4)); fi
((status == expected_status)) || { echo "an SDOT ended with $status, not $expected_status"; exit 1; }

# The kernels of a whole frame, by name.
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT
"${emulator[@]}" -plugin "$plugin,out=$counts" "$workload" 0 0 1 >/dev/null
ran=$(c++filt <"$counts" | grep -oE 'sandglass::simd_[a-z0-9_]+::[a-z_]+' | sort -u)
echo "ran:" $ran
if grep -qv "^sandglass::$namespace::" <<<"$ran"; then echo "kernels of another table ran"; exit 1; fi
for kernel in contact_solve neighbour_lists refine_grains; do
  grep -qx "sandglass::$namespace::$kernel" <<<"$ran" || { echo "$kernel did not run"; exit 1; }
done
