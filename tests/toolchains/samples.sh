#!/usr/bin/env bash
# Compiles a sample for its own target. Nothing is linked or run. The headers of JNI and OpenGL ES are the real ones; of
# Apple's and Unity's interfaces there are stand-ins. Shaders go through the reference compiler, which must refuse a
# fault too.
#   samples.sh android|ios|unity SOURCE_FOLDER OUTPUT_FOLDER SANDGLASS_CS
# The C++ library's headers are those of Debian's cross compiler, which clang reads for either target.
set -euo pipefail
platform=$1 source=$2 output=$3
rm -rf "$output" && mkdir -p "$output/headers"
stand_ins=$source/tests/toolchains/stand_ins
sample=$source/toolchains/$platform/sample
cross=/usr/aarch64-linux-gnu/include
flags=(-nostdinc++ -D_GNU_SOURCE)
for folder in "$cross"/c++/*/ "$cross"/c++/*/aarch64-linux-gnu "$cross"; do flags+=(-isystem "$folder"); done
flags+=(-isystem "$output/headers" -I "$source/runtime/include" -I "$source/toolchains/sample" -std=c++20 -fsyntax-only -Wall -Wextra -Werror)

# shader KIND FILE [GLSLANG_OPTION...]: FILE must compile, and must not without its last brace.
shader() {
  glslangValidator -S "$1" "${@:3}" "$2"
  tac "$2" | sed '0,/}/s/}//' | tac >"$2.fault"
  if glslangValidator -S "$1" "${@:3}" "$2.fault" >/dev/null; then echo "a shader with a fault was accepted"; exit 1; fi
}

case $platform in
  android)
    # Java declares what it calls, and C++ must define that and no more.
    javac -Xlint:all -Werror -d "$output" -h "$output" "$sample/Sand.java"
    ln -s /usr/include/{GLES3,KHR} "$output/headers"
    jdk=$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")
    clang++ --target=aarch64-linux-android24 "${flags[@]}" -isystem "$jdk/include" -isystem "$jdk/include/linux" \
      -include "$output/org_sandglass_sample_Sand.h" "$sample/sand.cpp"
    diff <(grep -oE 'Java_[A-Za-z_]+' "$output/org_sandglass_sample_Sand.h" | sort -u) <(grep -oE 'Java_[A-Za-z_]+' "$sample/sand.cpp" | sort -u) ||
      { echo "Sand.java (<) and sand.cpp (>) differ"; exit 1; }
    for kind in vertex fragment table_vertex table_fragment; do
      awk -v kind="k_${kind}_shader" '/^\)glsl"/ {on = 0} on {print} index($0, kind "[]") {on = 1; print "#version 300 es"}' "$sample/sand.cpp" >"$output/$kind"
      stage=${kind#table_}
      shader "${stage:0:4}" "$output/$kind"
    done
    cp "$output/table_vertex" "$output/table.vert" && cp "$output/table_fragment" "$output/table.frag"
    glslangValidator -l "$output/table.vert" "$output/table.frag" ;;
  ios)
    mkdir -p "$output/headers"/{ARKit,MetalKit,simd}
    for header in ARKit/ARKit MetalKit/MetalKit simd/simd; do echo '#include <apple.h>' >"$output/headers/$header.h"; done
    clang++ --target=arm64-apple-ios15 -fobjc-arc -fblocks -U__nonnull -isystem "$stand_ins" "${flags[@]}" "$sample/SandRenderer.mm"
    for name in $(grep -oE '@"[a-z_]+_(vertex|fragment)"' "$sample/SandRenderer.mm" | tr -d '@"'); do
      grep -qE "^(vertex|fragment) [A-Za-z0-9]+ $name\(" "$sample/Shaders.metal" || { echo "no Metal function $name"; exit 1; }
    done ;;
  unity)
    mcs -unsafe -warnaserror -nowarn:0649 -target:library -out:"$output/sample.dll" "$4" "$sample/Sand.cs" "$stand_ins/UnityEngine.cs"
    for name in Sand Table; do
      { echo '#define fixed4 float4'
        echo 'float4x4 UNITY_MATRIX_V, UNITY_MATRIX_P, unity_ObjectToWorld;'
        awk '/CGPROGRAM/ {on = 1; next} /ENDCG/ {on = 0} on && !/#pragma|UnityCG.cginc/' "$sample/$name.shader"; } >"$output/$name.hlsl"
      for kind in vertex fragment; do shader "${kind:0:4}" "$output/$name.hlsl" -D -V -e "$kind" -o "$output/$kind.spv"; done
    done
    for kind in vertex fragment; do shader "${kind:0:4}" "$output/Table.hlsl" -D -V -DON_MESH -e "$kind" -o "$output/$kind.spv"; done ;;
esac
echo "$platform: compiles"
