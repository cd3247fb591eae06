#pragma once
#include <stdint.h>
#define JNIEXPORT __attribute__((visibility("default")))
#define JNICALL
struct _JNIEnv;
typedef _JNIEnv JNIEnv;
class _jobject {};
typedef _jobject* jobject;
typedef jobject jclass;
typedef uint8_t jboolean;
typedef int32_t jint;
typedef int64_t jlong;
typedef float jfloat;
typedef double jdouble;
#define JNI_FALSE 0
#define JNI_TRUE 1
