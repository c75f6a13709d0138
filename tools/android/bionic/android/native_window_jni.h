#pragma once
#include <android/native_window.h>
#include <jni.h>
__BEGIN_DECLS
ANativeWindow* ANativeWindow_fromSurface(JNIEnv* env, jobject surface);
__END_DECLS
