#!/usr/bin/env python3
"""Unity's package: every file has a .meta, GUIDs are unique and the same again, an importer names the platform that its plug-in is built
for, the C# compiles, and an editor without a plug-in is told. It says which plug-ins are missing.

unity_package.py SOURCE_FOLDER BINDING WORK_FOLDER LINUX ANDROID IOS"""
import pathlib
import re
import shutil
import subprocess
import sys

# How a plug-in begins and where its first object does, and what its importer says.
PLATFORMS = [(rb"\x7fELF.{14}\x3e\x00", ["Editor: Editor", "Standalone: Linux64"], "OS: Linux"), (rb"\x7fELF.{14}\xb7\x00", ["Android: Android"], "CPU: ARM64"),
             (rb"!<arch>\n.*?\xcf\xfa\xed\xfe\x0c", ["iPhone: iOS"], "AddTo"), (rb"MZ", ["Editor: Editor", "Standalone: Win64"], "OS: Windows")]
source, binding, work, *plugins = map(pathlib.Path, sys.argv[1:])


def check(condition, sentence):
    if not condition:
        sys.exit(sentence)


def ran(*command, **options):
    done = subprocess.run(command, capture_output=True, text=True, **options)
    check(done.returncode == 0, f"{command}: {done.stdout}{done.stderr}")
    return done.stdout


def made(package):
    said = ran("python3", "-B", source / "toolchains/unity/package.py", work, binding, "1.2.3", package)
    return said.count("No plug-in for"), {str(path.relative_to(package)): path.read_bytes() for path in package.rglob("*") if path.is_file()}


shutil.rmtree(work, ignore_errors=True)
for place, plugin in zip(("host/unity", "android/unity", "ios/runtime", "windows/unity"), plugins):
    (work / place).mkdir(parents=True)
    shutil.copy(plugin, work / place)
missing, files = made(work / "package")
(work / "windows/unity").mkdir(parents=True)
(work / "windows/unity/sandglass.dll").write_bytes(b"MZ, in a DLL's place")
none_missing, all_files = made(work / "all")
check((missing, none_missing) == (1, 0) and files.items() <= all_files.items(), "a second package differs, or a plug-in is missing and nothing says so")

package, assets = work / "all", [path for path in (work / "all").rglob("*") if path.suffix != ".meta"]
guids = {re.search(r"^guid: ([0-9a-f]{32})$", pathlib.Path(f"{path}.meta").read_text(), re.M)[1] for path in assets}
check(len(guids) == len(assets) == sum(name.endswith(".meta") for name in all_files), "a GUID or a .meta too few or too many")
for path in (path for path in package.glob("Plugins/*/*") if path.suffix != ".meta"):
    importer = pathlib.Path(f"{path}.meta").read_text()
    enabled = re.findall(r"first:\n +(.*)\n +second:\n +enabled: 1", importer)
    fits = [names == enabled and setting in importer for head, names, setting in PLATFORMS if re.match(head, path.read_bytes(), re.S)]
    check(fits == [True], f"{path.name} in {path.parent.name} is imported for {enabled}")
for stage, name in (("vert", "sand_view"), ("frag", "samplergrains")):
    check(f" {name} :" in (package / f"Shaders/surface.{stage}.hlsl").read_text(), f"surface.{stage} has no {name}")
    ran("glslangValidator", "-D", "-V", "-S", stage, "-e", "main", "-o", work / "code", package / f"Shaders/surface.{stage}.hlsl")

(work / "editor.cs").write_text("""
namespace UnityEditor { public sealed class InitializeOnLoadMethodAttribute : System.Attribute {} }
namespace UnityEngine { public static class Debug { public static void LogError(object text) {} } }
static class Program { static void Main() { System.Console.WriteLine(Sandglass.PlugIn.Fault() ?? "nothing"); } }""")
ran("mcs", "-unsafe", "-warnaserror", f"-out:{work}/editor.exe", package / "Runtime/Sandglass.cs", package / "Editor/PlugIn.cs", work / "editor.cs")
check("has no plug-in for this editor: build" in ran("mono", work / "editor.exe"), "an editor without a plug-in is not told")
check(ran("mono", work / "editor.exe", env={"LD_LIBRARY_PATH": str(package / "Plugins/Linux")}) == "nothing\n", "an editor with a plug-in is told of a fault")
