// What the generated entries for Java stand on. A pointer comes as a number, beside the object that keeps what it leads to.
#ifndef SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H
#define SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H

#include <jni.h>

#include "sandglass/sampling.h"

namespace {

struct Pointer {
  jlong address;
  template <class T>
  operator T*() const {
    return reinterpret_cast<T*>(address);
  }
};

// A fixed array, copied in and, where the library fills it, back.
template <int count, bool is_const>
struct Floats {
  JNIEnv* env;
  jfloatArray array;
  float values[count] = {};
  Floats(JNIEnv* in, jfloatArray of) : env(in), array(of) {
    if (array != nullptr) env->GetFloatArrayRegion(array, 0, count, values);
  }
  ~Floats() {
    if (!is_const && array != nullptr) env->SetFloatArrayRegion(array, 0, count, values);
  }
  operator float*() { return array == nullptr ? nullptr : values; }
};

struct Failure {
  const char* reason = nullptr;
  void raise(JNIEnv* env, sandglass_status status) const {
    if (status == SANDGLASS_OK) return;
    const jclass kind = env->FindClass("org/sandglass/SandglassException");
    if (kind == nullptr) return;
    const jmethodID make = env->GetMethodID(kind, "<init>", "(ILjava/lang/String;)V");
    if (make == nullptr) return;
    const jobject made = env->NewObject(kind, make, status, env->NewStringUTF(reason));
    if (made != nullptr) env->Throw(static_cast<jthrowable>(made));
  }
};

jstring text(JNIEnv* env, const char* sentence) { return sentence == nullptr ? nullptr : env->NewStringUTF(sentence); }

}  // namespace

extern "C" JNIEXPORT jlong JNICALL Java_org_sandglass_Native_address(JNIEnv* env, jclass, jobject bytes) {
  return reinterpret_cast<jlong>(env->GetDirectBufferAddress(bytes));
}

extern "C" JNIEXPORT jlong JNICALL Java_org_sandglass_Native_insideTest(JNIEnv*, jclass) {
  return reinterpret_cast<jlong>(&sandglass_mesh_inside_test);
}

#endif  // SANDGLASS_TOOLCHAINS_ANDROID_ENTRIES_H
