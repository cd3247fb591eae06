#!/usr/bin/env bash
# The control of `symbols.sh archive`: it must find each fault in an object of each system, pass an object without faults,
# and fail with tools that fail or print nothing.
#   symbols_control.sh OUTPUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
output=$1
rm -rf "$output"
mkdir -p "$output"
failed=0

# expect STATUS SENTENCE NM READELF ARCHIVE: how symbols.sh must end, and the line that it must print.
expect() {
  local status=0 printed
  printed=$(NM=$3 READELF=$4 bash "$here/symbols.sh" archive "$5" 2>&1) || status=$?
  if [[ $((status != 0)) != "$1" ]] || ! grep -q "$2" <<<"$printed"; then
    echo "$(basename "$5") with $3 and $4: status $status, expected '$2', printed:" "$printed"
    failed=1
  fi
}

for target in x86_64-linux-gnu aarch64-linux-android24 arm64-apple-ios15; do
  # The tools with which the archives for this system are looked at.
  nm=$(command -v llvm-nm) readobj=$(command -v llvm-readobj)
  [[ $target != *-gnu ]] || { nm=$(command -v nm); readobj=$(command -v readelf); }
  # make NAME: makes an archive of the C source on standard input.
  make() {
    clang --target="$target" -fno-emulated-tls -ffreestanding -O1 -x c -c - -o "$output/$target.$1.o"
    llvm-ar rc "$output/$target.$1.a" "$output/$target.$1.o"
    echo "$output/$target.$1.a"
  }
  clean=$(make clean <<<'void* memcpy(void*, const void*, unsigned long); void fine(int* a, int* b) { memcpy(a, b, 1000); }')
  allocation=$(make allocation <<<'void* malloc(unsigned long); void* fault(void) { return malloc(8); }')
  transcendental=$(make transcendental <<<'float sinf(float); float fault(float x) { return sinf(x); }')
  constructor=$(make constructor <<<'volatile int n; __attribute__((constructor)) static void fault(void) { n = 1; }')
  thread_local=$(make thread_local <<<'__thread int fault = 1;')
  expect 0 'undefined: _*memcpy' "$nm" "$readobj" "$clean"
  expect 1 'forbidden symbol: _*malloc' "$nm" "$readobj" "$allocation"
  expect 1 'forbidden symbol: _*sinf' "$nm" "$readobj" "$transcendental"
  expect 1 'forbidden section: \(.init_array\|__mod_init_func\)' "$nm" "$readobj" "$constructor"
  expect 1 'forbidden section: \(.tdata\|__thread_data\)' "$nm" "$readobj" "$thread_local"
  for broken in /bin/false /bin/true; do
    expect 1 "$broken .*: it was to tell what .* defines" "$broken" "$readobj" "$clean"
    expect 1 "$broken .*: it was to tell the sections of" "$nm" "$broken" "$clean"
  done
done
((failed == 0)) && echo "every fault was found"
