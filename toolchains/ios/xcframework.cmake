# Makes Sandglass.xcframework: the library for device and simulator in one folder, as Xcode and Swift packages take it.
# It is what `xcodebuild -create-xcframework` writes, made without Xcode.
#   cmake -DDEVICE=libsandglass.a -DSIMULATOR=libsandglass.a -DINCLUDE=DIR -DOUTPUT=Sandglass.xcframework -P xcframework.cmake
cmake_policy(VERSION 3.25)
foreach(needed DEVICE SIMULATOR INCLUDE OUTPUT)
  if(NOT DEFINED ${needed})
    message(FATAL_ERROR "xcframework.cmake: -D${needed}=… is missing.")
  endif()
endforeach()
if(NOT EXISTS ${SIMULATOR})
  message(FATAL_ERROR "${SIMULATOR} does not exist: build the preset ios-simulator first, or name its archive by SANDGLASS_SIMULATOR_ARCHIVE.")
endif()
# The framework says arm64, and so must the Mach-O header of the first object in each archive.
foreach(archive IN ITEMS ${DEVICE} ${SIMULATOR})
  file(READ ${archive} bytes LIMIT 1048576 HEX)
  if(NOT bytes MATCHES "cffaedfe0c000001")
    message(FATAL_ERROR "${archive} is not for iOS on arm64: build it by the presets ios and ios-simulator.")
  endif()
endforeach()
file(REMOVE_RECURSE ${OUTPUT})
set(libraries "")
foreach(archive IN ITEMS ${DEVICE} ${SIMULATOR})
  set(identifier ios-arm64)
  set(variant "")
  if(archive STREQUAL "${SIMULATOR}")
    set(identifier ios-arm64-simulator)
    set(variant "      <key>SupportedPlatformVariant</key><string>simulator</string>\n")
  endif()
  file(COPY ${archive} DESTINATION ${OUTPUT}/${identifier})
  file(COPY ${INCLUDE}/sandglass DESTINATION ${OUTPUT}/${identifier}/Headers)
  get_filename_component(name ${archive} NAME)
  string(APPEND libraries "    <dict>
      <key>LibraryIdentifier</key><string>${identifier}</string>
      <key>LibraryPath</key><string>${name}</string>
      <key>HeadersPath</key><string>Headers</string>
      <key>SupportedArchitectures</key><array><string>arm64</string></array>
      <key>SupportedPlatform</key><string>ios</string>
${variant}    </dict>\n")
endforeach()
file(WRITE ${OUTPUT}/Info.plist "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
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
message(STATUS "${OUTPUT}")
