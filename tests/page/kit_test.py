#!/usr/bin/env python3
"""The program's picture of sand is the picture that a browser draws by the kit's own GLSL. The control: where the GLSL is another
in one place, it is not.

kit_test.py KIT_PICTURE KIT FOLDER      FOLDER gets kit.png: pairs of the browser's picture and the program's, controls last.
Exit code 77: there is no Chromium here."""

import base64
import json
import pathlib
import subprocess
import sys

from browser import CHROMIUM, SKIPPED, SOFTWARE, USED_PROGRAM, Browser

STEPS = 4  # of 255
# Of each picture: its parts; the share of pixels of sand that may differ by more; the share by which the sum of all may. On the
# surface 0.45 % do, nearly all where a number's last bits tell whether a facet mirrors the light: without, 0.02 %. SwiftShader
# moves ends of lines and corners of points by up to 1/32 of a pixel, and every 30th pixel of a point 2 pixels wide is so near to
# its rim: of loose sand 4.9 % differ. The smooth picture has its samples elsewhere in a pixel: of those that an edge cuts many
# differ (11 % of all), but the sum does not.
ALL = ["surface", "flying", "lying"]
LIMITS = {
    "surface": (["surface"], 0.01, 0.001),
    "loose": (["flying", "lying"], 0.08, 0.02),
    "all": (ALL, 0.02, 0.002),
    "smooth": (ALL, 0.15, 0.002),
}
CONTROLS = [
    ("surface", "k_own = 1.45", "k_own = 1.1"),
    ("surface", "k_sharper = 0.6", "k_sharper = 0.7"),
    ("surface", "smooth_normal = normal", "smooth_normal = vec3(-1, 1, 1) * normal"),
    ("loose", "k_clouds = 16u", "k_clouds = 15u"),
]
HEAD = (
    "#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\nfloat hidden(vec3 world) { return 0.0; }\n"
)
STAGES = {
    "surface.vert": ["uniforms"],
    "surface.frag": ["uniforms", "light", "sand", "levels", "surface"],
    "loose.vert": ["uniforms", "light", "sand", "loose"],
    "loose.frag": ["uniforms", "light", "sand", "loose"],
}
DRAW = (
    "(given) => {"
    + USED_PROGRAM
    + """
  const [width, height] = given.size, bytes = (hex) => Uint8Array.from(hex.match(/../g), (two) => parseInt(two, 16));
  document.body.style.background = "black";
  const [canvas, beside] = [0, 1].map(() => document.body.appendChild(Object.assign(document.createElement("canvas"), { width, height })));
  beside.getContext("2d").putImageData(new ImageData(Uint8ClampedArray.from(bytes(given.ours), (b, i) => i % 4 === 3 ? 255 : b), width), 0, 0);
  const gl = canvas.getContext("webgl2", { antialias: given.smooth, preserveDrawingBuffer: true }), block = bytes(given.block);
  gl.enable(gl.DEPTH_TEST);
  for (const which of [0, 1]) {
    gl.activeTexture(gl.TEXTURE1 + which);
    gl.bindTexture(gl.TEXTURE_3D, gl.createTexture());
    gl.texParameteri(gl.TEXTURE_3D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    for (let side = 64, level = 0, at = 0; side >= 1; at += 8 * side ** 3, side >>= 1, ++level)
      gl.texImage3D(gl.TEXTURE_3D, level, gl.RGBA8, side, side, side, 0, gl.RGBA, gl.UNSIGNED_BYTE, block.subarray(at + which * 4 * side ** 3));
  }
  const use = (name) => {
    const program = used(gl, given[name + ".vert"], given[name + ".frag"]);
    const setters = { [gl.FLOAT]: "1fv", [gl.FLOAT_VEC3]: "3fv", [gl.FLOAT_VEC4]: "4fv", [gl.FLOAT_MAT3]: "Matrix3fv", [gl.FLOAT_MAT4]: "Matrix4fv" };
    for (let i = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) - 1; i >= 0; --i) {
      const { name, type } = gl.getActiveUniform(program, i), value = given[name.replace("[0]", "")], at = gl.getUniformLocation(program, name);
      if (value) gl["uniform" + setters[type]](at, ...(setters[type][0] === "M" ? [false, value] : [value]));
      else if (type === gl.SAMPLER_3D) gl.uniform1i(at, name === "grains" ? 1 : 2);
    }
    return program;
  };
  const upload = (kind, hex) => { gl.bindBuffer(kind, gl.createBuffer()), gl.bufferData(kind, bytes(hex), gl.STATIC_DRAW); };
  const drawSurface = () => {
    use("surface"), upload(gl.ARRAY_BUFFER, given.vertices), upload(gl.ELEMENT_ARRAY_BUFFER, given.indices);
    [[3, gl.FLOAT, 0], [3, gl.BYTE, 12], [1, gl.UNSIGNED_BYTE, 15], [3, gl.UNSIGNED_SHORT, 16], [1, gl.SHORT, 22]].forEach(([size, type, from], at) => {
      gl.enableVertexAttribArray(at), gl.vertexAttribPointer(at, size, type, type !== gl.FLOAT, 24, from);
    });
    gl.drawElements(gl.TRIANGLES, given.indices.length / 8, gl.UNSIGNED_INT, 0);
    for (const at of [3, 4]) gl.disableVertexAttribArray(at);
  };
  const drawLoose = (flies, grains, first, count) => {
    gl.uniform1f(gl.getUniformLocation(use("loose"), "flies"), flies), upload(gl.ARRAY_BUFFER, given.particles);
    for (const at of [0, 1, 2]) gl.enableVertexAttribArray(at), gl.vertexAttribDivisor(at, 1);
    for (const at of [0, 1]) gl.vertexAttribPointer(at, 4 - at, gl.FLOAT, false, 32, 32 * first + 16 * at);
    gl.vertexAttribIPointer(2, 1, gl.UNSIGNED_INT, 32, 32 * first + 28);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint16Array.from({ length: 6 * grains }, (_, i) => 4 * Math.floor(i / 6) + [0, 1, 2, 2, 1, 3][i % 6]), gl.STATIC_DRAW);
    gl.drawElementsInstanced(gl.TRIANGLES, 6 * grains, gl.UNSIGNED_SHORT, 0, count);
  };
  if (given.parts.includes("surface")) drawSurface();
  if (given.parts.includes("flying")) drawLoose(1, 384, 0, given.flying);
  if (given.parts.includes("lying")) drawLoose(0, 256, given.flying, given.particles.length / 64 - given.flying);
  const pixels = new Uint8Array(4 * width * height);
  for (let y = 0; y < height; ++y) gl.readPixels(0, height - 1 - y, width, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixels, 4 * width * y);
  if (gl.getError()) throw new Error("WebGL refuses a call");
  return btoa(Array.from(pixels, (byte) => String.fromCharCode(byte)).join(""));
}"""
)


