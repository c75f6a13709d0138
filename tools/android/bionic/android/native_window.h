/* The part of the NDK's header that the app uses (developer.android.com, "Native Window"). */
#pragma once
#include <stdint.h>
#include <sys/cdefs.h>
__BEGIN_DECLS
typedef struct ANativeWindow ANativeWindow;
void ANativeWindow_release(ANativeWindow* window);
int32_t ANativeWindow_setBuffersGeometry(ANativeWindow* window, int32_t width, int32_t height,
                                         int32_t format);
__END_DECLS
