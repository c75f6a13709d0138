#include_next <unistd.h>
#undef _PC_PATH_MAX
#undef _SC_AVPHYS_PAGES
#undef _SC_CLK_TCK
#undef _SC_GETPW_R_SIZE_MAX
#undef _SC_IOV_MAX
#undef _SC_MONOTONIC_CLOCK
#undef _SC_NPROCESSORS_CONF
#undef _SC_NPROCESSORS_ONLN
#undef _SC_OPEN_MAX
#undef _SC_PAGESIZE
#undef _SC_PAGE_SIZE
#undef _SC_PHYS_PAGES
#define _PC_PATH_MAX 5
#define _SC_CLK_TCK 6
#define _SC_OPEN_MAX 11
#define _SC_IOV_MAX 38
#define _SC_PAGESIZE 39
#define _SC_PAGE_SIZE 40
#define _SC_GETPW_R_SIZE_MAX 72
#define _SC_NPROCESSORS_CONF 96
#define _SC_NPROCESSORS_ONLN 97
#define _SC_PHYS_PAGES 98
#define _SC_AVPHYS_PAGES 99
#define _SC_MONOTONIC_CLOCK 100
