#!/usr/bin/env python3
"""The layout of what Android and Apple tools are given, checked against their formats' descriptions.

    package_layout.py aar FILE INCLUDE_FOLDER
    package_layout.py xcframework FOLDER INCLUDE_FOLDER
"""
import json
import pathlib
import plistlib
import sys
import tempfile
import zipfile


def expect(condition, sentence):
    if not condition:
        sys.exit(sentence)


def headers_below(folder):
    return {str(path.relative_to(folder)) for path in pathlib.Path(folder).rglob("*") if path.is_file()}


def is_archive(path):
    return path.read_bytes()[:8] == b"!<arch>\n"


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
        expect(is_archive(abi / (described["library_name"] + ".a")), "the library is not where module.json says")
        expect(headers_below(module / "include") == headers_below(include), "the headers are not those of the source")
    print("Prefab package: complete")


def xcframework(folder, include):
    root = pathlib.Path(folder)
    described = plistlib.loads((root / "Info.plist").read_bytes())
    expect(described["CFBundlePackageType"] == "XFWK" and described["XCFrameworkFormatVersion"] == "1.0", "Info.plist")
    slices = described["AvailableLibraries"]
    expect([s.get("SupportedPlatformVariant") for s in slices] == [None, "simulator"], "one slice for the device, one for the simulator")
    for one in slices:
        place = root / one["LibraryIdentifier"]
        expect(one["SupportedPlatform"] == "ios" and one["SupportedArchitectures"] == ["arm64"], "platform")
        expect(is_archive(place / one["LibraryPath"]), f"no archive in {place}")
        expect(headers_below(place / one["HeadersPath"]) == headers_below(include), "the headers are not those of the source")
        expect((place / one["HeadersPath"] / "sandglass/module.modulemap").is_file(), "no module map: Swift could not import it")
    print("XCFramework: complete")


if __name__ == "__main__":
    {"aar": aar, "xcframework": xcframework}[sys.argv[1]](*sys.argv[2:])
