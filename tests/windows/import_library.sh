#!/usr/bin/env bash
# A C program as another compiler of Windows sees the library: clang for the target of MSVC, an import library made of
# sandglass.def. It needs no C library. It runs, and finds the structs as large as the DLL does.
#   import_library.sh PLUG_IN_FOLDER INCLUDE_FOLDER WORK_FOLDER WINE...
set -euo pipefail
plugin=$1 include=$2 work=$3
shift 3
mkdir -p "$work" && cd "$work"
cat >start.c <<'C'
#include "sandglass/room.h"
#include "sandglass/sandglass.h"
int start(void) {
  sandglass_scene_desc scene;
  sandglass_cube cube;
  sandglass_scene_desc_default(&scene);
  sandglass_cube_default(&cube);
  return SANDGLASS_VERSION_FITS() && scene.struct_size == sizeof scene && cube.struct_size == sizeof cube ? 0 : 1;
}
C
clang --target=x86_64-pc-windows-msvc -ffreestanding -Wall -Wextra -Werror -I "$include" -c start.c -o start.obj
llvm-dlltool -m i386:x86-64 -D sandglass.dll -d "$plugin/sandglass.def" -l sandglass.lib
lld-link -entry:start -subsystem:console -out:start.exe start.obj sandglass.lib
exec "$@" start.exe
