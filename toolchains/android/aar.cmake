# Makes an Android archive (AAR) that carries the static library as a Prefab package. Gradle unpacks it. The app's CMake
# finds it by find_package(sandglass CONFIG) and links sandglass::sandglass. For Kotlin it has classes and their JNI library.
#   cmake -DARCHIVE=libsandglass.a -DINCLUDE=DIR -DVERSION=x.y.z -DAPI=24 -DNDK_MAJOR=N -DFOR_PAGES=LINK_OPTION -DSTAGE=DIR
#     -DOUTPUT=FILE.aar [-DJNI=libsandglass_jni.so -DCLASSES=classes.jar] -P aar.cmake
cmake_policy(VERSION 3.25)
foreach(needed ARCHIVE INCLUDE VERSION API NDK_MAJOR FOR_PAGES STAGE OUTPUT)
  if(NOT DEFINED ${needed})
    message(FATAL_ERROR "aar.cmake: -D${needed}=… is missing.")
  endif()
endforeach()
# The package says arm64-v8a, and so must the ELF header of the first object in the archive.
file(READ ${ARCHIVE} bytes LIMIT 1048576 HEX)
if(NOT bytes MATCHES "7f454c460201010000000000000000000100b700")
  message(FATAL_ERROR "${ARCHIVE} is not for arm64-v8a: build it by the preset android.")
endif()
file(REMOVE_RECURSE ${STAGE})
set(module ${STAGE}/prefab/modules/sandglass)
set(abi ${module}/libs/android.arm64-v8a)
file(WRITE ${STAGE}/AndroidManifest.xml
  "<manifest xmlns:android=\"http://schemas.android.com/apk/res/android\" package=\"org.sandglass\" android:versionCode=\"1\" android:versionName=\"${VERSION}\">\n  <uses-sdk android:minSdkVersion=\"${API}\" />\n</manifest>\n")
file(WRITE ${STAGE}/prefab/prefab.json "{\"schema_version\": 2, \"name\": \"sandglass\", \"version\": \"${VERSION}\", \"dependencies\": []}\n")
# libm has sqrtf and its like. libandroid is needed for the trace hook alone; every device has it.
file(WRITE ${module}/module.json "{\"export_libraries\": [\"-landroid\", \"-lm\", \"${FOR_PAGES}\"], \"library_name\": \"libsandglass\"}\n")
# The library uses no C++ standard library, so it does not bind the app to one.
file(WRITE ${abi}/abi.json "{\"abi\": \"arm64-v8a\", \"api\": ${API}, \"ndk\": ${NDK_MAJOR}, \"stl\": \"none\", \"static\": true}\n")
file(COPY ${ARCHIVE} DESTINATION ${abi})
file(COPY ${INCLUDE}/sandglass DESTINATION ${module}/include)
set(kotlin "")
if(JNI)
  file(COPY ${JNI} DESTINATION ${STAGE}/jni/arm64-v8a)
  file(COPY ${CLASSES} DESTINATION ${STAGE})
  file(WRITE ${STAGE}/proguard.txt "-keep class org.sandglass.Native { *; }\n")  # C++ calls it
  set(kotlin classes.jar jni proguard.txt)
endif()
file(REMOVE ${OUTPUT})
execute_process(COMMAND ${CMAKE_COMMAND} -E tar cf ${OUTPUT} --format=zip AndroidManifest.xml prefab ${kotlin} WORKING_DIRECTORY ${STAGE}
  COMMAND_ERROR_IS_FATAL ANY)
message(STATUS "${OUTPUT}")
