#!/usr/bin/env python3
"""Checks the layout of the packages for Android's and Apple's tools against the descriptions of their formats.

package_layout.py aar FILE INCLUDE_FOLDER
package_layout.py pages FILE...                checks only that each is aligned for pages of 16 KB
package_layout.py xcframework FOLDER INCLUDE_FOLDER
package_layout.py android|ios ARCHIVE          checks only that every object is for 64-bit ARM, in that system's format
"""

import json
import pathlib
import plistlib
import re
import struct
import subprocess
import sys
import tempfile
import zipfile


def expect(condition, sentence):
    if not condition:
        sys.exit(sentence)


def headers_below(folder):
    return {str(path.relative_to(folder)) for path in pathlib.Path(folder).rglob("*") if path.is_file()}


# How llvm-readobj calls an object for 64-bit ARM.
FORMATS = {"android": "elf64-littleaarch64", "ios": "Mach-O arm64"}


def for_arm64(path, system):
    said = subprocess.run(["llvm-readobj", "--file-headers", path], check=True, capture_output=True, text=True).stdout
    formats = re.findall(r"^Format: (.*)$", said, re.MULTILINE)
    expect(formats and set(formats) == {FORMATS[system]}, f"{path} is not for {system} on arm64: {sorted(set(formats))}")
    print(f"{len(formats)} objects for {system} on arm64")


def for_pages(name, data):
    """Every segment that is loaded is aligned for pages of 16 KB."""
    begin, (size, count) = struct.unpack_from("<Q", data, 32)[0], struct.unpack_from("<2H", data, 54)
    segments = [struct.unpack_from("<I44xQ", data, begin + i * size) for i in range(count)]
    aligned = [align for kind, align in segments if kind == 1]
    expect(aligned and all(align % 16384 == 0 for align in aligned), f"{name} is not aligned for pages of 16 KB: {aligned}")


# Prefab: https://google.github.io/prefab, schema version 2.
def aar(file, include):
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(file) as archive:
            expect(archive.testzip() is None, "the archive is damaged")
            archive.extractall(folder)
        root = pathlib.Path(folder)
        expect("minSdkVersion" in (root / "AndroidManifest.xml").read_text(), "the manifest names no least version")
        package = json.loads((root / "prefab/prefab.json").read_text())
        expect(package["schema_version"] == 2 and package["name"] == "sandglass", "prefab.json")
        expect(len(package["version"].split(".")) in (2, 3, 4), "a version must be one that CMake can compare")
        module = root / "prefab/modules/sandglass"
        described = json.loads((module / "module.json").read_text())
        abi = module / "libs/android.arm64-v8a"
        built = json.loads((abi / "abi.json").read_text())
        expect(set(built) == {"abi", "api", "ndk", "stl", "static"}, "abi.json must have exactly these five fields")
        expect(built["abi"] == "arm64-v8a" and built["api"] >= 24 and built["static"] is True, "abi.json")
        library = abi / (described["library_name"] + ".a")
        expect(library.is_file(), "the library is not where module.json says")
        for_arm64(library, "android")
        expect(headers_below(module / "include") == headers_below(include), "the headers are not those of the source")
        linked = [path for path in root.rglob("*") if path.is_file() and path.read_bytes()[:4] == b"\x7fELF"]
        for path in linked:
            for_pages(path, path.read_bytes())
        if linked:
            with zipfile.ZipFile(root / "classes.jar") as classes:
                expect({"org/sandglass/Scene.class", "org/sandglass/SandglassException.class"} <= set(classes.namelist()), "classes.jar")
            expect("org.sandglass.Native" in (root / "proguard.txt").read_text(), "a shrinker would take what C++ throws")
    print(f"Prefab package: complete; {len(linked)} libraries for Kotlin")


def xcframework(folder, include):
    package = pathlib.Path(folder)
    swift = (package / "Package.swift").read_text()
    expect(
        'binaryTarget(name: "Sandglass", path: "Sandglass.xcframework")' in swift and (package / "Privacy/Privacy.swift").is_file(),
        "Package.swift",
    )
    privacy = plistlib.loads((package / "Privacy/PrivacyInfo.xcprivacy").read_bytes())
    expect(privacy["NSPrivacyTracking"] is False and privacy["NSPrivacyCollectedDataTypes"] == [], "the library collects nothing")
    expect(
        [set(api) for api in privacy["NSPrivacyAccessedAPITypes"]] == [{"NSPrivacyAccessedAPIType", "NSPrivacyAccessedAPITypeReasons"}],
        "PrivacyInfo.xcprivacy",
    )
    root = package / "Sandglass.xcframework"
    described = plistlib.loads((root / "Info.plist").read_bytes())
    expect(described["CFBundlePackageType"] == "XFWK" and described["XCFrameworkFormatVersion"] == "1.0", "Info.plist")
    slices = described["AvailableLibraries"]
    expect(
        [(s["SupportedPlatform"], s.get("SupportedPlatformVariant")) for s in slices]
        == [("ios", None), ("ios", "simulator"), ("xros", None), ("xros", "simulator")],
        "a slice for each device and each simulator",
    )
    for one in slices:
        place = root / one["LibraryIdentifier"]
        expect(one["SupportedArchitectures"] == ["arm64"], "processor")
        for_arm64(place / one["LibraryPath"], "ios")
        expect(headers_below(place / one["HeadersPath"]) == headers_below(include), "the headers are not those of the source")
        expect((place / one["HeadersPath"] / "sandglass/module.modulemap").is_file(), "no module map: Swift could not import it")
    print("Swift package: complete")


if __name__ == "__main__":
    if sys.argv[1] == "pages":
        for file in sys.argv[2:]:
            for_pages(file, pathlib.Path(file).read_bytes())
    elif sys.argv[1] in FORMATS:
        for_arm64(sys.argv[2], sys.argv[1])
    else:
        {"aar": aar, "xcframework": xcframework}[sys.argv[1]](*sys.argv[2:])
