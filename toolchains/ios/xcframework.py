#!/usr/bin/env python3
"""Makes a Swift package: Sandglass.xcframework, the library for iOS, visionOS and their simulators in one folder, as
`xcodebuild -create-xcframework` writes it, but made without Xcode; Package.swift and the privacy manifest beside it.

xcframework.py ARCHIVE INCLUDE_FOLDER OUTPUT         ARCHIVE names PRESET, for each of the presets that build a slice
"""

import pathlib
import plistlib
import re
import shutil
import sys

# A preset, its platform, and that platform's number in a Mach-O object.
SLICES = [("ios", "ios", 2), ("ios-simulator", "ios", 7), ("visionos", "xros", 11), ("visionos-simulator", "xros", 12)]
include, output, described = pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]), []
shutil.rmtree(output, ignore_errors=True)
shutil.copytree(pathlib.Path(__file__).parent / "swift", output)
for preset, platform, number in SLICES:
    archive = pathlib.Path(sys.argv[1].replace("PRESET", preset))
    if not archive.exists():
        sys.exit(f"{archive} does not exist: build the preset {preset} first.")
    # The first object must be for arm64, and its LC_BUILD_VERSION for this platform.
    built = re.search(rb"\xcf\xfa\xed\xfe\x0c\0\0\x01.*?\x32\0\0\0[\x18\x20]\0\0\0(.)\0\0\0", archive.read_bytes(), re.DOTALL)
    if not built or built[1][0] != number:
        sys.exit(f"{archive} is not for {preset} on arm64: build it by that preset.")
    identifier = f"{platform}-arm64" + "-simulator" * preset.endswith("simulator")
    folder = output / "Sandglass.xcframework" / identifier
    shutil.copytree(include, folder / "Headers")
    shutil.copy(archive, folder)
    described.append(
        {
            "LibraryIdentifier": identifier,
            "LibraryPath": archive.name,
            "HeadersPath": "Headers",
            "SupportedArchitectures": ["arm64"],
            "SupportedPlatform": platform,
        }
        | ({"SupportedPlatformVariant": "simulator"} if "simulator" in preset else {})
    )
(output / "Sandglass.xcframework/Info.plist").write_bytes(
    plistlib.dumps({"AvailableLibraries": described, "CFBundlePackageType": "XFWK", "XCFrameworkFormatVersion": "1.0"})
)
print(output)
