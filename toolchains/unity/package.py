#!/usr/bin/env python3
"""Unity's package org.sandglass: the binding, the plug-ins that are built, the sand kit as HLSL, and a .meta beside every file. A GUID is a
hash of the file's path, so what refers to it survives a new version.

package.py BUILDS SANDGLASS_CS VERSION OUTPUT         BUILDS has a folder for each preset that builds a plug-in
"""

import hashlib
import json
import pathlib
import re
import shutil
import subprocess
import sys

# A preset, a file in its build, the folder of the package, and the platforms that take it, with their settings.
PLUGINS = [
    ("host", "unity/libsandglass.so", "Linux", {"Editor: Editor": "CPU: x86_64\n        OS: Linux", "Standalone: Linux64": "CPU: x86_64"}),
    (
        "windows",
        "unity/sandglass.dll",
        "Windows",
        {"Editor: Editor": "CPU: x86_64\n        OS: Windows", "Standalone: Win64": "CPU: x86_64"},
    ),
    ("android", "unity/libsandglass.so", "Android", {"Android: Android": "CPU: ARM64"}),
    ("ios", "runtime/libsandglass.a", "iOS", {"iPhone: iOS": "AddToEmbeddedBinaries: false"}),
]
SHADERS = {"surface.vert": ["uniforms"], "surface.frag": ["uniforms", "light", "sand", "levels", "surface"], "plain.frag": []}
HEAD = "#version 310 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler3D;\n"
HIDDEN = "float hidden(vec3 world) { return 0.0; }  // how much something real hides there\n"
IMPORTERS = {
    ".cs": "MonoImporter:\n",
    ".asmdef": "AssemblyDefinitionImporter:\n",
    ".hlsl": "ShaderIncludeImporter:\n",
    ".json": "PackageManifestImporter:\n",
}
here = pathlib.Path(__file__).parent
KIT = here.parents[1] / "models/kit"
builds, binding, version, output = pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3], pathlib.Path(sys.argv[4])


def platform(name, enabled, settings):
    return f"  - first:\n      {name}\n    second:\n      enabled: {enabled}\n      settings:{settings}\n"


def hlsl(name):
    text = HEAD + "".join((KIT / f"{part}.glsl").read_text() for part in SHADERS[name]) + HIDDEN + (KIT / name).read_text()
    (output / name).write_text(text)
    subprocess.run(
        ["glslangValidator", "-V", "-R", "--aml", "--amb", name, "-o", "code"], cwd=output, check=True, stdout=subprocess.DEVNULL
    )
    made = subprocess.run(
        ["spirv-cross", "code", "--hlsl", "--shader-model", "50", "--hlsl-enable-compat"],
        cwd=output,
        check=True,
        capture_output=True,
        text=True,
    )
    (output / name).unlink()
    (output / "code").unlink()
    # Names that a material can set: sand_wet; samplers as Unity calls them.
    return re.sub(r"\b_([a-z]+)_sampler\b", r"sampler\1", re.sub(r"\b_\d+_([a-z])", r"sand_\1", made.stdout))


shutil.rmtree(output, ignore_errors=True)
for folder in ("Runtime", "Shaders"):
    (output / folder).mkdir(parents=True)
(output / "package.json").write_text(
    json.dumps(
        {
            "name": "org.sandglass",
            "displayName": "Sandglass",
            "version": version,
            "unity": "2021.3",
            "license": "Apache-2.0",
            "description": "Sand, light and shadow for augmented reality",
        },
        indent=2,
    )
)
shutil.copytree(here / "Editor", output / "Editor")
shutil.copy(here.parent.parent / "LICENSE", output)
shutil.copy(binding, output / "Runtime")
(output / "Runtime/Sandglass.asmdef").write_text(json.dumps({"name": "Sandglass", "allowUnsafeCode": True}))
(output / "Editor/Sandglass.Editor.asmdef").write_text(
    json.dumps({"name": "Sandglass.Editor", "references": ["Sandglass"], "includePlatforms": ["Editor"]})
)
importers = {}
for preset, file, folder, platforms in PLUGINS:
    if not (builds / preset / file).exists():
        print(f"No plug-in for {folder}: the preset {preset} has not built {file}.")
        continue
    (output / "Plugins" / folder).mkdir(parents=True)
    plugin = pathlib.Path(shutil.copy(builds / preset / file, output / "Plugins" / folder))
    importers[plugin] = (
        "PluginImporter:\n  serializedVersion: 2\n  platformData:\n"
        + platform("Any: ", 0, " {}")
        + "".join(platform(name, 1, f"\n        {settings}") for name, settings in platforms.items())
    )
if shutil.which("glslangValidator") and shutil.which("spirv-cross"):
    for name in SHADERS:
        (output / f"Shaders/{name}.hlsl").write_text(hlsl(name))
else:
    print("No shaders: they need glslangValidator and spirv-cross.")
for path in sorted(output.rglob("*")):
    importer = importers.get(path) or (
        "folderAsset: yes\nDefaultImporter:\n" if path.is_dir() else IMPORTERS.get(path.suffix, "DefaultImporter:\n")
    )
    guid = hashlib.md5(f"org.sandglass/{path.relative_to(output).as_posix()}".encode()).hexdigest()
    pathlib.Path(f"{path}.meta").write_text(f"fileFormatVersion: 2\nguid: {guid}\n{importer}")
print(output)
