# Stands in for the NDK's file: takes the same variables, and compiles with the system's clang against the stand-in headers.
# CMake's own search for an NDK is switched off the way older NDKs did it, by the system version 1.
set(CMAKE_SYSTEM_NAME Android)
set(CMAKE_SYSTEM_VERSION 1)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
if(NOT ANDROID_ABI STREQUAL "arm64-v8a" OR NOT ANDROID_STL STREQUAL "c++_static")
  message(FATAL_ERROR "The stand-in knows arm64-v8a with c++_static only.")
endif()
string(REGEX REPLACE "^android-" "" level ${ANDROID_PLATFORM})
get_filename_component(root ${CMAKE_CURRENT_LIST_DIR}/../../toolchains/llvm/prebuilt/linux-x86_64 ABSOLUTE)
set(CMAKE_SYSROOT ${root}/sysroot)
set(CMAKE_C_COMPILER clang)
set(CMAKE_CXX_COMPILER clang++)
set(CMAKE_C_COMPILER_TARGET aarch64-linux-android${level})
set(CMAKE_CXX_COMPILER_TARGET aarch64-linux-android${level})
# The headers of C and C++ are those of Debian's cross compiler.
file(GLOB libstdcxx /usr/aarch64-linux-gnu/include/c++/*)
set(CMAKE_CXX_FLAGS_INIT "-nostdinc++ -isystem ${libstdcxx} -isystem ${libstdcxx}/aarch64-linux-gnu -isystem /usr/aarch64-linux-gnu/include -D_GNU_SOURCE")
string(APPEND CMAKE_SHARED_LINKER_FLAGS_INIT " -nostdlib -fuse-ld=lld -lc")
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)  # there is nothing to link against
