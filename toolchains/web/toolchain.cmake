# WebAssembly by Emscripten 3.1.6, as Debian packages it, or newer. 128-bit SIMD is on everywhere: every browser since
# 2023 has it, and has had bounded conversions to whole numbers for longer. Programs are bare modules; node runs those
# of the tests by way of run.mjs.
find_program(sandglass_emcc NAMES emcc REQUIRED)
execute_process(COMMAND em-config EMSCRIPTEN_ROOT OUTPUT_VARIABLE sandglass_emscripten OUTPUT_STRIP_TRAILING_WHITESPACE)
set(EMSCRIPTEN_SYSTEM_PROCESSOR wasm32)
include(${sandglass_emscripten}/cmake/Modules/Platform/Emscripten.cmake)

set(CMAKE_C_FLAGS_INIT "-msimd128 -mnontrapping-fptoint")
set(CMAKE_CXX_FLAGS_INIT "-msimd128 -mnontrapping-fptoint")
# Packages of headers alone are found where the workstation has them.
list(APPEND CMAKE_SYSTEM_PREFIX_PATH /usr)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE BOTH)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
find_program(sandglass_node NAMES node nodejs)
set(CMAKE_CROSSCOMPILING_EMULATOR ${sandglass_node} ${CMAKE_CURRENT_LIST_DIR}/run.mjs)
