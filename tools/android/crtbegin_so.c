/* What a shared library of Android begins with: its handle, and the end of its static objects when it
   is unloaded (C++ ABI, section 3.3.6.3). */
extern void __cxa_finalize(void* handle);
extern int __cxa_atexit(void (*function)(void*), void* argument, void* handle);

__attribute__((visibility("hidden"))) void* __dso_handle = &__dso_handle;

__attribute__((destructor)) static void at_unload(void) {
  __cxa_finalize(&__dso_handle);
}

__attribute__((visibility("hidden"))) int atexit(void (*function)(void)) {
  return __cxa_atexit((void (*)(void*))function, 0, &__dso_handle);
}

/* Phones have these from level 26 on, the emulator of the tests (23) has not. Only the locale "C" is
   ever asked for. */
extern float strtof(const char* text, char** end);
extern double strtod(const char* text, char** end);

__attribute__((visibility("hidden"))) float strtof_l(const char* text, char** end, void* locale) {
  (void)locale;
  return strtof(text, end);
}

__attribute__((visibility("hidden"))) double strtod_l(const char* text, char** end, void* locale) {
  (void)locale;
  return strtod(text, end);
}
