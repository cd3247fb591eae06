/* The clock of kotlin_demo.kt: each reading is so many nanoseconds later, as the golden hash has it. */
#include <jni.h>
#include <stdint.h>

static uint64_t g_reading, g_step;
static uint64_t now_ns(void* user) {
  (void)user;
  return g_reading += g_step;
}
JNIEXPORT jlong JNICALL Java_Demo_clock(JNIEnv* env, jclass demo, jlong step) {
  (void)env, (void)demo, g_step = (uint64_t)step;
  return (jlong)(intptr_t)&now_ns;
}
