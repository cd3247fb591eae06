#!/usr/bin/env python3
"""Writes what the npm package makes of other files: python3 pack.py NPM_FOLDER KIT_FOLDER SAND_BLOCK_MODULE

kit.mjs          the sand kit's GLSL, without comments: an engine's reader may take a `;` in one for an end
inlined.mjs      sandglass.wasm as text; block_module.mjs: sand_block.wasm
worker_text.mjs  what runs in a worker, as one text
README.md        without the marks of its numbers and without links to what the package has not
"""

import base64
import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "models/page"))
from assemble import joined

IN_WORKER = (
    "sandglass",
    "skin_changes",
    "sand_block",
    "options",
    "mesh_field",
    "place_light",
    "stage_hands",
    "stage_place",
    "stage_shadows",
    "worker",
    "stage",
    "worker_commands",
)


def module(path, **constants):
    path.write_text("// Made by pack.py.\n" + "".join(f"export const {name} = {json.dumps(value)};\n" for name, value in constants.items()))


def encoded(file):
    return base64.b64encode(file.read_bytes()).decode()


def main():
    npm, kit, block = map(pathlib.Path, sys.argv[1:])
    texts = {
        file.name.replace(".glsl", "").replace(".", "_"): re.sub(r" *//.*", "", file.read_text())
        for file in sorted(kit.iterdir())
        if file.suffix in (".glsl", ".vert", ".frag")
    }
    module(npm / "kit.mjs", k_kit=texts)
    module(npm / "inlined.mjs", k_inlined=encoded(npm / "sandglass.wasm"))
    module(npm / "block_module.mjs", k_block_text=encoded(block))
    text = joined([npm / f"{name}.mjs" for name in IN_WORKER]).replace("import.meta.url", "location.href")
    module(npm / "worker_text.mjs", text=text.replace("k_own_worker = false", "k_own_worker = true"))
    (npm / "README.md").write_text(re.sub(r"<!--.*?-->|!\[.*\n\n|\[([^]]*)\]\(\.\./[^)]*\)", r"\1", pathlib.Path("README.md").read_text()))


main()
