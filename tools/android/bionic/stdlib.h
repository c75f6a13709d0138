#include_next <stdlib.h>
#include <stdint.h>
#include <sys/cdefs.h>
__BEGIN_DECLS
uint32_t arc4random(void);
uint32_t arc4random_uniform(uint32_t);
void arc4random_buf(void*, size_t);
__END_DECLS
