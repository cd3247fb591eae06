# Compile rules, stated once.
#   sandglass_device_library(NAME sources...)  a folder of the part that runs on a phone: no exceptions, no RTTI, no guards
#                                              of static variables, and no fused multiply-add, so that every instruction
#                                              set gives the same hash.
#   sandglass_device_rules(NAME)               the same rules for a target that is not such a folder: Unity's plug-in.
#   sandglass_host_target(NAME [TEST|COLD])    warnings for workstation code; common headers are parsed once. COLD: no fuzzer
#                                              runs it and no test waits for it, so under sanitizers it is not optimised,
#                                              which takes clang half the time.
#
# SANDGLASS_HOST_OPTIONS are further options for workstation code alone. The builds of the second compiler and for ARM
# set -O1 there, which compiles faster, while the library is optimised as it ships. Tests are always -O1, because
# compiling them takes longer than running them.
set(SANDGLASS_HOST_OPTIONS "" CACHE STRING "Further compiler options for workstation code and tests")
set(SANDGLASS_TEST_OPTIONS $<$<CONFIG:Release>:-O1>)
set(SANDGLASS_WARNINGS -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wdouble-promotion)
# Where addresses have 32 bits, sizes are still counted in 64. What is copied or cleared lies in a block, and so fits.
if(EMSCRIPTEN)
  list(APPEND SANDGLASS_WARNINGS -Wno-shorten-64-to-32)
endif()

# The app did not call code that runs before main or after it, so there must be none: clang says where such code is, and
# nm proves for both compilers that there is none. A file may carry a warning option that only the other compiler knows.
set(SANDGLASS_DEVICE_WARNINGS ${SANDGLASS_WARNINGS} -Wvla
  "$<$<CXX_COMPILER_ID:Clang,AppleClang>:-Wglobal-constructors;-Wexit-time-destructors;-Wno-unknown-warning-option>")

# Contraction is off wherever results must agree to the bit. -fno-math-errno lets sqrt be one instruction.
set(SANDGLASS_EXACT_MATH -ffp-contract=off -fno-fast-math -fno-math-errno)

function(sandglass_device_library name)
  add_library(${name} OBJECT ${ARGN})
  sandglass_device_rules(${name})
endfunction()

function(sandglass_device_rules name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/runtime/include>)
  target_compile_options(${name} PRIVATE ${SANDGLASS_DEVICE_WARNINGS} ${SANDGLASS_EXACT_MATH}
    $<$<COMPILE_LANGUAGE:CXX>:-fno-exceptions -fno-rtti -fno-threadsafe-statics> -ffunction-sections -fdata-sections)
endfunction()

# A small source file of workstation code spends most of its compile time in the headers of the standard library and of
# GoogleTest. They are parsed once a build, with two exceptions. With a compiler cache they are not, because the cache
# does better and cannot see through precompiled headers. In builds for other machines they are not either: those show
# that every file includes what it uses, and keep two warnings that are off here.
function(sandglass_precompiled_headers name)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/${name}.cpp CONTENT "// Nothing but the headers.\n")
  add_library(${name} OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/${name}.cpp)
  sandglass_host_target(${name} HEADERS)
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

function(sandglass_host_target name)
  target_compile_features(${name} PUBLIC cxx_std_20)
  set_target_properties(${name} PROPERTIES CXX_EXTENSIONS OFF)
  target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
  # gcc 12 warns of overlapping copies in its own std::string (gcc bug 105651).
  target_compile_options(${name} PRIVATE ${SANDGLASS_WARNINGS} ${SANDGLASS_EXACT_MATH} -Wno-double-promotion
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict> ${SANDGLASS_HOST_OPTIONS})
  set(headers sandglass_host_headers)
  if(ARGN STREQUAL "TEST")
    set(headers sandglass_test_headers)
    target_compile_options(${name} PRIVATE ${SANDGLASS_TEST_OPTIONS})
  elseif(ARGN STREQUAL "COLD" AND CMAKE_CXX_FLAGS MATCHES "-fsanitize")
    set(headers sandglass_cold_headers)
    target_compile_options(${name} PRIVATE -O0)
  endif()
  if(TARGET ${headers} AND NOT ARGN STREQUAL "HEADERS")
    target_precompile_headers(${name} REUSE_FROM ${headers})
    # The same bug: gcc no longer takes the system's headers for the system's once they are precompiled.
    target_compile_options(${name} PRIVATE
      "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-stringop-overflow;-Wno-array-bounds>")
  endif()
endfunction()
