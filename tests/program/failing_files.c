/* Preloaded into the program: one of its file operations fails, or all from one on. For fault_test.cpp.
 *
 * Only calls about files below SANDGLASS_FAULT_FOLDER count. Each is written to the file SANDGLASS_FAULT_LOG, a line
 * each: "operation name". The call with the number SANDGLASS_FAULT_AT, counted from 1, fails with the error number
 * SANDGLASS_FAULT_ERROR, where 0 means: a read or a write ends after one byte. With SANDGLASS_FAULT_ON every later call
 * of the same operation fails too, as on a full disk. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

static const char* folder;
static int log_file = -1, fail_at, fail_with, fail_on, calls;
static char failing[16]; /* the operation that fails from now on */

__attribute__((constructor)) static void start(void) {
  const char* at = getenv("SANDGLASS_FAULT_AT");
  const char* with = getenv("SANDGLASS_FAULT_ERROR");
  const char* log = getenv("SANDGLASS_FAULT_LOG");
  folder = getenv("SANDGLASS_FAULT_FOLDER");
  if (log != NULL) log_file = (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  fail_at = at != NULL ? atoi(at) : 0;
  fail_with = with != NULL ? atoi(with) : 0;
  fail_on = getenv("SANDGLASS_FAULT_ON") != NULL;
  unsetenv("LD_PRELOAD"); /* not for the programs that it starts */
}

/* 1: this call must fail. */
static int fails(const char* operation, const char* name) {
  char line[600];
  int size, now;
  if (folder == NULL || name == NULL || strncmp(name, folder, strlen(folder)) != 0) return 0;
  now = ++calls;
  size = snprintf(line, sizeof line, "%s %s\n", operation, name);
  if (log_file >= 0 && size > 0) syscall(SYS_write, log_file, line, (size_t)size);
  if (fail_at == 0 || now < fail_at) return 0;
  if (now == fail_at) snprintf(failing, sizeof failing, "%s", operation);
  else if (!fail_on || strcmp(failing, operation) != 0) return 0;
  errno = fail_with;
  return 1;
}

static int fails_open(const char* operation, int file) {
  char link[64], name[512];
  const int kept = errno;
  ssize_t size;
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  size = readlink(link, name, sizeof name - 1);
  errno = kept;
  if (size < 0) return 0;
  name[size] = '\0';
  return fails(operation, name);
}

#define REAL(name, type) ((type)dlsym(RTLD_NEXT, #name))

#define OPEN(name)                                                           \
  int name(const char* path, int flags, ...) {                               \
    mode_t mode = 0;                                                         \
    if ((flags & O_CREAT) != 0) {                                            \
      va_list more;                                                          \
      va_start(more, flags);                                                 \
      mode = va_arg(more, mode_t);                                           \
      va_end(more);                                                          \
    }                                                                        \
    if (fails("open", path)) return -1;                                      \
    return REAL(name, int (*)(const char*, int, mode_t))(path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

#define FOPEN(name)                                                      \
  FILE* name(const char* path, const char* mode) {                       \
    if (fails("open", path)) return NULL;                                \
    return REAL(name, FILE * (*)(const char*, const char*))(path, mode); \
  }
FOPEN(fopen)
FOPEN(fopen64)

/* Folders are opened by it. Names in an open folder are not followed. */
int openat(int at, const char* path, int flags, ...) {
  mode_t mode = 0;
  if ((flags & O_CREAT) != 0) {
    va_list more;
    va_start(more, flags);
    mode = va_arg(more, mode_t);
    va_end(more);
  }
  if (fails("open", path)) return -1;
  return REAL(openat, int (*)(int, const char*, int, mode_t))(at, path, flags, mode);
}

struct dirent* readdir(DIR* list) {
  if (fails_open("readdir", dirfd(list))) return NULL;
  return REAL(readdir, struct dirent * (*)(DIR*))(list);
}

ssize_t read(int file, void* data, size_t bytes) {
  if (fails_open("read", file)) {
    if (fail_with != 0) return -1;
    bytes = bytes > 0;
  }
  return REAL(read, ssize_t(*)(int, void*, size_t))(file, data, bytes);
}

ssize_t write(int file, const void* data, size_t bytes) {
  if (fails_open("write", file)) {
    if (fail_with != 0) return -1;
    bytes = bytes > 0;
  }
  return REAL(write, ssize_t(*)(int, const void*, size_t))(file, data, bytes);
}

#define PWRITE(name)                                                                       \
  ssize_t name(int file, const void* data, size_t bytes, off_t at) {                       \
    if (fails_open("write", file)) {                                                       \
      if (fail_with != 0) return -1;                                                       \
      bytes = bytes > 0;                                                                   \
    }                                                                                      \
    return REAL(name, ssize_t(*)(int, const void*, size_t, off_t))(file, data, bytes, at); \
  }
PWRITE(pwrite)
PWRITE(pwrite64)

size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  size_t (*const real)(const void*, size_t, size_t, FILE*) =
      REAL(fwrite, size_t(*)(const void*, size_t, size_t, FILE*));
  if (!fails_open("write", fileno(file))) return real(data, size, count, file);
  return fail_with == 0 && count > 0 ? real(data, size, 1, file) : 0;
}

/* What fwrite kept in its buffer is written here, so a full disk may show itself here first. */
int fclose(FILE* file) {
  const int failed = fails_open("close", fileno(file)), error = errno;
  const int result = REAL(fclose, int (*)(FILE*))(file);
  if (!failed) return result;
  errno = error;
  return EOF;
}

#define FAILS_BY_FILE(name, operation, parameters, arguments, ...) \
  int name parameters {                                            \
    if (fails_open(operation, file)) return -1;                    \
    return REAL(name, int(*) parameters) arguments;                \
  }
FAILS_BY_FILE(fstat, "stat", (int file, struct stat* status), (file, status))
FAILS_BY_FILE(fstat64, "stat", (int file, struct stat64* status), (file, status))
FAILS_BY_FILE(ftruncate, "truncate", (int file, off_t size), (file, size))
FAILS_BY_FILE(ftruncate64, "truncate", (int file, off64_t size), (file, size))
FAILS_BY_FILE(flock, "lock", (int file, int operation), (file, operation))

#define FAILS_BY_NAME(name, operation, parameters, arguments) \
  int name parameters {                                        \
    if (fails(operation, path)) return -1;                     \
    return REAL(name, int(*) parameters) arguments;            \
  }
FAILS_BY_NAME(stat, "stat", (const char* path, struct stat* status), (path, status))
FAILS_BY_NAME(lstat, "stat", (const char* path, struct stat* status), (path, status))
FAILS_BY_NAME(access, "access", (const char* path, int mode), (path, mode))
FAILS_BY_NAME(unlink, "unlink", (const char* path), (path))
FAILS_BY_NAME(remove, "unlink", (const char* path), (path))
FAILS_BY_NAME(mkdir, "mkdir", (const char* path, mode_t mode), (path, mode))

char* realpath(const char* path, char* resolved) {
  if (fails("realpath", path)) return NULL;
  return REAL(realpath, char* (*)(const char*, char*))(path, resolved);
}

int rename(const char* from, const char* to) {
  if (fails("rename", from)) return -1;
  return REAL(rename, int (*)(const char*, const char*))(from, to);
}
