#!/usr/bin/env bash
# Compiles the native part of a sample app for its own target, against stand-in headers. Nothing is linked or run.
# `java` compiles the Android sample's Java in the same way, compares its native methods with those of the C++, and runs
# the activity through its life.
#   samples.sh android|java|ios|unity SOURCE_FOLDER OUTPUT_FOLDER
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

# files FOLDER TEXT: splits a text into its files; a line `//// PATH` begins each.
files() {
  rm -rf "$1"
  awk -v folder="$1" '/^\/\/\/\/ / {file = folder "/" $2; dir = file; sub("/[^/]*$", "", dir); system("mkdir -p " dir); next} file {print > file}' "$2"
}
# forward FOLDER HEADER NAME...: headers of these names that include HEADER and nothing else.
forward() {
  local name
  for name in "${@:3}"; do
    mkdir -p "$(dirname "$1/$name")"
    echo "#include <$2>" >"$1/$name"
  done
}
# optimised FILE TEXT: FILE must have TEXT, which makes every build optimise the kernels.
optimised() {
  grep -q -- "$2" "$1" || { echo "$1 does not set $2: a debug build would run unoptimised kernels"; exit 1; }
}

android_headers=(-isystem "$stand_ins/sample_android" -isystem "$output/headers")
forward "$output/headers" filament/stand_in.h math/{mat4,vec3,vec4}.h utils/{Entity,EntityManager}.h \
  filament/{Camera,ColorGrading,Engine,IndexBuffer,IndirectLight,LightManager,Material,MaterialInstance,RenderableManager,Renderer}.h \
  filament/{Scene,SwapChain,Texture,TextureSampler,ToneMapper,TransformManager,VertexBuffer,View,Viewport}.h

case $platform in
  android)
    optimised "$sample/app/build.gradle" "'-DCMAKE_BUILD_TYPE=RelWithDebInfo'"
    clang++ --target=aarch64-linux-android24 -std=c++20 "${library[@]}" "${android_headers[@]}" "${ours[@]}" \
      "$sample/app/src/main/cpp/sample.cpp" ;;
  java)
    android=$source/toolchains/android/sample/app/src/main java=$output/java
    files "$java/stand_ins" "$stand_ins/android.java"
    files "$java/test" "$source/tests/toolchains/android_threads.java"
    mapfile -t platform_classes < <(find "$java/stand_ins" -name '*.java')
    # -h writes the declarations, which the C++ must match.
    javac -Xlint:all,-serial -Werror -d "$java/classes" -h "$java/jni" "${platform_classes[@]}" "$android"/java/org/sandglass/sample/*.java
    clang++ --target=aarch64-linux-android24 -std=c++20 "${library[@]}" "${android_headers[@]}" "${ours[@]}" \
      -include "$java/jni/org_sandglass_sample_Native.h" "$android/cpp/sample.cpp"
    diff <(grep -oE 'Java_[A-Za-z_]+' "$java/jni/org_sandglass_sample_Native.h" | sort -u) \
      <(grep -oE 'Java_[A-Za-z_]+' "$android/cpp/sample.cpp" | sort -u) || { echo "Native.java (<) and sample.cpp (>) differ"; exit 1; }
    javac -cp "$java/classes" -d "$java/run" "$android/java/org/sandglass/sample/MainActivity.java" "$java"/test/org/sandglass/sample/*.java
    timeout 60 java -cp "$java/run:$java/classes" -XX:TieredStopAtLevel=1 org.sandglass.sample.Lives ;;
  ios)
    optimised "$sample/CMakeLists.txt" "XCODE_SCHEME_LAUNCH_CONFIGURATION Release"
    forward "$output/headers" apple_stand_in.h {ARKit/ARKit,CoreVideo/CoreVideo,Metal/Metal,MetalKit/MetalKit,UIKit/UIKit}.h
    apple=(--target=arm64-apple-ios15 -fobjc-arc -fblocks -U__nonnull -Wno-objc-root-class
      -isystem "$stand_ins/sample_ios" -isystem "$output/headers")
    clang++ "${apple[@]}" -std=c++20 "${library[@]}" "${ours[@]}" -I "$sample" "$sample/SandViewController.mm"
    clang "${apple[@]}" -std=c11 -isystem "$cross" "${ours[@]}" -I "$sample" "$sample/main.m" ;;
  unity)
    mcs -unsafe -warnaserror -nowarn:0649 -target:library -out:"$output/sample.dll" "$source/toolchains/unity/Sandglass.cs" \
      "$sample/Sand.cs" "$sample/RoomLight.cs" "$stand_ins/UnityEngine.cs" ;;
esac
echo "$platform: compiles"