def main(arguments):
    if CHROMIUM is None:
        return SKIPPED
    given, kit, failures = json.loads(subprocess.check_output([arguments[0]])), pathlib.Path(arguments[1]), 0
    sources = {
        stage: HEAD + "".join((kit / part).read_text() for part in [f"{b}.glsl" for b in before] + [stage])
        for stage, before in STAGES.items()
    }
    browser = Browser(CHROMIUM, width=1320, height=1020, flags=SOFTWARE)
    try:
        for name, old, new in [(name, "", "") for name in LIMITS] + CONTROLS:
            parts, most, most_of_sum = LIMITS[name]
            texts = {stage: text.replace(old, new) if old else text for stage, text in sources.items()}
            order = {**given, **texts, "parts": parts, "smooth": name == "smooth", "ours": given[name]}
            theirs, ours = base64.b64decode(browser.ask(f"({DRAW})({json.dumps(order)})")), bytes.fromhex(given[name])
            worst = [
                max(abs(ours[k] - theirs[k]) for k in range(i, i + 4)) for i in range(0, len(ours), 4) if ours[i + 3] + theirs[i + 3] > 0
            ]
            share, of_sum = sum(w > STEPS for w in worst) / len(worst), abs(sum(ours) / sum(theirs) - 1)
            print(f"{name} {new}: of {len(worst)} pixels {share:.2%} differ by more than {STEPS} of 255, the sum by {of_sum:.2%}")
            # A control is far beyond the limit.
            failures += share < 5 * most if old else share > most or of_sum > most_of_sum
        pathlib.Path(arguments[2]).mkdir(parents=True, exist_ok=True)
        browser.screenshot(pathlib.Path(arguments[2]) / "kit.png", whole=True)
    finally:
        browser.close()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
