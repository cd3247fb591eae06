#!/usr/bin/env bash
# The reference compiler accepts the GLSL of the shadow catcher and of the sand in the README, and refuses a control with
# a fault.
#   shaders.sh README WORK_FOLDER
# Exit code 77: glslangValidator is not installed (Debian: glslang-tools).
set -euo pipefail
command -v glslangValidator >/dev/null || exit 77
readme=$1 work=$2
rm -rf "$work" && mkdir -p "$work"
awk -v work="$work" '/^```glsl$/ {n++; on = 1; next} /^```$/ {on = 0} on {print >(work "/" n ".glsl")}' "$readme"
[[ -s $work/3.glsl && ! -e $work/4.glsl ]] || { echo "the README holds other shaders than those tested here"; exit 1; }
glslangValidator -S vert "$work/1.glsl"
glslangValidator -S frag "$work/2.glsl"
glslangValidator -S frag "$work/3.glsl"
# The outputs of the vertex shader must be the inputs of the fragment shader.
cp "$work/1.glsl" "$work/catcher.vert" && cp "$work/2.glsl" "$work/catcher.frag"
glslangValidator -l "$work/catcher.vert" "$work/catcher.frag"
sed 's/^in vec2 texture_position/in vec2 elsewhere/' "$work/2.glsl" >"$work/wrong.frag"
if glslangValidator "$work/wrong.frag" >/dev/null; then echo "a shader with a fault was accepted"; exit 1; fi
