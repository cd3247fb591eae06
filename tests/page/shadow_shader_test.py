#!/usr/bin/env python3
"""The shader of runtime/shadow/README.md as a browser draws it: each pixel of the floor is within a step of a byte of the formula
above it, where object and sand lie in each other's shadow, and beyond the textures' rectangles, whose rims are dark.

shadow_shader_test.py README              --control: a sampler that clamps instead must be noticed
Exit code 77: there is no Chromium here."""
import json
import random
import re
import shutil
import sys

from browser import Browser

SKIPPED, SIDE, TEXELS = 77, 48, 8
DRAW = """
(given) => {
  const canvas = Object.assign(document.createElement("canvas"), { width: given.side, height: given.side });
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true }), program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, given.vertex], [gl.FRAGMENT_SHADER, given.fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  gl.useProgram(program);
  const at = (name) => gl.getUniformLocation(program, name);
  given.textures.forEach(([name, side, bytes], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const [stored, format] = name === "camera_image" ? [gl.RGB8, gl.RGB] : [gl.R8, gl.RED];
    gl.texImage2D(gl.TEXTURE_2D, 0, stored, side, side, 0, format, gl.UNSIGNED_BYTE, new Uint8Array(bytes));
    for (const [key, value] of [["MIN_FILTER", gl.LINEAR], ["MAG_FILTER", gl.LINEAR], ["WRAP_S", gl.CLAMP_TO_EDGE], ["WRAP_T", gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, gl["TEXTURE_" + key], value);
    gl.uniform1i(at(name), unit);
  });
  for (const [name, value] of given.uniforms) {
    const set = { 1: "1f", 2: "2fv", 4: "4fv", 16: "Matrix4fv" }[value.length ?? 1];
    if (set === "1f") gl.uniform1f(at(name), value);
    else if (set === "Matrix4fv") gl.uniformMatrix4fv(at(name), false, value);
    else gl["uniform" + set](at(name), value);
  }
  gl.viewport(0, 0, given.side, given.side);
  gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  const pixels = new Uint8Array(4 * given.side ** 2);
  gl.readPixels(0, 0, given.side, given.side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return [...pixels].filter((_, i) => i % 4 === 1);
}"""


def decoded(byte):
    c = byte / 255
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def encoded(linear):
    return 255 * (12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055)


def sampled(texels, rectangle, x, z, outside):
    """Bilinear, clamped at the rim; `outside` beyond the rectangle."""
    u, v = (x - rectangle[0]) / (rectangle[2] - rectangle[0]), (z - rectangle[1]) / (rectangle[3] - rectangle[1])
    if not (0 <= u <= 1 and 0 <= v <= 1):
        return outside
    a, b = min(max(u * TEXELS - 0.5, 0), TEXELS - 1), min(max(v * TEXELS - 0.5, 0), TEXELS - 1)
    i, j = min(int(a), TEXELS - 2), min(int(b), TEXELS - 2)
    fa, fb, t = a - i, b - j, lambda row, column: texels[row * TEXELS + column] / 255
    return (1 - fb) * ((1 - fa) * t(j, i) + fa * t(j, i + 1)) + fb * ((1 - fa) * t(j + 1, i) + fa * t(j + 1, i + 1))


def main(arguments):
    control = "--control" in arguments
    text = open([a for a in arguments if not a.startswith("--")][0], encoding="utf-8").read()
    vertex, fragment = re.findall(r"```glsl\n(.*?)```", text, re.S)[:2]
    if control:
        fragment = fragment.replace("p == clamp(p, 0.0, 1.0) ? texture(map, p).r : outside", "texture(map, p).r")
    program = shutil.which("chromium") or shutil.which("chromium-browser")
    if program is None:
        return SKIPPED
    draw = random.Random(7)
    rectangles = {"object_light": [-0.5, -0.4, 0.3, 0.5], "object_ambient": [-0.7, -0.6, 0.6, 0.7], "sand_rectangle": [0.1, 0.0, 0.9, 0.8]}
    shift, quad, floor = [0.2, 0.1], [-1, -1, 1, 1], 180
    browser = Browser(program, flags=("--use-angle=swiftshader", "--enable-unsafe-swiftshader"))
    worst = 0
    try:
        for s in (0.0, 0.35, 0.8, 1.0):
            names = ("object_coverage", "object_visibility", "sand_coverage", "sand_visibility")
            maps = {name: [draw.randrange(256) for _ in range(TEXELS * TEXELS)] for name in names}
            opacity = [0.9, 0.7]
            uniforms = {**rectangles, "opacity": opacity, "s": s, "viewport": [SIDE, SIDE], "quad": quad, "plane": 0.0,
                        # x and z of the mesh to clip space; and to the world: turned by a quarter, and moved
                        "clip_from_object": [1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1],
                        "world_from_object": [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, shift[0], 0, shift[1], 1]}
            textures = [[name, TEXELS, maps[name]] for name in names] + [["camera_image", 1, [floor] * 3]]
            given = {"side": SIDE, "vertex": vertex, "fragment": fragment, "textures": textures, "uniforms": list(uniforms.items())}
            drawn = browser.ask(f"({DRAW})({json.dumps(given)})")
            for row in range(SIDE):
                for column in range(SIDE):
                    x, z = 2 * (column + 0.5) / SIDE - 1, 2 * (row + 0.5) / SIDE - 1
                    world = (z + shift[0], -x + shift[1])
                    sharp = (1 - opacity[0] * sampled(maps["object_coverage"], rectangles["object_light"], x, z, 0)) * (
                        1 - opacity[1] * sampled(maps["sand_coverage"], rectangles["sand_rectangle"], *world, 0))
                    rest = max(sampled(maps["object_visibility"], rectangles["object_ambient"], x, z, 1) - s, 0) * max(
                        sampled(maps["sand_visibility"], rectangles["sand_rectangle"], *world, 1) - s, 0)
                    left = s * sharp + (rest / (1 - s) if s < 1 else 0)
                    worst = max(worst, abs(drawn[row * SIDE + column] - encoded(decoded(floor) * left)))
    finally:
        browser.close()
    print(f"farthest from the formula: {worst:.2f} steps of a byte")
    return 0 if (worst <= 1.5) != control else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
