#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <malloc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
// Loaded by failing_calls.py before a command (LD_PRELOAD). INJECT_AT=n: the
// nth call of the functions below fails with EIO; INJECT_CALL=name: of this
// function alone; "malloc" stands for all that give memory, which only fail so,
// with ENOMEM: with INJECT_ON=1 the nth and all that follow but small ones, as
// where memory is at its end, until a large block is given back. INJECT_LOG=file: which one that was. INJECT_COUNT=file: the
// number of calls, at exit. INJECT_CLOCK=1: the clock of the day jumps by an
// hour, to and fro, each time it is read.
static int count, at = -2;
static const char* only;
static int hit(const char* what) {
  if (at == -2) {
    const char* a = getenv("INJECT_AT");
    at = a ? atoi(a) : -1;
    only = getenv("INJECT_CALL");
  }
  if (only && strcmp(only, what) != 0) return 0;
  if (__sync_add_and_fetch(&count, 1) == at) {
    const char* f = getenv("INJECT_LOG");
    (void)f;
    if (f) {
      int (*o)(const char*, int, ...) = dlsym(RTLD_NEXT, "open");
      int d = o(f, O_WRONLY | O_CREAT | O_TRUNC, 0666);
      ssize_t (*w)(int, const void*, size_t) = dlsym(RTLD_NEXT, "write");
      if (d >= 0) {
        w(d, what, strlen(what));
        close(d);
      }
    }
    errno = EIO;
    return 1;
  }
  return 0;
}
// Memory, by glibc's own names: dlsym itself asks for some.
extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);
extern void __libc_free(void*);
// Not before main: libraries of libraries ask for memory as they are loaded.
static int is_running;
static int (*real_main)(int, char**, char**);
static int counted_main(int argc, char** argv, char** variables) {
  is_running = 1;
  return real_main(argc, argv, variables);
}
int __libc_start_main(int (*program)(int, char**, char**), int argc,
                      char** argv, void (*init)(void), void (*fini)(void),
                      void (*linker)(void), void* stack) {
  int (*start)(int (*)(int, char**, char**), int, char**, void (*)(void),
               void (*)(void), void (*)(void), void*) =
      dlsym(RTLD_NEXT, "__libc_start_main");
  real_main = program;
  return start(counted_main, argc, argv, init, fini, linker, stack);
}
static int given_back;
static int memory_fails(size_t bytes) {
  static int for_memory = -1;
  static const char* on;
  if (for_memory < 0) {
    const char* call = getenv("INJECT_CALL");
    for_memory = call && strcmp(call, "malloc") == 0;
    on = getenv("INJECT_ON");
  }
  if (!for_memory || !is_running) return 0;
  const int fails = hit("malloc") ||
                    (on && at > 0 && count > at && bytes > 64 && !given_back);
  if (fails) errno = ENOMEM;
  return fails;
}
void free(void* p) {
  if (p && at > 0 && count >= at && malloc_usable_size(p) > 200000) {
    given_back = 1;
  }
  __libc_free(p);
}
void* malloc(size_t n) { return memory_fails(n) ? NULL : __libc_malloc(n); }
void* calloc(size_t k, size_t n) {
  return memory_fails(k * n) ? NULL : __libc_calloc(k, n);
}
void* realloc(void* p, size_t n) {
  return n && memory_fails(n) ? NULL : __libc_realloc(p, n);
}
void* memalign(size_t a, size_t n) {
  return memory_fails(n) ? NULL : __libc_memalign(a, n);
}
void* aligned_alloc(size_t a, size_t n) { return memalign(a, n); }
int posix_memalign(void** p, size_t a, size_t n) {
  void* got = memalign(a, n);
  if (got) *p = got;
  return got ? 0 : ENOMEM;
}
#define REAL(n)               \
  static __typeof__(n)* real; \
  if (!real) real = dlsym(RTLD_NEXT, #n)
// A function that answers so where its turn has come and the condition holds.
#define FAILS_IF(condition, type, name, answer, parameters, arguments) \
  type name parameters {                                               \
    REAL(name);                                                        \
    return (condition) && hit(#name) ? answer : real arguments;        \
  }
#define FAILS(type, name, answer, parameters, arguments) \
  FAILS_IF(1, type, name, answer, parameters, arguments)
// With a mode after the flags `f`, where they ask for one.
#define OPENS(name, what, parameters, ...)    \
  int name parameters {                       \
    REAL(name);                               \
    va_list l;                                \
    va_start(l, f);                           \
    mode_t m = va_arg(l, mode_t);             \
    va_end(l);                                \
    return hit(what) ? -1 : real(__VA_ARGS__, f, m); \
  }
OPENS(open, "open", (const char* p, int f, ...), p)
OPENS(open64, "open", (const char* p, int f, ...), p)
OPENS(openat, "openat", (int d, const char* p, int f, ...), d, p)
FILE* fopen64(const char* p, const char* m) {
  REAL(fopen64);
  return hit("fopen") ? NULL : real(p, m);
}
FAILS(FILE*, fopen, NULL, (const char* p, const char* m), (p, m))
FAILS(ssize_t, read, -1, (int d, void* b, size_t n), (d, b, n))
FAILS_IF(d > 2, ssize_t, write, -1, (int d, const void* b, size_t n), (d, b, n))
FAILS(size_t, fread, 0, (void* b, size_t s, size_t n, FILE* f), (b, s, n, f))
FAILS_IF(f != stdout && f != stderr, size_t, fwrite, 0,
         (const void* b, size_t s, size_t n, FILE* f), (b, s, n, f))
FAILS_IF(f && f != stdout && f != stderr, int, fflush, EOF, (FILE * f), (f))
FAILS(int, fsync, -1, (int d), (d))
FAILS(int, fdatasync, -1, (int d), (d))
FAILS(int, rename, -1, (const char* a, const char* b), (a, b))
FAILS(int, fstat, -1, (int d, struct stat* s), (d, s))
FAILS(int, stat, -1, (const char* p, struct stat* s), (p, s))
FAILS(int, lstat, -1, (const char* p, struct stat* s), (p, s))
FAILS(int, mkdir, -1, (const char* p, mode_t m), (p, m))
FAILS(int, fchmod, -1, (int d, mode_t m), (d, m))
FAILS(int, ftruncate, -1, (int d, off_t n), (d, n))
FAILS(DIR*, opendir, NULL, (const char* p), (p))
FAILS(struct dirent*, readdir, NULL, (DIR * d), (d))
FAILS(off_t, lseek, -1, (int d, off_t o, int w), (d, o, w))
FAILS(ssize_t, pwrite, -1, (int d, const void* b, size_t n, off_t o),
      (d, b, n, o))
FAILS(ssize_t, pread, -1, (int d, void* b, size_t n, off_t o), (d, b, n, o))
FAILS_IF(d >= 0, void*, mmap, MAP_FAILED,
         (void* a, size_t n, int p, int f, int d, off_t o), (a, n, p, f, d, o))
FAILS(int, unlink, -1, (const char* p), (p))
FAILS(int, rmdir, -1, (const char* p), (p))
FAILS(int, remove, -1, (const char* p), (p))
FAILS(int, access, -1, (const char* p, int m), (p, m))
FAILS(char*, realpath, NULL, (const char* p, char* r), (p, r))
FAILS(int, flock, -1, (int d, int o), (d, o))
FAILS(int, pipe, -1, (int d[2]), (d))
FAILS(int, pipe2, -1, (int d[2], int f), (d, f))
FAILS(pid_t, fork, -1, (void), ())
// The descriptor is gone even so, as close(2) says of Linux.
int close(int d) {
  REAL(close);
  const int fails = d > 2 && hit("close");
  const int outcome = real(d);
  if (!fails) return outcome;
  errno = EIO;
  return -1;
}
int fclose(FILE* f) {
  REAL(fclose);
  const int fails = hit("fclose");
  const int outcome = real(f);
  if (!fails) return outcome;
  errno = EIO;
  return EOF;
}
// Programs that the command starts are left in peace.
__attribute__((constructor)) static void alone(void) { unsetenv("LD_PRELOAD"); }
static time_t jump(void) {
  static int n;
  if (!getenv("INJECT_CLOCK")) return 0;
  return ++n % 2 ? 3600 : -3600;
}
int clock_gettime(clockid_t c, struct timespec* t) {
  REAL(clock_gettime);
  const int outcome = real(c, t);
  if (c == CLOCK_REALTIME) t->tv_sec += jump();
  return outcome;
}
int gettimeofday(struct timeval* t, void* z) {
  REAL(gettimeofday);
  const int outcome = real(t, z);
  t->tv_sec += jump();
  return outcome;
}
time_t time(time_t* t) {
  REAL(time);
  const time_t now = real(NULL) + jump();
  if (t) *t = now;
  return now;
}
__attribute__((destructor)) static void say(void) {
  const char* f = getenv("INJECT_COUNT");
  if (!f) return;
  at = -1;
  FILE* o = ((FILE * (*)(const char*, const char*)) dlsym(RTLD_NEXT, "fopen"))(
      f, "w");
  if (o) {
    fprintf(o, "%d\n", count);
    fclose(o);
  }
}
