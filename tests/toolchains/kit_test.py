#!/usr/bin/env python3
"""The sand kit: its GLSL compiles for Vulkan, spirv-cross makes Metal and HLSL of it, matc compiles Filament's material, each refuses
a fault, and the block of grains holds what its minerals say.

kit_test.py KIT_FOLDER SAND_BLOCK WORK_FOLDER"""

import math
import pathlib
import shutil
import subprocess
import sys

HEADER = "#version 310 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\n"
PARTS = {
    "surface.vert": ["uniforms"],
    "surface.frag": ["uniforms", "light", "sand", "levels", "surface"],
    "loose.vert": ["uniforms", "light", "sand", "loose"],
    "loose.frag": ["uniforms", "light", "sand", "loose"],
    "plain.frag": [],
}
HOOK = "float hidden(vec3 world) { return 0.0; }\n"
BEACH = [(0.80, 0.66, 0.46, 0.62), (0.90, 0.83, 0.72, 0.24), (0.58, 0.34, 0.17, 0.09), (0.13, 0.115, 0.10, 0.05)]


def ran(*command, folder=None):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


def check(condition, sentence):
    if not condition:
        sys.exit(sentence)


def shader(kit, name):
    return HEADER + "".join((kit / f"{part}.glsl").read_text() for part in PARTS[name]) + HOOK + (kit / name).read_text()


def check_shaders(kit, work):
    for name in PARTS:
        text, code = shader(kit, name), work / f"{name}.spv"
        (work / name).write_text(text)
        (work / f"fault.{name}").write_text(text[: text.rindex("}")])
        made = ran("glslangValidator", "-V", "-R", "--aml", "--amb", work / name, "-o", code)
        check(made.returncode == 0, f"{name}: {made.stdout}")
        check(
            ran("glslangValidator", "-V", "-R", "--aml", "--amb", work / f"fault.{name}", "-o", work / "none").returncode != 0,
            f"{name} with a fault was accepted",
        )
        for language, mark in (
            ("--msl", "[[position]]" if name.endswith("vert") else "fragment "),
            ("--hlsl", "SV_Position" if name.endswith("vert") else "SV_Target"),
        ):
            out = ran("spirv-cross", code, language, *(["--shader-model", "50", "--hlsl-enable-compat"] if language == "--hlsl" else []))
            check(out.returncode == 0 and mark in out.stdout, f"{name} as {language[2:]}: {out.stderr}")
    # What the stages hand to each other: linked, both have the same.
    for kind in ("surface", "loose"):
        linked = ran("glslangValidator", "-l", work / f"{kind}.vert", work / f"{kind}.frag")
        check(linked.returncode == 0, f"{kind}: {linked.stdout}")


def check_filament(kit, work):
    copy = work / "filament"
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(kit, copy)
    made = ran("matc", "-p", "mobile", "-a", "opengl", "-a", "vulkan", "-a", "metal", "-o", work / "sand.filamat", "sand.mat", folder=copy)
    check(made.returncode == 0 and (work / "sand.filamat").stat().st_size > 10000, f"sand.mat: {made.stdout}{made.stderr}")
    (copy / "sand.glsl").write_text((copy / "sand.glsl").read_text().replace("sand_gloss(", "sand_gloss(int fault, "))
    check(ran("matc", "-p", "mobile", "-o", work / "none", "sand.mat", folder=copy).returncode != 0, "a material with a fault was accepted")


def means(path):
    """Of the block's levels: (side, mean of the first texture, mean of the second), each of four numbers from 0 to 1."""
    data, side, out = path.read_bytes(), 64, []
    while side:
        size, two = 4 * side**3, []
        for _ in range(2):
            texture, data = data[:size], data[size:]
            two.append([sum(texture[k::4]) / (255 * side**3) for k in range(4)])
        out.append((side, *two))
        side //= 2
    check(not data, f"{path} has {len(data)} bytes more")
    return out


def check_block(program, work):
    path = work / "sand_block.bin"
    check(ran(program, path).returncode == 0, "no block was made")
    check(ran(program, work / "sand.png").returncode == 0 and (work / "sand.png").read_bytes()[1:4] == b"PNG", "no texture was made")
    levels = means(path)
    # Grains have albedos times 0.8 to 1.2, evenly; 14^3 of them with shares as asked. Their mean is off by chance, at three standard
    # errors of a mean over grains; larger grains fill more, but independently of their mineral.
    for k in range(3):
        wanted = sum(m[k] * m[3] for m in BEACH)
        square = sum(m[3] * m[k] ** 2 for m in BEACH) * (1 + 0.4**2 / 12) - wanted**2
        check(
            abs(levels[0][1][k] - wanted) < 3 * 1.3 * math.sqrt(square / 14**3) + 0.002, f"the block's mean is {levels[0][1]}, not {wanted}"
        )
    for side, one, two in levels[1:]:  # a level's mean is the block's, but for what is cut off at white and black
        check(all(abs(a - b) < 0.02 for a, b in zip(one + two, levels[0][1] + levels[0][2])), f"level of {side}: {one} {two}")
    check(ran(program, work / "grey.bin", "0.5", "0.5", "0.5", "1").returncode == 0, "one mineral was refused")
    grey = means(work / "grey.bin")[0][1]
    check(all(abs(c - 0.5) < 0.01 for c in grey[:3]), f"grey sand is {grey}")
    for wrong in (
        [],
        [path, "1"],
        [path, "0.5", "0.5", "0.5", "x"],
        [path, "2", "0", "0", "1"],
        [work / "none" / "file"],
        [work / "none" / "x.png"],
    ):
        refused = ran(program, *wrong)
        check(refused.returncode != 0 and refused.stderr.count("\n") == 1 and refused.stderr.endswith(".\n"), f"{wrong}: {refused.stderr}")


if __name__ == "__main__":
    kit, program, work = map(pathlib.Path, sys.argv[1:])
    work.mkdir(parents=True, exist_ok=True)
    check_shaders(kit, work)
    check_filament(kit, work)
    check_block(program, work)
