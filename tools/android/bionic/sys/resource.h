#error "sys/resource.h: what musl has differs from bionic, and nothing of the app needs it"
