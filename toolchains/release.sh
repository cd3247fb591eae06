#!/usr/bin/env bash
# What a release would upload, into out/release: ./sg release. All tests run first. Nothing is uploaded, and nothing tagged.
set -euo pipefail
fail() { printf 'sg: %s\n' "$*" >&2; exit 1; }
[[ -z $(git status --porcelain) ]] || fail "the checkout has changes that are not committed: a release is of a commit."
[[ ! -e out/release ]] || fail "out/release is there already: keep it elsewhere, or remove it."
version=$(sed -n 's/^project(sandglass VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
./sg test && ./sg test --all && ./sg page && ./sg docs
python3 -B toolchains/docs/site.py . out/page/sandglass.html build/docs/html out/site
pieces=(site=out/site npm=build/web/npm)
for system in linux-x86-64 linux-arm64 windows-x86-64; do
  build=build/release/$system toolchain=()
  mkdir -p build/release
  case $system in
    linux-arm64) toolchain=(-DCMAKE_TOOLCHAIN_FILE="$PWD/toolchains/linux-arm64/toolchain.cmake") ;;
    windows-*) toolchain=(-DCMAKE_TOOLCHAIN_FILE="$PWD/toolchains/windows/toolchain.cmake") ;;
  esac
  cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DSANDGLASS_DEVELOPER=OFF -DSANDGLASS_INSTALL=ON "${toolchain[@]}" >"$build.log" ||
    fail "configuring failed; see $build.log"
  cmake --build "$build" && cmake --install "$build" --prefix "$build/prefix" >>"$build.log"
  pieces+=("$system=$build/prefix")
done
cmake --build build/host --target unity_package
pieces+=(unity=build/host/unity/org.sandglass)
# From their kits alone, never from stand-ins.
if [[ -n ${ANDROID_NDK-} ]]; then
  cmake --preset android && cmake --build --preset android --target aar
  pieces+=(android="$(ls build/android/*.aar)")
else echo "no AAR: set ANDROID_NDK"; fi
if command -v xcrun >/dev/null; then
  for system in ios ios-simulator visionos visionos-simulator; do cmake --preset $system && cmake --build --preset $system; done
  cmake --build --preset ios --target xcframework
  pieces+=(swift=build/ios/swift)
else echo "no Swift package: it is made on a Mac"; fi
python3 -B toolchains/release.py out/release "$version" "$(git log -1 --format=%ct)" "${pieces[@]}"
