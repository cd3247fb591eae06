#!/usr/bin/env bash
# The reference compiler must accept the sample apps' shaders, with stand-ins for what Filament and Unity put around
# them, and refuse shaders with a fault. There is no compiler for Metal here: its functions are looked for in the files
# from which the sample's CMakeLists takes them.
#   shaders.sh SOURCE_FOLDER OUTPUT_FOLDER
set -euo pipefail
source=$1 output=$2
rm -rf "$output" && mkdir -p "$output"

# block FILE NAME: the text between "NAME {" and the brace that closes it.
block() { awk -v name="$2" '$0 == name " {" {on = 1; next} $0 == "}" {on = 0} on' "$1"; }

# parameters FILE: a Filament material's parameters, as its compiler declares them.
parameters() {
  local types='s/float\([234]\)/vec\1/; s/sampler2d/sampler2D/'
  grep -oE 'type : [a-z0-9]+, name : [a-z_]+' "$1" | sed "s/type : //; s/, name : / /; $types" | {
    echo 'struct MaterialParams {'
    while read -r type name; do
      if [[ $type == sampler2D ]]; then echo "uniform $type materialParams_$name;" >>"$output/samplers"; else echo "  $type $name;"; fi
    done
    echo '}; uniform MaterialParams materialParams;'
  }
}

material() {
  local file=$1 name
  name=$(basename "$file" .mat)
  : >"$output/samplers"
  parameters "$file" >"$output/parameters"
  local common='#version 310 es
precision highp float;
mat4 getClipFromWorldMatrix() { return mat4(1.0); } mat4 getClipFromViewMatrix() { return mat4(1.0); }
mat4 getViewFromWorldMatrix() { return mat4(1.0); } vec4 getResolution() { return vec4(1.0); }'
  local variables
  variables=$(awk '$1 == "variables" {print $4}' "$file")
  { echo "$common"; cat "$output/samplers" "$output/parameters"
    echo "in vec4 position; vec4 getPosition() { return position; }
struct MaterialVertexInputs { vec4 worldPosition; ${variables:+vec4 $variables;} };"
    block "$file" vertex
    echo 'void main() { MaterialVertexInputs m; materialVertex(m); gl_Position = m.worldPosition; }'; } >"$output/$name.vert"
  { echo "$common"; cat "$output/samplers" "$output/parameters"
    [[ -z $variables ]] || echo "in vec4 variable_$variables;"
    echo 'out vec4 colour; struct MaterialInputs { vec4 baseColor; }; void prepareMaterial(inout MaterialInputs m) {}'
    block "$file" fragment
    echo 'void main() { MaterialInputs m; material(m); colour = m.baseColor; }'; } >"$output/$name.frag"
  grep -q 'void materialVertex' "$output/$name.vert" && grep -q 'void material(' "$output/$name.frag"
  glslangValidator "$output/$name.vert"
  glslangValidator "$output/$name.frag"
}

unity() {
  local name
  name=$(basename "$1" .shader)
  { echo '#define fixed4 float4
#define sampler2D Texture2D
#define tex2D(image, at) image.Sample(unity_sampler, at)
SamplerState unity_sampler; float4x4 UNITY_MATRIX_V, UNITY_MATRIX_P;'
    awk '/CGPROGRAM/ {on = 1; next} /ENDCG/ {on = 0} on && !/#pragma|UnityCG.cginc/' "$1"; } >"$output/$name.hlsl"
  grep -q SV_Target "$output/$name.hlsl"
  glslangValidator -D -V -S vert -e vertex -o "$output/$name.vert.spv" "$output/$name.hlsl"
  glslangValidator -D -V -S frag -e fragment -o "$output/$name.frag.spv" "$output/$name.hlsl"
}

for file in "$source"/toolchains/android/sample/app/src/main/materials/*.mat; do material "$file"; done
for file in "$source"/toolchains/unity/sample/*.shader; do unity "$file"; done

mkdir "$output/fault"
sed 's/materialParams.strength/materialParams.length/' "$source/toolchains/android/sample/app/src/main/materials/shadow.mat" >"$output/fault/shadow.mat"
sed 's/_Strength;$/_Power;/' "$source/toolchains/unity/sample/Shadow.shader" >"$output/fault/Shadow.shader"
if (material "$output/fault/shadow.mat") >/dev/null; then echo "a material with a fault was accepted"; exit 1; fi
if (unity "$output/fault/Shadow.shader") >/dev/null; then echo "a shader with a fault was accepted"; exit 1; fi

# Shaders.metal and ShadowCatcher.metal must define the functions that the app asks for.
awk '/^```metal$/ {on = 1; next} /^```$/ {on = 0} on' "$source/runtime/shadow/README.md" >"$output/ShadowCatcher.metal"
for name in $(grep -oE '@"[a-z_]+_(vertex|fragment|corner|catcher)"' "$source/toolchains/ios/sample/SandViewController.mm" | tr -d '@"'); do
  grep -qE "^(vertex|fragment) [A-Za-z0-9]+ $name\(" "$source/toolchains/ios/sample/Shaders.metal" "$output/ShadowCatcher.metal" ||
    { echo "no Metal function $name"; exit 1; }
done
