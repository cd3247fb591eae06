#!/usr/bin/env python3
"""The texel of a cube that the library takes for a direction is the one that WebGL takes, for 4,096 directions. The control: a
left-handed cube is nearly always another texel.

cube_test.py CUBE_TEXELS                  Exit code 77: there is no Chromium here."""
import json
import random
import shutil
import subprocess
import sys

from browser import Browser

SKIPPED, SIDE, TEXELS = 77, 64, 8
SAMPLE = """
(given) => {
  const canvas = Object.assign(document.createElement("canvas"), { width: given.side, height: given.side });
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true }), program = gl.createProgram();
  const vertex = "#version 300 es\\nvoid main() { gl_Position = vec4(vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2. - 1., 0, 1); }";
  const fragment = "#version 300 es\\nprecision highp float; uniform highp samplerCube cube; uniform highp sampler2D directions; out vec4 texel;" +
    "void main() { texel = texture(cube, texelFetch(directions, ivec2(gl_FragCoord.xy), 0).xyz); }";
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const bind = (unit, kind, name) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, gl.createTexture());
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(kind, filter, gl.NEAREST);
    gl.uniform1i(gl.getUniformLocation(program, name), unit);
  };
  bind(0, gl.TEXTURE_CUBE_MAP, "cube");
  const n = given.texels;
  for (let face = 0; face < 6; ++face) {
    const texels = new Uint8Array(4 * n * n);
    for (let i = 0; i < n * n; ++i) texels.set([face, i % n, Math.floor(i / n), 255], 4 * i);
    gl.texImage2D(gl.TEXTURE_CUBE_MAP_POSITIVE_X + face, 0, gl.RGBA8, n, n, 0, gl.RGBA, gl.UNSIGNED_BYTE, texels);
  }
  bind(1, gl.TEXTURE_2D, "directions");
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, given.side, given.side, 0, gl.RGBA, gl.FLOAT, new Float32Array(given.directions));
  gl.viewport(0, 0, given.side, given.side);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const pixels = new Uint8Array(4 * given.side ** 2);
  gl.readPixels(0, 0, given.side, given.side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return [...pixels].filter((_, i) => i % 4 !== 3);
}"""


def main(arguments):
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        return SKIPPED
    draw = random.Random(5)
    directions = [[draw.uniform(-1, 1) for _ in range(3)] for _ in range(SIDE * SIDE)]
    lines = "\n".join(" ".join(map(str, d)) for d in directions)
    ours = subprocess.run([arguments[0]], input=lines, capture_output=True, text=True, check=True).stdout.splitlines()
    browser = Browser(program, flags=("--use-angle=swiftshader", "--enable-unsafe-swiftshader"))
    try:
        given = {"side": SIDE, "texels": TEXELS, "directions": [x for d in directions for x in d + [1]]}
        drawn = browser.ask(f"({SAMPLE})({json.dumps(given)})")
    finally:
        browser.close()
    same = left = 0
    for i, line in enumerate(ours):
        numbers = list(map(int, line.split()))
        same += numbers[:3] == drawn[3 * i : 3 * i + 3]
        left += numbers[3:] == drawn[3 * i : 3 * i + 3]
    print(f"of {len(directions)} directions the same texel: {same}; as a left-handed cube: {left}")
    # A direction within rounding of a texel's edge may fall to either side.
    return 0 if same >= len(directions) - 4 and left < len(directions) / 10 else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
