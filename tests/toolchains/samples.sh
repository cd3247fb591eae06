#!/usr/bin/env bash
# Compiles what is native in a sample app, for its own target but against stand-in headers: nothing is linked or run.
#   samples.sh android|ios|unity SOURCE_FOLDER OUTPUT_FOLDER
# The C++ library's headers are those of Debian's cross compiler, which clang reads for either target.
set -euo pipefail
platform=$1 source=$2 output=$3
mkdir -p "$output"
stand_ins=$source/tests/toolchains/stand_ins
sample=$source/toolchains/$platform/sample
cross=/usr/aarch64-linux-gnu/include
library=(-nostdinc++ -D_GNU_SOURCE)
for folder in "$cross"/c++/*/ "$cross"/c++/*/aarch64-linux-gnu "$cross"; do library+=(-isystem "$folder"); done
ours=(-I "$source/runtime/include" -I "$source/toolchains/sample" -fsyntax-only -Wall -Wextra -Werror)

case $platform in
  android)
    clang++ --target=aarch64-linux-android24 -std=c++20 "${library[@]}" -isystem "$stand_ins/sample_android" "${ours[@]}" \
      "$sample/app/src/main/cpp/sample.cpp" ;;
  ios)
    apple=(--target=arm64-apple-ios15 -fobjc-arc -fblocks -U__nonnull -Wno-objc-root-class -isystem "$stand_ins/sample_ios")
    clang++ "${apple[@]}" -std=c++20 "${library[@]}" "${ours[@]}" -I "$sample" "$sample/SandViewController.mm"
    clang "${apple[@]}" -std=c11 -isystem "$cross" "${ours[@]}" -I "$sample" "$sample/main.m" ;;
  unity)
    mcs -unsafe -warnaserror -nowarn:0649 -target:library -out:"$output/sample.dll" "$source/toolchains/unity/Sandglass.cs" \
      "$sample/Sand.cs" "$sample/RoomLight.cs" "$stand_ins/UnityEngine.cs" ;;
esac
echo "$platform: compiles"
