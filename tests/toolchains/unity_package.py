#!/usr/bin/env python3
"""Unity's package: every file has a .meta, GUIDs are unique and the same again, an importer names the platform that its plug-in is built
for, shaders and C# compile, and an editor without a plug-in is told. It says which plug-ins are missing.

unity_package.py SOURCE_FOLDER BINDING WORK_FOLDER LINUX ANDROID IOS"""

import os
import pathlib
import re
import shutil
import sys

from kit_test import check, ran

# How a plug-in begins and where its first object does, and what its importer says.
PLATFORMS = [
    (rb"\x7fELF.{14}\x3e\x00", ["Editor: Editor", "Standalone: Linux64"], "OS: Linux"),
    (rb"\x7fELF.{14}\xb7\x00", ["Android: Android"], "CPU: ARM64"),
    (rb"!<arch>\n.*?\xcf\xfa\xed\xfe\x0c", ["iPhone: iOS"], "AddTo"),
    (rb"MZ", ["Editor: Editor", "Standalone: Win64"], "OS: Windows"),
]
EDITOR = """namespace UnityEditor { public sealed class InitializeOnLoadMethodAttribute : System.Attribute {} }
namespace UnityEngine { public static class Debug { public static void LogError(object text) {} } }
static class Program { static void Main() { System.Console.WriteLine(Sandglass.PlugIn.Fault() ?? "nothing"); } }"""
source, binding, work, *plugins = map(pathlib.Path, sys.argv[1:])


def made(package):
    said = ran("python3", "-B", source / "toolchains/unity/package.py", work, binding, "1.2.3", package).stdout
    return said.count("No plug-in for"), {
        str(path.relative_to(package)): path.read_bytes() for path in package.rglob("*") if path.is_file()
    }


shutil.rmtree(work, ignore_errors=True)
for place in ("host/unity", "android/unity", "ios/runtime", "windows/unity"):
    (work / place).mkdir(parents=True)
    if plugins:
        shutil.copy(plugins.pop(0), work / place)
missing, files = made(work / "package")
(work / "windows/unity/sandglass.dll").write_bytes(b"MZ, in a DLL's place")
package = work / "all"
none_missing, all_files = made(package)
check(
    (missing, none_missing) == (1, 0) and files.items() <= all_files.items(),
    "a second package differs, or a plug-in is missing and nothing says so",
)

assets = [path for path in package.rglob("*") if path.suffix != ".meta"]
metas = {path: pathlib.Path(f"{path}.meta").read_text() for path in assets}
guids = {re.search(r"^guid: ([0-9a-f]{32})$", meta, re.M)[1] for meta in metas.values()}
check(len(guids) == len(assets) == sum(name.endswith(".meta") for name in all_files), "a GUID or a .meta too few or too many")
built = [path for path in assets if path.parent.parent.name == "Plugins"]
for path in built:
    enabled = re.findall(r"first:\n +(.*)\n +second:\n +enabled: 1", metas[path])
    fits = [names == enabled and setting in metas[path] for head, names, setting in PLATFORMS if re.match(head, path.read_bytes(), re.S)]
    check(fits == [True], f"{path.name} in {path.parent.name} is imported for {enabled}")
check(len(built) == 4, f"plug-ins: {built}")
for stage, name in (("vert", "sand_view"), ("frag", "samplergrains")):
    shader = package / f"Shaders/surface.{stage}.hlsl"
    compiled = ran("glslangValidator", "-D", "-V", "-S", stage, "-e", "main", "-o", work / "code", shader)
    check(f" {name} :" in shader.read_text() and compiled.returncode == 0, f"surface.{stage}: {compiled.stdout}")

(work / "editor.cs").write_text(EDITOR)
compiled = ran(
    "mcs",
    "-unsafe",
    "-warnaserror",
    f"-out:{work}/editor.exe",
    package / "Runtime/Sandglass.cs",
    package / "Editor/PlugIn.cs",
    work / "editor.cs",
)
check(compiled.returncode == 0, compiled.stderr)
check("has no plug-in for this editor: build" in ran("mono", work / "editor.exe").stdout, "an editor without a plug-in is not told")
os.environ["LD_LIBRARY_PATH"] = str(package / "Plugins/Linux")
check(ran("mono", work / "editor.exe").stdout == "nothing\n", "an editor with a plug-in is told of a fault")
