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

struct Failure {
  const char* reason = nullptr;
  void raise(JNIEnv* env, sandglass_status status) const {
    if (status == SANDGLASS_OK) return;
    const jclass kind = env->FindClass("org/sandglass/SandglassException");
    const jmethodID make = kind == nullptr ? nullptr : env->GetMethodID(kind, "<init>", "(ILjava/lang/String;)V");
    if (make == nullptr) return;  // Java has thrown already
    const jobject made = env->NewObject(kind, make, status, env->NewStringUTF(reason));
    if (made != nullptr) env->Throw(static_cast<jthrowable>(made));
  }
};

inline jstring text(JNIEnv* env, const char* sentence) {
  return sentence == nullptr ? nullptr : env->NewStringUTF(sentence);
}

extern "C" JNIEXPORT jlong JNICALL Java_org_sandglass_Native_address(JNIEnv* env, jclass, jobject bytes) {
  return reinterpret_cast<jlong>(env->GetDirectBufferAddress(bytes));
}

#endif  // SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H
