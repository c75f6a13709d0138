#pragma once
#include <features.h>
#define __NEED_time_t
#define __NEED_struct_timespec
#include <bits/alltypes.h>
typedef struct {
  unsigned count;
  int reserved[3];
} sem_t;
#define SEM_FAILED ((sem_t*)0)
__BEGIN_DECLS
int sem_init(sem_t*, int, unsigned);
int sem_destroy(sem_t*);
int sem_wait(sem_t*);
int sem_trywait(sem_t*);
int sem_timedwait(sem_t*, const struct timespec*);
int sem_post(sem_t*);
int sem_getvalue(sem_t*, int*);
__END_DECLS
