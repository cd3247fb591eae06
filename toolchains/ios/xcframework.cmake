# Makes a Swift package: Sandglass.xcframework, the library for iOS, visionOS and their simulators in one folder, as
# `xcodebuild -create-xcframework` writes it, but made without Xcode; Package.swift and the privacy manifest beside it.
#   cmake -DARCHIVE=…/PRESET/…/libsandglass.a -DINCLUDE=DIR -DOUTPUT=FOLDER -P xcframework.cmake
# PRESET stands for each of the presets that build a slice.
cmake_policy(VERSION 3.25)
foreach(needed ARCHIVE INCLUDE OUTPUT)
  if(NOT DEFINED ${needed})
    message(FATAL_ERROR "xcframework.cmake: -D${needed}=… is missing.")
  endif()
endforeach()
file(REMOVE_RECURSE ${OUTPUT}/Sandglass.xcframework)
set(libraries "")
# preset, platform, the platform's number in a Mach-O object
foreach(slice IN ITEMS "ios;ios;02" "ios-simulator;ios;07" "visionos;xros;0b" "visionos-simulator;xros;0c")
  list(GET slice 0 preset)
  list(GET slice 1 platform)
  list(GET slice 2 number)
  string(REPLACE PRESET ${preset} archive ${ARCHIVE})
  if(NOT EXISTS ${archive})
    message(FATAL_ERROR "${archive} does not exist: build the preset ${preset} first.")
  endif()
  # The framework says arm64 and the system, and so must the first object in the archive, in its header and its LC_BUILD_VERSION.
  file(READ ${archive} bytes LIMIT 1048576 HEX)
  if(NOT bytes MATCHES "cffaedfe0c000001" OR NOT bytes MATCHES "32000000(18|20)000000${number}000000")
    message(FATAL_ERROR "${archive} is not for ${preset} on arm64: build it by that preset.")
  endif()
  set(identifier ${platform}-arm64)
  set(variant "")
  if(preset MATCHES simulator)
    string(APPEND identifier -simulator)
    set(variant "      <key>SupportedPlatformVariant</key><string>simulator</string>\n")
  endif()
  set(folder ${OUTPUT}/Sandglass.xcframework/${identifier})
  file(COPY ${archive} DESTINATION ${folder})
  file(COPY ${INCLUDE}/sandglass DESTINATION ${folder}/Headers)
  string(APPEND libraries "    <dict>
      <key>LibraryIdentifier</key><string>${identifier}</string>
      <key>LibraryPath</key><string>libsandglass.a</string>
      <key>HeadersPath</key><string>Headers</string>
      <key>SupportedArchitectures</key><array><string>arm64</string></array>
      <key>SupportedPlatform</key><string>${platform}</string>
${variant}    </dict>\n")
endforeach()
file(WRITE ${OUTPUT}/Sandglass.xcframework/Info.plist "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<!DOCTYPE plist PUBLIC \"-//Apple//DTD PLIST 1.0//EN\" \"http://www.apple.com/DTDs/PropertyList-1.0.dtd\">
<plist version=\"1.0\">
<dict>
  <key>AvailableLibraries</key>
  <array>
${libraries}  </array>
  <key>CFBundlePackageType</key><string>XFWK</string>
  <key>XCFrameworkFormatVersion</key><string>1.0</string>
</dict>
</plist>
")
file(COPY ${CMAKE_CURRENT_LIST_DIR}/swift/ DESTINATION ${OUTPUT})
message(STATUS "${OUTPUT}")
