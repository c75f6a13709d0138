/* Types of 64-bit bionic whose size or layout is another than musl's. */
#if defined(__NEED_pthread_mutexattr_t) && !defined(__DEFINED_pthread_mutexattr_t)
#define __DEFINED_pthread_mutexattr_t
typedef long pthread_mutexattr_t;
#endif
#if defined(__NEED_pthread_condattr_t) && !defined(__DEFINED_pthread_condattr_t)
#define __DEFINED_pthread_condattr_t
typedef long pthread_condattr_t;
#endif
#if defined(__NEED_pthread_spinlock_t) && !defined(__DEFINED_pthread_spinlock_t)
#define __DEFINED_pthread_spinlock_t
typedef struct {
  long reserved;
} pthread_spinlock_t;
#endif
#if defined(__NEED_pthread_attr_t) && !defined(__DEFINED_pthread_attr_t)
#define __DEFINED_pthread_attr_t
typedef struct {
  unsigned flags;
  void* stack_base;
  unsigned long stack_size, guard_size;
  int sched_policy, sched_priority;
  char reserved[16];
} pthread_attr_t;
#endif
#if defined(__NEED_sigset_t) && !defined(__DEFINED_sigset_t)
#define __DEFINED_sigset_t
typedef unsigned long sigset_t;
#endif
/* The layout of struct stat is the same with an int and padding. */
#if defined(__NEED_blksize_t) && !defined(__DEFINED_blksize_t)
#define __DEFINED_blksize_t
typedef int blksize_t;
#endif
#include_next <bits/alltypes.h>
