#!/usr/bin/env python3
"""The shader of runtime/shadow/README.md, Android's, and what the live page leaves of a table's light, as a browser draws them: each pixel of
the floor is within a step of a byte of the formula, where two objects and sand lie in each other's shadow, beyond the textures'
rectangles, whose rims are dark, and behind what is real.

shadow_shader_test.py README PAINTER SAND_CPP      --control: a sampler that clamps instead must be noticed
                                                   --depth: and an eye below the plane that is taken for one above
Exit code 77: there is no Chromium here."""

import json
import pathlib
import random
import re
import sys

from browser import CHROMIUM, SKIPPED, SOFTWARE, USED_PROGRAM, Browser

SIDE, TEXELS, BIAS = 48, 8, 0.2
WHOLE = """#version 300 es
void main() { gl_Position = vec4(2 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID >> 1) - 1, 0, 1); }"""
EYES = (0.8, 0.1, -0.3)  # metres above the plane: as usual, low, and below a shelf
DRAW = (
    "(given) => {"
    + USED_PROGRAM
    + """
  const canvas = Object.assign(document.createElement("canvas"), { width: given.side, height: given.side });
  const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true }), program = used(gl, given.vertex, given.fragment);
  const at = (name) => gl.getUniformLocation(program, name);
  given.textures.forEach(([name, side, bytes, rows = side], unit) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    const whole = name === "depth", filter = whole ? gl.NEAREST : gl.LINEAR;  // of Android: numbers of 16 bits
    const [stored, format] = name === "camera_image" ? [gl.RGB8, gl.RGB] : whole ? [gl.R16UI, gl.RED_INTEGER] : [gl.R8, gl.RED];
    gl.texImage2D(gl.TEXTURE_2D, 0, stored, side, rows, 0, format, whole ? gl.UNSIGNED_SHORT : gl.UNSIGNED_BYTE, new (whole ? Uint16Array : Uint8Array)(bytes));
    for (const [key, value] of [["MIN_FILTER", filter], ["MAG_FILTER", filter], ["WRAP_S", gl.CLAMP_TO_EDGE], ["WRAP_T", gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, gl["TEXTURE_" + key], value);
    gl.uniform1i(at(name), unit);
  });
  for (const [name, value] of given.uniforms) {
    const set = { 1: "1f", 2: "2fv", 3: "3fv", 4: "4fv", 9: "Matrix3fv", 16: "Matrix4fv" }[value.length ?? 1];
    if (set === "1f") gl.uniform1f(at(name), value);
    else if (set.startsWith("Matrix")) gl["uniform" + set](at(name), false, value);
    else gl["uniform" + set](at(name), value);
  }
  gl.viewport(0, 0, given.side, given.side);
  gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  const pixels = new Uint8Array(4 * given.side ** 2);
  gl.readPixels(0, 0, given.side, given.side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return [...pixels].filter((_, i) => i % 4 === given.channel);
}"""
)


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


def hidden(metres, x, z, bias, heights):
    """By a depth map over the whole picture, where what is drawn is 1 m away. `heights`: of eye and point above each plane: what is
    real lies on it up to the bias, or to a quarter of a low eye's height; an eye below it sees nothing that does."""

    def by(byte):
        real = byte / 255
        over = [(eye + (point - eye) * real) / min(bias, eye / 4) for eye, point in heights if eye > 0]
        t = min(max(min([(1 - real) / bias] + over) - 1, 0), 1)
        return 255 * t * t * (3 - 2 * t) if real > 0 else 0

    return sampled([by(byte) for byte in metres], [-1, -1, 1, 1], x, z, None)


