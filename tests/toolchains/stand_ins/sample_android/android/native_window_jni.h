#pragma once
#include <jni.h>
struct ANativeWindow;
extern "C" ANativeWindow* ANativeWindow_fromSurface(JNIEnv* env, jobject surface);
extern "C" void ANativeWindow_release(ANativeWindow* window);
