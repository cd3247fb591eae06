#!/usr/bin/env bash
# Tests one emulated CPU model: what the library sees, which tables it chooses, what an app gets or is refused that asks
# by name, and, counted by the plugin, which kernels then ran.
#   dispatch.sh MODEL "EXPECTED LINE" PLUGIN PROGRAMS_FOLDER SHADOW_FILE KERNELS_INC EMULATOR...
# An illegal instruction anywhere ends the emulator with SIGILL, which is a failure.
set -euo pipefail
model=$1 expected=$2 plugin=$3 programs=$4 file=$5 float_kernels=$6
shift 6
emulator=("$@" -cpu "$model")

found=$("${emulator[@]}" "$programs/dispatch")
echo "$model: $found"
[[ $found == "$expected" ]] || { echo "expected: $expected"; exit 1; }

# The control: this model executes dot products only if it says that it has them.
status=0
"${emulator[@]}" "$programs/dispatch" sdot >/dev/null 2>&1 || status=$?
if [[ $found == *'dotprod 1'* ]]; then expected_status=0; else expected_status=$((128 + 4)); fi
((status == expected_status)) || { echo "an SDOT ended with $status, not $expected_status"; exit 1; }

# Asked by name, sand gets the NEON table, shadow and light get their own. What the CPU lacks is
# refused.
expected_choice='scalar sand scalar shadow scalar light scalar'
expected_choice+=$'\nneon sand neon shadow neon light neon'
for feature in dotprod i8mm; do
  if [[ $found == *"$feature 1"* ]]; then expected_choice+=$'\n'"neon_$feature sand neon shadow neon_$feature light neon_$feature"
  else expected_choice+=$'\n'"neon_$feature refused"; fi
done
choice=$("${emulator[@]}" "$programs/choice" "$file") || { echo "$choice"; exit 1; }
echo "$choice"
[[ $choice == "$expected_choice" ]] || { echo "expected: $expected_choice"; exit 1; }

# The names of the kernels that ran: in a whole frame, in every float kernel's own workload, in a shadow's texture and
# in the light's network.
counts=$(mktemp)
trap 'rm -f "$counts"' EXIT
# ran_only PATTERN NAMESPACE KERNELS PROGRAM...
ran_only() {
  local pattern=$1 namespace=$2 kernels=$3 ran kernel
  shift 3
  "${emulator[@]}" -plugin "$plugin,out=$counts" "$@" >/dev/null
  ran=$(c++filt <"$counts" | grep -oE "sandglass::$pattern::[a-z_0-9]+" | sort -u)
  echo "ran:" $ran
  if grep -qv "^sandglass::$namespace::" <<<"$ran"; then echo "kernels of another table ran"; exit 1; fi
  for kernel in $kernels; do
    grep -qx "sandglass::$namespace::$kernel" <<<"$ran" || { echo "$kernel did not run"; exit 1; }
  done
}
float_table="simd_$(awk '{print $8}' <<<"$found")" int8_table="int8_$(awk '{print $10}' <<<"$found")"
every_kernel=$(sed -nE 's/^SANDGLASS_KERNEL\([a-z]+, ([a-z_]+),.*/\1/p' "$float_kernels")
ran_only 'simd_[a-z0-9_]+' "$float_table" 'grid_cells contact_pairs neighbour_lists refine_grains' "$programs/count_workload" 0 0 1
ran_only 'simd_[a-z0-9_]+' "$float_table" "${every_kernel:?no kernels in $float_kernels}" "$programs/count_kernels" all
ran_only 'int8_[a-z0-9_]+' "$int8_table" shadow_texels "$programs/count_shadow" "$file"
ran_only 'int8_[a-z0-9_]+' "$int8_table" 'stem pool narrow wide transition dot' "$programs/count_light" 0 32 32
