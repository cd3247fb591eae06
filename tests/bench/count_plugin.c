/* A plugin of QEMU's translator that counts the executed guest instructions of each function. The counts are exact: the
 * same program gives the same numbers on every machine, however busy. They measure work, not time.
 *
 *   qemu-aarch64 -plugin count_plugin.so,out=FILE PROGRAM
 *
 * Counting starts over when the program enters a function named counting_begins, and the counts are written, one line
 * `instructions function` each, when it enters counting_ends. When it enters counting_laps, a line `instructions lap` is
 * written to FILE.laps, and counting starts over.
 *
 * Distributions ship qemu-user without qemu-plugin.h. The few functions that are used are declared here, as the
 * interface's documentation describes them (version 1, QEMU 4.2 to 8). */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum qemu_plugin_op { QEMU_PLUGIN_INLINE_ADD_U64 };
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };
typedef struct qemu_info_t qemu_info_t;

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id, void (*translate)(qemu_plugin_id_t, struct qemu_plugin_tb*));
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb* block);
struct qemu_plugin_insn* qemu_plugin_tb_get_insn(const struct qemu_plugin_tb* block, size_t index);
const char* qemu_plugin_insn_symbol(const struct qemu_plugin_insn* instruction);
void qemu_plugin_register_vcpu_insn_exec_inline(struct qemu_plugin_insn* instruction, enum qemu_plugin_op operation,
                                                void* counter, uint64_t amount);
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn* instruction, void (*execute)(unsigned int, void*),
                                            enum qemu_plugin_cb_flags flags, void* user);

EXPORT int qemu_plugin_version = 1;

/* One counter for each function. Translated code has their addresses, so they never move. */
enum { k_functions_max = 4096 };
static struct {
  char* name;
  uint64_t count;
} functions[k_functions_max];
static uint32_t function_count;
static const char* output;

static uint32_t function_number(const char* name) {
  uint32_t i;
  if (name == NULL || *name == 0) name = "(shared library)";
  for (i = 0; i < function_count; ++i) {
    if (strcmp(functions[i].name, name) == 0) return i;
  }
  if (function_count == k_functions_max) {
    fprintf(stderr, "count_plugin: more than %d functions\n", k_functions_max);
    exit(1);
  }
  functions[function_count].name = strdup(name);
  return function_count++;
}

static void begin(unsigned int processor, void* user) {
  uint32_t i;
  (void)processor;
  (void)user;
  for (i = 0; i < function_count; ++i) functions[i].count = 0;
}

static void end(unsigned int processor, void* user) {
  uint32_t i;
  FILE* file = fopen(output, "w");
  (void)processor;
  (void)user;
  if (file == NULL) {
    perror(output);
    exit(1);
  }
  for (i = 0; i < function_count; ++i) {
    if (functions[i].count > 0) fprintf(file, "%llu %s\n", (unsigned long long)functions[i].count, functions[i].name);
  }
  fclose(file);
}

static void lap(unsigned int processor, void* user) {
  static FILE* laps;
  uint64_t sum = 0;
  uint32_t i;
  (void)processor;
  (void)user;
  if (laps == NULL) {
    char name[4096];
    snprintf(name, sizeof name, "%s.laps", output);
    laps = fopen(name, "w");
    if (laps == NULL) {
      perror(name);
      exit(1);
    }
  }
  for (i = 0; i < function_count; ++i) {
    sum += functions[i].count;
    functions[i].count = 0;
  }
  fprintf(laps, "%llu lap\n", (unsigned long long)sum);
  fflush(laps);
}

/* Adds once for each run of instructions of one function within a block. */
static void translate(qemu_plugin_id_t id, struct qemu_plugin_tb* block) {
  const size_t n = qemu_plugin_tb_n_insns(block);
  size_t from = 0;
  (void)id;
  while (from < n) {
    struct qemu_plugin_insn* first = qemu_plugin_tb_get_insn(block, from);
    const char* name = qemu_plugin_insn_symbol(first);
    const uint32_t function = function_number(name);
    size_t to = from + 1;
    while (to < n && function_number(qemu_plugin_insn_symbol(qemu_plugin_tb_get_insn(block, to))) == function) ++to;
    qemu_plugin_register_vcpu_insn_exec_inline(first, QEMU_PLUGIN_INLINE_ADD_U64, &functions[function].count, to - from);
    if (from == 0 && name != NULL && strcmp(name, "counting_begins") == 0)
      qemu_plugin_register_vcpu_insn_exec_cb(first, begin, QEMU_PLUGIN_CB_NO_REGS, NULL);
    if (from == 0 && name != NULL && strcmp(name, "counting_laps") == 0)
      qemu_plugin_register_vcpu_insn_exec_cb(first, lap, QEMU_PLUGIN_CB_NO_REGS, NULL);
    if (from == 0 && name != NULL && strcmp(name, "counting_ends") == 0)
      qemu_plugin_register_vcpu_insn_exec_cb(first, end, QEMU_PLUGIN_CB_NO_REGS, NULL);
    from = to;
  }
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t* info, int count, char** arguments) {
  int i;
  (void)info;
  for (i = 0; i < count; ++i) {
    if (strncmp(arguments[i], "out=", 4) == 0) output = strdup(arguments[i] + 4);
  }
  if (output == NULL) {
    fprintf(stderr, "count_plugin: out=FILE is missing\n");
    return 1;
  }
  qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
  return 0;
}
