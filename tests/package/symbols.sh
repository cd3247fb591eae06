#!/usr/bin/env bash
# What the archive may ask of its surroundings, and what it may do before main.
#
#   symbols.sh archive libsandglass.a   after merging all members: every undefined symbol is on the list below, and there are no
#                                       global constructors or destructors and no thread-local storage
#   symbols.sh members libsandglass.a   the same for an archive of another system, whose members this one's linker cannot merge
#   symbols.sh isa OBJECTS...           each table_<isa>.cpp.o defines external symbols of its own namespace only. One that it
#                                       shares with another object (an inline function, say) could be kept by the linker in this
#                                       object's version, and run on a CPU without those instructions.
#   symbols.sh exported SHARED_LIBRARY INCLUDE_FOLDER
#                                       a plug-in made of the whole archive exports the functions of the headers and no other
#
# NM, LD and READELF name the tools of the target. WITH_XNNPACK=1: the archive was configured to ask for XNNPACK.
set -euo pipefail

# memory    : the four block functions that compilers emit on their own, and their string cousins that the verifier needs
# platform  : clock, CPU features, profiler
# exact     : libm functions that IEEE 754 defines to the bit; transcendental ones differ between C libraries
# compiler  : stack protector, position-independent code, out-of-line arithmetic
readonly allowed='^(mem(cpy|move|set|cmp)|str(len|cmp|ncmp)'\
'|clock_gettime|getauxval|ATrace_(begin|end)Section|abort'\
'|clock_gettime_nsec_np|sysctlbyname|os_log_create|(stand_in)?_os_signpost[a-z_]*|__dso_handle'\
'|(sqrt|floor|ceil|trunc|rint|nearbyint|fabs|fmin|fmax)f?'\
'|bzero|memset_pattern(4|8|16)|__stack_chk_(fail|guard)|_GLOBAL_OFFSET_TABLE_|__(u?div|u?mod|mul)ti3|__cpu_model|__cpu_indicator_init)$'

archive() {
  local merged symbol section failed=0
  local also='^$'
  [[ ${WITH_XNNPACK:-0} == 0 ]] || also='^xnn_[a-z0-9_]+$'
  merged=$(mktemp)
  trap 'rm -f "$merged"' RETURN
  "$LD" -r --whole-archive "$1" -o "$merged"
  while read -r _ symbol; do
    [[ $symbol =~ $allowed || $symbol =~ $also ]] && continue
    echo "forbidden symbol: $symbol ($(echo "$symbol" | c++filt))"
    failed=1
  done < <("$NM" -u "$merged")
  while read -r section; do
    echo "forbidden section: $section"
    failed=1
  done < <("$READELF" -SW "$merged" | grep -oE '\.(init_array|fini_array|preinit_array|ctors|dtors|tbss|tdata)\b' | sort -u)
  echo "undefined: $("$NM" -u "$merged" | awk '{printf "%s ", $2}')"
  return "$failed"
}

members() {
  local undefined symbol failed=0
  # Mach-O puts an underscore before every name of C.
  undefined=$(comm -23 <("$NM" -u -j "$1" | grep -vE ':$|^$' | sort -u) <("$NM" --defined-only -j "$1" | grep -vE ':$|^$' | sort -u))
  for symbol in $undefined; do
    [[ $symbol =~ $allowed || ${symbol#_} =~ $allowed ]] && continue
    echo "forbidden symbol: $symbol"
    failed=1
  done
  while read -r section; do
    echo "forbidden section: $section"
    failed=1
  done < <("$READELF" --sections "$1" | grep -oE '\.(init_array|fini_array|preinit_array|ctors|dtors|tbss|tdata)\b|__mod_init_func|__mod_term_func|__thread_(data|bss|vars)' |
    sort -u)
  echo "undefined: ${undefined//$'\n'/ }"
  return "$failed"
}

isa() {
  local object name symbol tables=0 failed=0
  for object in "$@"; do
    [[ $(basename "$object") =~ ^table_([a-z0-9_]+)\. ]] || continue
    name=${BASH_REMATCH[1]}
    tables=$((tables + 1))
    while read -r symbol; do
      [[ -z $symbol || $symbol == *"$name"* ]] && continue
      echo "$(basename "$object") defines a symbol outside its namespace: $symbol"
      failed=1
    done < <("$NM" -gC --defined-only "$object" | cut -d' ' -f3-)
  done
  echo "$tables instruction-set tables looked at"
  ((tables > 0)) || failed=1
  return "$failed"
}

exported() {
  local declared found
  declared=$(tr '\n' ' ' < <(cat "$2"/sandglass/*.h) | grep -oE 'SANDGLASS_API [^;/]*\(' | grep -oE 'sandglass_[a-z0-9_]+\(' | tr -d '(' |
    sort -u)
  found=$("$NM" -D --defined-only "$1" | awk '{print $3}' | sort -u)
  diff <(echo "$declared") <(echo "$found") || { echo "the headers (<) and what is exported (>) differ"; return 1; }
  echo "$(wc -l <<<"$found") functions exported"
}

"$@"
