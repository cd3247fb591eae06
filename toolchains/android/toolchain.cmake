# 64-bit ARM Android, by the NDK's own toolchain file. The NDK is the one that ANDROID_NDK names, else the environment
# (ANDROID_NDK_HOME, ANDROID_NDK_ROOT), else the newest one that Android Studio installed below ANDROID_HOME. Sandglass
# sets arm64-v8a, API 24 or newer, the static C++ library, and shared libraries aligned for pages of 16 KB.
set(sandglass_ndk_candidates ${ANDROID_NDK} $ENV{ANDROID_NDK_HOME} $ENV{ANDROID_NDK_ROOT})
if(DEFINED ENV{ANDROID_HOME})
  file(GLOB sandglass_installed LIST_DIRECTORIES true $ENV{ANDROID_HOME}/ndk/*)
  list(SORT sandglass_installed COMPARE NATURAL ORDER DESCENDING)
  list(APPEND sandglass_ndk_candidates ${sandglass_installed})
endif()
unset(sandglass_ndk)
foreach(candidate IN LISTS sandglass_ndk_candidates)
  if(EXISTS ${candidate}/build/cmake/android.toolchain.cmake)
    set(sandglass_ndk ${candidate})
    break()
  endif()
endforeach()
if(NOT sandglass_ndk)
  message(FATAL_ERROR "No Android NDK found: set ANDROID_NDK to its folder, the one that holds build/cmake/android.toolchain.cmake.")
endif()

if(NOT ANDROID_ABI)
  set(ANDROID_ABI arm64-v8a)
endif()
if(ANDROID_ABI MATCHES "^armeabi")
  message(FATAL_ERROR "Sandglass does not run on 32-bit ARM (${ANDROID_ABI}), whose SIMD flushes denormals and so gives other bits: "
    "restrict abiFilters to arm64-v8a.")
elseif(NOT ANDROID_ABI STREQUAL "arm64-v8a")
  message(FATAL_ERROR "Sandglass is built for arm64-v8a, not ${ANDROID_ABI}: restrict abiFilters to arm64-v8a, and take an emulator's "
    "image for ARM.")
endif()
if(NOT ANDROID_PLATFORM)
  set(ANDROID_PLATFORM android-24)
endif()
string(REGEX REPLACE "^android-" "" sandglass_api ${ANDROID_PLATFORM})
if(sandglass_api LESS 24)
  message(FATAL_ERROR "Sandglass needs Android API level 24, ARCore's own minimum, not ${ANDROID_PLATFORM}: raise minSdkVersion.")
endif()
if(NOT ANDROID_STL)
  set(ANDROID_STL c++_static)
endif()
# Pages of 16 KB: NDK 27 and newer know the variable, older ones need the linker's option.
set(ANDROID_SUPPORT_FLEXIBLE_PAGE_SIZES ON)
string(APPEND CMAKE_SHARED_LINKER_FLAGS_INIT " -Wl,-z,max-page-size=16384")
# A try_compile reads this file again and needs these variables.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ANDROID_NDK ANDROID_ABI ANDROID_PLATFORM ANDROID_STL)

include(${sandglass_ndk}/build/cmake/android.toolchain.cmake)