def farthest(browser, vertex, fragment, uniforms, textures, formula, channel="green"):
    """How far a channel of the picture is from `formula(x, z)`, in steps of a byte."""
    given = {
        "side": SIDE,
        "channel": ["red", "green", "blue", "alpha"].index(channel),
        "vertex": vertex,
        "fragment": fragment,
        "uniforms": list(uniforms.items()),
        "textures": textures,
    }
    places = [2 * (i + 0.5) / SIDE - 1 for i in range(SIDE)]
    return max(
        abs(drawn - formula(places[i % SIDE], places[i // SIDE])) for i, drawn in enumerate(browser.ask(f"({DRAW})({json.dumps(given)})"))
    )


def box_of(r):
    return [*r[:2], 1 / (r[2] - r[0]), 1 / (r[3] - r[1])]


def noise_of(names, draw):
    return {name: [draw.randrange(256) for _ in range(TEXELS * TEXELS)] for name in names}


def farthest_on_page(browser, lighting, draw, eye):
    """Of models/page/painter.mjs: what both lights and the sky leave of a table, in steps of a byte."""
    fragment = f"""#version 300 es
precision highp float;
precision highp sampler3D;
{lighting}
out vec4 pixel;
void main() {{
  vec3 place = vec3(gl_FragCoord.x, 0, gl_FragCoord.y) * (2.0 / {SIDE}.0) - vec3(1, 0, 1);
  pixel = vec4(vec3(mix(object_passed(place) * pile_passed(place) * opened(place) * under_sky(place), 1.0, hidden(place))), 1);
}}"""
    rectangles = {"pile": [0.1, 0.0, 0.9, 0.8], "shadow": [-0.5, -0.4, 0.3, 0.5], "occlusion": [-0.7, -0.6, 0.6, 0.7]}
    maps = noise_of(("pile", "shadow", "occlusion", "sky", "real_depth"), draw)
    # A wall at z = -0.2, and an eye in front of it.
    uniforms = {
        **{f"{name}_box": box_of(r) for name, r in rectangles.items()},
        "pile_opacity": 0.7,
        "shadow_opacity": 0.9,
        "sky_known": 1.0,
        "bias": BIAS,
        "eye": [0.3, eye, 0.9],
        "to_light": [0, 1, 0],
        "wall": [0, 0, 1, 0.2],
        "on_plane": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
        "depth_from_screen": [1 / SIDE, 0, 0, 0, 1 / SIDE, 0, 0, 0, 1],
    }

    def formula(x, z):
        left = (
            (1 - 0.7 * sampled(maps["pile"], rectangles["pile"], x, z, 0))
            * sampled(maps["sky"], rectangles["pile"], x, z, 1)
            * (1 - 0.9 * sampled(maps["shadow"], rectangles["shadow"], x, z, 0))
            * sampled(maps["occlusion"], rectangles["occlusion"], x, z, 1)
        )
        away = hidden(maps["real_depth"], x, z, BIAS, [(eye, 0), (1.1, z + 0.2)])
        return 255 * (left + (1 - left) * away)

    return farthest(browser, WHOLE, fragment, uniforms, [[name, TEXELS, maps[name]] for name in maps], formula)


def between(layers, rectangle, at, u, v, outside):
    """Of layers one after the other, `at` of them up."""
    at = min(max(at, 0), len(layers) - 1)
    lower = min(int(at), len(layers) - 2)
    low, high = (sampled(layers[layer], rectangle, u, v, outside) for layer in (lower, lower + 1))
    return low + (at - lower) * (high - low)


def farthest_on_sample(browser, fragment, draw, eye):
    """Of toolchains/android/sample/sand.cpp: what it leaves of the table's light, in steps of a byte."""
    fragment = "#version 300 es\n" + fragment
    vertex = """#version 300 es
out vec2 place;
void main() { place = vec2(2 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID >> 1) - 1); gl_Position = vec4(place, 0, 1); }"""
    rectangles = {
        "object": [-0.5, -0.4, 0.3, 0.5],
        "object_room": [-0.7, -0.6, 0.6, 0.7],
        "sand": [0.1, 0.0, 0.9, 0.8],
        "sand_room": [0.1, 0.0, 0.9, 0.8],
    }
    number, height, slide, place_of_eye, s = 3, 0.15, [0.9, -0.4], [0.3, -0.6], 0.35
    maps = {name: [noise_of([name], draw)[name] for _ in range(number if "object" in name else 1)] for name in rectangles}
    depth = [51 * draw.randrange(6) for _ in range(TEXELS * TEXELS)]
    uniforms = {
        "s": s,
        "sand_opacity": 0.7,
        "viewport": [SIDE, SIDE],
        "eye": place_of_eye,
        "eye_height": eye,
        "bias": BIAS,
        "height": height,
        "slide": slide,
        "layers": [number, number],
        "depth_from_screen": [1, 0, 0, 0, 1, 0, 0, 0, 1],
        **{f"{name}_box": box_of(r) for name, r in rectangles.items()},
    }

    def stands(byte):
        """What is drawn is 1 m away."""
        real = byte / 255
        before = eye * (1 - real) if eye > 0 else 1 - real
        t = min(max(before / BIAS - 1, 0), 1)
        return 255 * t * t * (3 - 2 * t) * (before if eye > 0 else 2 * height) if real > 0 else 0

    above = [stands(byte) for byte in depth]

    def formula(x, z):
        up = sampled(above, [-1, -1, 1, 1], x, z, None)
        share = up / eye if eye > 0 else 0
        place = [c + (e - c) * share for c, e in zip((x, z), place_of_eye)]

        def at(name, outside, along=(0, 0)):
            u, v = (c - up * d for c, d in zip(place, along))
            if len(maps[name]) == 1:
                return sampled(maps[name][0], rectangles[name], u, v, outside)
            return between(maps[name], rectangles[name], up / height * (number - 1), u, v, outside)

        left = s * (1 - at("object", 0, slide)) * (1 - 0.7 * at("sand", 0))
        left += max(at("object_room", 1) - s, 0) * max(at("sand_room", 1) - s, 0) / (1 - s)
        t = min(max(up / height - 1, 0), 1)
        left += (1 - left) * t * t * (3 - 2 * t)
        return 255 * (1 - left ** (1 / 2.2))  # opacity of the black that is blended over the table

    textures = [[name, TEXELS, sum(layers, []), len(layers) * TEXELS] for name, layers in maps.items()]
    textures += [["depth", TEXELS, [1000 * byte // 255 for byte in depth]]]
    return farthest(browser, vertex, fragment, uniforms, textures, formula, "alpha")


def farthest_on_readme(browser, vertex, fragment, draw, s, eye):
    """Of runtime/shadow/README.md with a third object, in steps of a byte. `s`: the main light's share."""
    rectangles = {
        "object_light": [-0.5, -0.4, 0.3, 0.5],
        "object_ambient": [-0.7, -0.6, 0.6, 0.7],
        "sand_rectangle": [0.1, 0.0, 0.9, 0.8],
        "third_rectangle": [-0.2, -0.9, 0.8, 0.2],
    }
    shift, quad, floor = [0.2, 0.1], [-1, -1, 1, 1], 180
    names = [f"{of}_{what}" for of in ("object", "sand", "third") for what in ("coverage", "visibility")]
    maps, opacity, depth = noise_of(names, draw), [0.9, 0.7], noise_of(["depth"], draw)["depth"]
    uniforms = {
        **rectangles,
        "opacity": opacity,
        "s": s,
        "viewport": [SIDE, SIDE],
        "quad": quad,
        "plane": 0.0,
        "depth_from_screen": [1, 0, 0, 0, 1, 0, 0, 0, 1],
        "eye_height": eye,
        "bias": BIAS,
        # x and z of the mesh to clip space; and to the world: turned by a quarter, and moved
        "clip_from_object": [1, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1],
        "world_from_object": [0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, shift[0], 0, shift[1], 1],
    }
    textures = [[name, TEXELS, maps[name]] for name in names] + [["real_depth", TEXELS, depth], ["camera_image", 1, [floor] * 3]]

    def formula(x, z):
        world = (z + shift[0], -x + shift[1])
        sharp = (
            (1 - opacity[0] * sampled(maps["object_coverage"], rectangles["object_light"], x, z, 0))
            * (1 - opacity[1] * sampled(maps["sand_coverage"], rectangles["sand_rectangle"], *world, 0))
            * (1 - opacity[0] * sampled(maps["third_coverage"], rectangles["third_rectangle"], x, z, 0))
        )
        rest = (
            max(sampled(maps["object_visibility"], rectangles["object_ambient"], x, z, 1) - s, 0)
            * max(sampled(maps["sand_visibility"], rectangles["sand_rectangle"], *world, 1) - s, 0)
            * max(sampled(maps["third_visibility"], rectangles["third_rectangle"], x, z, 1) - s, 0)
        )
        left = s * sharp + (rest / (1 - s) ** 2 if s < 1 else 0)
        left += (1 - left) * hidden(depth, x, z, BIAS, [(eye, 0)])
        return encoded(decoded(floor) * left)

    return farthest(browser, vertex, fragment, uniforms, textures, formula)


def farthest_on_heap(browser, lighting, draw):
    """Of models/kit/light.glsl: an object's shadow on sand that rises through three layers, in steps of a byte."""
    floor, height, number, towards, rectangle = 0.03, 0.2, 3, [-0.6, 0.7, 0.3], [-0.8, -0.6, 0.5, 0.7]
    fragment = f"""#version 300 es
precision highp float;
precision highp sampler3D;
{lighting}
out vec4 pixel;
void main() {{
  vec2 place = gl_FragCoord.xy * (2.0 / {SIDE}.0) - 1.0;
  pixel = vec4(vec3(object_passed(vec3(place.x, 0.1 + 0.2 * place.x, place.y))), 1);
}}"""
    layers = [noise_of(["shadow"], draw)["shadow"] for _ in range(number)]
    uniforms = {
        "shadow_box": box_of(rectangle),
        "shadow_layers": [number, (number - 1) / height, 0.5 / TEXELS],
        "shadow_opacity": 0.9,
        "to_light": towards,
        "on_plane": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -floor, 0, 1],
    }

    def formula(x, z):
        above = 0.1 + 0.2 * x - floor
        at = [c - above * towards[k] / towards[1] for k, c in ((0, x), (2, z))]
        return 255 * (1 - 0.9 * between(layers, rectangle, above / height * (number - 1), *at, 0))

    return farthest(browser, WHOLE, fragment, uniforms, [["shadow", TEXELS, sum(layers, []), number * TEXELS]], formula)


def farthest_on_receiver(browser, receive, draw):
    """Of models/kit/receive.glsl on a slope through three layers, in steps of a byte."""
    floor, height, number, slide = 0.03, 0.2, 3, [0.9, -0.4]
    fragment = f"""#version 300 es
precision highp float;
{receive}
out vec4 pixel;
void main() {{
  vec2 place = gl_FragCoord.xy * (2.0 / {SIDE}.0) - 1.0, left = sandglass_left(vec3(place.x, 0.1 + 0.2 * place.x, place.y));
  pixel = vec4(vec3(left.x * left.y), 1);
}}"""
    rectangles = {"pile": [0.1, 0.0, 0.9, 0.8], "shadow": [-0.8, -0.6, 0.5, 0.7], "occlusion": [-0.9, -0.6, 0.6, 0.7]}
    one = noise_of(("pile", "sky"), draw)
    layers = {name: [noise_of([name], draw)[name] for _ in range(number)] for name in ("shadow", "occlusion")}
    uniforms = {
        **{f"sandglass_{name}_box": box_of(r) for name, r in rectangles.items()},
        "sandglass_numbers": [0.7, 0.9, 1.0, floor],
        "sandglass_slide": [*slide, 0.5 / TEXELS, 0.5 / TEXELS],
        "sandglass_layers": [number, (number - 1) / height, 0, 0],
    }
    textures = [[f"sandglass_{name}", TEXELS, texels] for name, texels in one.items()]
    textures += [[f"sandglass_{name}", TEXELS, sum(all_of_it, []), number * TEXELS] for name, all_of_it in layers.items()]

    def formula(x, z):
        above = 0.1 + 0.2 * x - floor

        def layered(name, *place):
            return between(layers[name], rectangles[name], above / height * (number - 1), *place)

        hidden_by_object = 0.9 * layered("shadow", x - slide[0] * above, z - slide[1] * above, 0)
        left = (1 - 0.7 * sampled(one["pile"], rectangles["pile"], x, z, 0)) * (1 - hidden_by_object)
        return 255 * left * layered("occlusion", x, z, 1) * sampled(one["sky"], rectangles["pile"], x, z, 1)

    return farthest(browser, WHOLE, fragment, uniforms, textures, formula)


def shaders(arguments):
    """Of the README, vertex and fragment; of the page; of Android's sample; of what receives; of a heap. With an option, each but the last has a fault;
    with --control, all."""
    control = "--control" in arguments
    readme, painter, sand = [a for a in arguments if not a.startswith("--")]
    sample = re.search(
        r'k_table_fragment_shader\[\] = R"glsl\(#version 300 es\n(.*?)\)glsl"', open(sand, encoding="utf-8").read(), re.S
    ).group(1)
    text = open(readme, encoding="utf-8").read()
    kit = pathlib.Path(painter).resolve().parents[2] / "models/kit"
    occlusion = re.search(r"const k_hidden = `(.*?)`;", open(painter, encoding="utf-8").read(), re.S).group(1)
    lighting = (kit / "uniforms.glsl").read_text() + (kit / "light.glsl").read_text() + (kit / "before.glsl").read_text() + occlusion
    heap, receive = lighting, (kit / "receive.glsl").read_text()
    vertex, fragment = re.findall(r"```glsl\n(.*?)```", text, re.S)[:2]
    # A third object, as the page says: a call more.
    call = "  take(sand_coverage"
    assert call in fragment
    fragment = fragment.replace(
        "in vec2 floor_position",
        "uniform sampler2D third_coverage, third_visibility;\nuniform vec4 third_rectangle;\nin vec2 floor_position",
    )
    fragment = fragment.replace(
        call, "  take(third_coverage, third_rectangle, opacity.x, third_visibility, third_rectangle, floor_position);\n" + call
    )
    if control:
        fragment = fragment.replace("p == clamp(p, 0.0, 1.0) ? texture(map, p).r : outside", "texture(map, p).r")
        lighting = lighting.replace("all(greaterThan(at, vec2(0))) && all(lessThan(at, vec2(1)))", "true")
        sample = sample.replace("p == clamp(p, 0.0, 1.0) ?", "true ?")
        receive = receive.replace("clamp(at.y, half_texel, 1.0 - half_texel)", "at.y")
        heap = heap.replace("clamp(at.y, shadow_layers.z, 1.0 - shadow_layers.z)", "at.y")
    if "--depth" in arguments:
        fragment, sample = (text.replace("eye_height > 0.0", "true") for text in (fragment, sample))
        lighting = lighting.replace("eye > 0.0", "true")
    return vertex, fragment, lighting, sample, receive, heap


def main(arguments):
    vertex, fragment, lighting, sample, receive, heap = shaders(arguments)
    if CHROMIUM is None:
        return SKIPPED
    faulty = "--control" in arguments or "--depth" in arguments
    draw = random.Random(7)
    browser = Browser(CHROMIUM, flags=SOFTWARE)
    try:
        on_readme = [farthest_on_readme(browser, vertex, fragment, draw, s, eye) for s, eye in zip((0.0, 0.35, 0.8, 1.0), EYES + EYES)]
        all_of_them = [
            max(on_readme),
            *(
                max(of(browser, text, draw, eye) for eye in EYES)
                for of, text in ((farthest_on_page, lighting), (farthest_on_sample, sample))
            ),
        ]
        if "--depth" not in arguments:
            all_of_them += [farthest_on_receiver(browser, receive, draw), farthest_on_heap(browser, heap, draw)]
    finally:
        browser.close()
    names = ("on the README's floor", "on the page", "in Android's sample", "on what receives", "on a heap")
    print("farthest from the formula, steps of a byte:", ", ".join(f"{name} {far:.2f}" for name, far in zip(names, all_of_them)))
    return 0 if (min(all_of_them) > 1.5 if faulty else max(all_of_them) <= 1.5) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
