#!/usr/bin/env bash
# Which symbols the archive may need from outside, and that it does nothing before main.
#
#   symbols.sh archive libsandglass.a   every symbol that no member defines is on the list below, and there are no global
#                                       constructors or destructors and no thread-local storage
#   symbols.sh isa OBJECTS...           each table_<isa>.cpp.o defines external symbols of its own namespace only. One that it
#                                       shares with another object (an inline function, say) could be kept by the linker in this
#                                       object's version, and run on a CPU without those instructions.
#   symbols.sh exported SHARED_LIBRARY INCLUDE_FOLDER
#                                       a plug-in made of the whole archive exports the functions of the headers and no other
#   symbols.sh imported DLL             a DLL needs no DLL but the system's
#
# NM, READELF and OBJDUMP name the tools of the target; one that fails or says nothing is a failure of the test, not a clean
# archive. WITH_XNNPACK=1: the archive was configured to ask for XNNPACK.
set -euo pipefail

# The lines of the list:
# memory     the four functions that compilers emit on their own, and the string functions that FlatBuffers' verifier needs
# platform   clock, CPU features, profiler; the second line is Apple's, the third Windows'
# exact      libm functions that IEEE 754 defines to the bit; transcendental ones differ between C libraries
# compiler   what clang makes of memcmp and memset, stack protector, position-independent code, out-of-line arithmetic
readonly allowed='^(mem(cpy|move|set|cmp)|str(len|cmp|ncmp)'\
'|clock_gettime|getauxval|ATrace_(begin|end)Section|abort'\
'|clock_gettime_nsec_np|sysctlbyname|os_log_create|(stand_in)?_os_signpost[a-z_]*|__dso_handle'\
'|(__imp_)?(QueryPerformance(Counter|Frequency)|___chkstk_ms)'\
'|(sqrt|floor|ceil|trunc|rint|nearbyint|fabs|fmin|fmax)f?'\
'|bcmp|bzero|memset_pattern(4|8|16)|__stack_chk_(fail|guard)|_GLOBAL_OFFSET_TABLE_|__(u?div|u?mod|mul)ti3|__cpu_model|__cpu_indicator_init)$'

# said_by WHAT TOOL ARGUMENTS...: prints what the tool printed. WHAT names it in a sentence. The result goes into a
# variable first, because a failure inside <(...) would be lost.
said_by() {
  local what=$1 said
  shift
  said=$("$@") || { echo "$1 failed: it was to tell $what" >&2; return 1; }
  [[ -n $said ]] || { echo "$1 printed nothing: it was to tell $what" >&2; return 1; }
  echo "$said"
}

readonly sections_before_main='\.(init_array|fini_array|preinit_array|ctors|dtors|tbss|tdata)\b'\
'|__mod_init_func|__mod_term_func|__thread_(data|bss|vars)'

# look_at SYMBOLS SECTIONS ALSO_ALLOWED: one undefined symbol a line, and the tool's list of sections.
look_at() {
  local symbol section failed=0
  while read -r symbol; do
    # Mach-O puts an underscore in front of every C name.
    [[ -z $symbol || $symbol =~ $allowed || ${symbol#_} =~ $allowed || $symbol =~ $3 ]] && continue
    echo "forbidden symbol: $symbol ($(c++filt "$symbol"))"
    failed=1
  done <<<"$1"
  while read -r section; do
    [[ -z $section ]] && continue
    echo "forbidden section: $section"
    failed=1
  done < <(grep -oE "$sections_before_main" <<<"$2" | sort -u)
  echo "undefined: ${1//$'\n'/ }"
  return "$failed"
}

archive() {
  local undefined defined sections also='^$'
  [[ ${WITH_XNNPACK:-0} == 0 ]] || also='^xnn_[a-z0-9_]+$'
  # An archive may need nothing. That the tool finds defined symbols shows that it works.
  defined=$(said_by "what $1 defines" "$NM" --defined-only -j "$1")
  undefined=$("$NM" -u -j "$1")
  sections=$(said_by "the sections of $1" "$READELF" --sections "$1")
  undefined=$(comm -23 <(grep -vE ':$|^$' <<<"$undefined" | sort -u) <(grep -vE ':$|^$' <<<"$defined" | sort -u))
  look_at "$undefined" "$sections" "$also"
}

isa() {
  local object name symbol symbols tables=0 failed=0
  for object in "$@"; do
    [[ $(basename "$object") =~ ^table_([a-z0-9_]+)\. ]] || continue
    name=${BASH_REMATCH[1]}
    tables=$((tables + 1))
    symbols=$(said_by "what $object defines" "$NM" -gC --defined-only "$object")
    while read -r symbol; do
      [[ -z $symbol || $symbol == *"$name"* ]] && continue
      echo "$(basename "$object") defines a symbol outside its namespace: $symbol"
      failed=1
    done < <(cut -d' ' -f3- <<<"$symbols")
  done
  echo "$tables instruction-set tables looked at"
  ((tables > 0)) || failed=1
  return "$failed"
}

exported() {
  local declared found
  declared=$(tr '\n' ' ' < <(cat "$2"/sandglass/*.h) | grep -oE 'SANDGLASS_API [^;/]*\(' | grep -oE 'sandglass_[a-z0-9_]+\(' | tr -d '(' |
    sort -u)
  if [[ $1 == *.dll ]]; then
    found=$(said_by "what $1 exports" "$OBJDUMP" -p "$1" |
      awk '/Ordinal\/Name Pointer/ {names = 1; next} NF == 0 {names = 0} names {print $NF}')
  else
    found=$(said_by "what $1 exports" "$NM" -D --defined-only "$1" | awk '{print $3}')
  fi
  found=$(sort -u <<<"$found")
  diff <(echo "$declared") <(echo "$found") || { echo "the headers (<) and what is exported (>) differ"; return 1; }
  echo "$(wc -l <<<"$found") functions exported"
}

imported() {
  local needed foreign
  needed=$(said_by "what $1 needs" "$OBJDUMP" -p "$1" | awk '$1 == "DLL" && $2 == "Name:" {print $3}')
  echo "needs: ${needed//$'\n'/ }"
  foreign=$(grep -vixE '(kernel32|msvcrt|ucrtbase|api-ms-win-[a-z0-9-]+)\.dll' <<<"$needed" || true)
  [[ -z $foreign ]] || { echo "not the system's: ${foreign//$'\n'/ }"; return 1; }
}

"$@"
