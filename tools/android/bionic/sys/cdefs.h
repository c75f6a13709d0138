/* Marks headers as Android's. */
#pragma once

#define __BIONIC__ 1
#ifndef __ANDROID_API__
#define __ANDROID_API__ __ANDROID_MIN_SDK_VERSION__
#endif
#ifdef __cplusplus
#define __BEGIN_DECLS extern "C" {
#define __END_DECLS }
#else
#define __BEGIN_DECLS
#define __END_DECLS
#endif
#define __INTRODUCED_IN(level)
#define __INTRODUCED_IN_64(level)
#define __REMOVED_IN(level)
#define __BIONIC_AVAILABILITY_GUARD(level) (__ANDROID_API__ >= (level))
