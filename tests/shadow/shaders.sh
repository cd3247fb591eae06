#!/usr/bin/env bash
# The reference compiler accepts the GLSL, the HLSL and, with stand-ins for what Filament puts around it, the material of
# the README, and refuses controls with a fault.
#   shaders.sh README WORK_FOLDER
# Exit code 77: glslangValidator is not installed (Debian: glslang-tools).
set -euo pipefail
command -v glslangValidator >/dev/null || exit 77
readme=$1 work=$2
rm -rf "$work" && mkdir -p "$work"
for language in glsl hlsl filament; do
  awk -v begin="\`\`\`$language" -v out="$work/" -v ending=".$language" \
    '$0 == begin {n++; on = 1; next} /^```$/ {on = 0} on {print >(out n ending)}' "$readme"
done
[[ -s $work/3.glsl && ! -e $work/4.glsl && -s $work/1.hlsl && -s $work/1.filament ]] ||
  { echo "the README holds other shaders than a catcher's two, an object's in GLSL, HLSL and for Filament"; exit 1; }
glslangValidator -S vert "$work/1.glsl"
glslangValidator -S frag "$work/2.glsl"
glslangValidator -S vert "$work/3.glsl"
# The outputs of the vertex shader must be the inputs of the fragment shader.
cp "$work/1.glsl" "$work/catcher.vert" && cp "$work/2.glsl" "$work/catcher.frag"
glslangValidator -l "$work/catcher.vert" "$work/catcher.frag"

hlsl() {
  { cat "$1"; echo 'float4 main(float3 a : A, float3 b : B, float3 c : C) : SV_POSITION { return float4(room_light(a, b, c), 1); }'; } >"$1.vert"
  glslangValidator -D -V -S vert -e main -o "$1.spv" "$1.vert"
}
hlsl "$work/1.hlsl"

# block FILE NAME: the text between "NAME {" and the brace that closes it.
block() { awk -v name="$2" '$0 == name " {" {on = 1; next} $0 == "}" {on = 0} on' "$1"; }
material() {
  local common='#version 310 es
precision highp float;
struct MaterialParams { vec3 sh[9]; vec3 albedo; }; uniform MaterialParams materialParams;'
  { echo "$common"
    for i in 0 1 2; do echo "in vec4 custom$i; vec4 getCustom$i() { return custom$i; }"; done
    echo 'struct MaterialVertexInputs { vec4 worldPosition; vec4 light; };'
    block "$1" vertex
    echo 'void main() { MaterialVertexInputs m; materialVertex(m); gl_Position = m.light; }'; } >"$1.vert"
  { echo "$common"; echo 'in vec4 variable_light; out vec4 colour; struct MaterialInputs { vec4 baseColor; }; void prepareMaterial(inout MaterialInputs m) {}'
    block "$1" fragment
    echo 'void main() { MaterialInputs m; material(m); colour = m.baseColor; }'; } >"$1.frag"
  glslangValidator "$1.vert" && glslangValidator "$1.frag"
}
material "$work/1.filament"

refused() { if "$@" >/dev/null; then echo "a shader with a fault was accepted: $*"; exit 1; fi; }
sed 's/^in vec2 floor_position/in vec2 elsewhere/' "$work/2.glsl" >"$work/wrong.frag"
sed 's/transfer_2;$/transfer_3;/' "$work/3.glsl" >"$work/wrong.vert"
sed 's/float3 t2/float3 t3/' "$work/1.hlsl" >"$work/wrong.hlsl"
sed 's/variable_light/variable_lights/' "$work/1.filament" >"$work/wrong.filament"
refused glslangValidator "$work/wrong.frag"
refused glslangValidator "$work/wrong.vert"
(refused hlsl "$work/wrong.hlsl")
(refused material "$work/wrong.filament")
