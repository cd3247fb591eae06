# 64-bit ARM Linux from any Linux workstation, by Debian's cross compiler. Tests run under user-mode qemu.
# SANDGLASS_ARM64_SYSROOT (optional) names a folder with further arm64 libraries, as `dpkg -x` unpacks Debian's.
# Packages of headers alone are found where the workstation has them. SANDGLASS_QEMU_CPU (optional) picks the emulated
# core: cortex-a53 (no dot product), cortex-a76, max.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)

set(CMAKE_FIND_ROOT_PATH /usr/aarch64-linux-gnu ${SANDGLASS_ARM64_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)

set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L /usr/aarch64-linux-gnu)
if(SANDGLASS_ARM64_SYSROOT)  # its libraries need each other
  set(sandglass_arm64_libraries ${SANDGLASS_ARM64_SYSROOT}/usr/lib/aarch64-linux-gnu)
  add_link_options(-Wl,-rpath-link,${sandglass_arm64_libraries})
  list(APPEND CMAKE_CROSSCOMPILING_EMULATOR -E LD_LIBRARY_PATH=${sandglass_arm64_libraries})
endif()
if(SANDGLASS_QEMU_CPU)
  list(APPEND CMAKE_CROSSCOMPILING_EMULATOR -cpu ${SANDGLASS_QEMU_CPU})
endif()
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SANDGLASS_ARM64_SYSROOT SANDGLASS_QEMU_CPU)
