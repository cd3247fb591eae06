#!/usr/bin/env python3
"""No include runs up, or in a circle between folders: a file includes files of its own folder and of those before it.

includes.py ROOT
"""

import pathlib
import re
import sys

# The one list of what may include what. A folder stands for those in it that are not listed.
ORDER = [
    "runtime/include",
    "platform",
    "kernels",
    "runtime/math",
    "runtime/frame",
    "runtime/asset",
    "runtime/solid/sampling",
    "runtime/solid/field",
    "runtime/relief",
    "runtime/sand",
    "runtime/skin",
    "runtime/light",
    "runtime/light/camera",
    "runtime/light/network",
    "runtime/light/room",
    "runtime/light/renderers",
    "runtime/shadow/receiver",
    "runtime/shadow/baked",
    "runtime/shadow/pile",
    "runtime/shadow/cast",
    "runtime/scene",
    "models",
    "toolchains",
    "tests",
]


def place(path):
    """Which of ORDER holds a file, or None."""
    folders = [parent.as_posix() for parent in path.parents if parent.as_posix() in ORDER]
    return ORDER.index(folders[0]) if folders else None


root, faults = pathlib.Path(sys.argv[1]), []
for top in ("platform", "kernels", "runtime", "models", "toolchains"):
    for file in sorted((root / top).rglob("*")):
        if file.suffix not in (".cpp", ".h", ".inl", ".inc", ".mm"):
            continue
        path = file.relative_to(root)
        for name in re.findall(r'^#include "(.+)"', file.read_text(), re.MULTILINE):
            included = pathlib.PurePosixPath("runtime/include", name) if name.startswith("sandglass/") else pathlib.PurePosixPath(name)
            to = place(included)
            if place(path) is None or (to is not None and to > place(path)):
                faults.append(f"{path} includes {name}: {path.parent} comes before {included.parent}")
sys.exit("\n".join(faults + [f"{len(faults)} faults"]) if faults else None)
