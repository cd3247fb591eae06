// What the generated entries for Java stand on.
#ifndef SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H
#define SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H

#include <jni.h>

#include "sandglass/types.h"

struct Pointer {
  jlong address;
  template <class T>
  operator T*() const {
    return reinterpret_cast<T*>(address);
  }
};

inline jstring text(JNIEnv* env, const char* sentence) {
  return sentence == nullptr ? nullptr : env->NewStringUTF(sentence);
}

// Lets Java throw, unless it does so already.
inline void finish(JNIEnv* env, jclass native, sandglass_status status, const char* reason) {
  if (status == SANDGLASS_OK) return;
  const jmethodID fail = env->GetStaticMethodID(native, "fail", "(ILjava/lang/String;)V");
  if (fail != nullptr) env->CallStaticVoidMethod(native, fail, status, text(env, reason));
}

extern "C" JNIEXPORT jlong JNICALL Java_org_sandglass_Native_address(JNIEnv* env, jclass, jobject bytes) {
  return reinterpret_cast<jlong>(env->GetDirectBufferAddress(bytes));
}

#endif  // SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H
