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
int open(const char* p, int f, ...) {
  REAL(open);
  va_list l;
  va_start(l, f);
  mode_t m = va_arg(l, mode_t);
  va_end(l);
  if (hit("open")) return -1;
  return real(p, f, m);
}
int open64(const char* p, int f, ...) {
  REAL(open64);
  va_list l;
  va_start(l, f);
  mode_t m = va_arg(l, mode_t);
  va_end(l);
  if (hit("open")) return -1;
  return real(p, f, m);
}
FILE* fopen(const char* p, const char* m) {
  REAL(fopen);
  if (hit("fopen")) return NULL;
  return real(p, m);
}
FILE* fopen64(const char* p, const char* m) {
  REAL(fopen64);
  if (hit("fopen")) return NULL;
  return real(p, m);
}
ssize_t read(int d, void* b, size_t n) {
  REAL(read);
  if (hit("read")) return -1;
  return real(d, b, n);
}
ssize_t write(int d, const void* b, size_t n) {
  REAL(write);
  if (d > 2 && hit("write")) return -1;
  return real(d, b, n);
}
size_t fread(void* b, size_t s, size_t n, FILE* f) {
  REAL(fread);
  if (hit("fread")) return 0;
  return real(b, s, n, f);
}
size_t fwrite(const void* b, size_t s, size_t n, FILE* f) {
  REAL(fwrite);
  if (f != stdout && f != stderr && hit("fwrite")) return 0;
  return real(b, s, n, f);
}
int fflush(FILE* f) {
  REAL(fflush);
  if (f && f != stdout && f != stderr && hit("fflush")) return EOF;
  return real(f);
}
int fsync(int d) {
  REAL(fsync);
  if (hit("fsync")) return -1;
  return real(d);
}
int fdatasync(int d) {
  REAL(fdatasync);
  if (hit("fdatasync")) return -1;
  return real(d);
}
int rename(const char* a, const char* b) {
  REAL(rename);
  if (hit("rename")) return -1;
  return real(a, b);
}
int fstat(int d, struct stat* s) {
  REAL(fstat);
  if (hit("fstat")) return -1;
  return real(d, s);
}
int stat(const char* p, struct stat* s) {
  REAL(stat);
  if (hit("stat")) return -1;
  return real(p, s);
}
int mkdir(const char* p, mode_t m) {
  REAL(mkdir);
  if (hit("mkdir")) return -1;
  return real(p, m);
}
int fchmod(int d, mode_t m) {
  REAL(fchmod);
  if (hit("fchmod")) return -1;
  return real(d, m);
}
int ftruncate(int d, off_t n) {
  REAL(ftruncate);
  if (hit("ftruncate")) return -1;
  return real(d, n);
}
int openat(int d, const char* p, int f, ...) {
  REAL(openat);
  va_list l;
  va_start(l, f);
  mode_t m = va_arg(l, mode_t);
  va_end(l);
  if (hit("openat")) return -1;
  return real(d, p, f, m);
}
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
DIR* opendir(const char* p) {
  REAL(opendir);
  if (hit("opendir")) return NULL;
  return real(p);
}
struct dirent* readdir(DIR* d) {
  REAL(readdir);
  if (hit("readdir")) return NULL;
  return real(d);
}
off_t lseek(int d, off_t o, int w) {
  REAL(lseek);
  if (hit("lseek")) return -1;
  return real(d, o, w);
}
ssize_t pwrite(int d, const void* b, size_t n, off_t o) {
  REAL(pwrite);
  if (hit("pwrite")) return -1;
  return real(d, b, n, o);
}
ssize_t pread(int d, void* b, size_t n, off_t o) {
  REAL(pread);
  if (hit("pread")) return -1;
  return real(d, b, n, o);
}
void* mmap(void* a, size_t n, int p, int f, int d, off_t o) {
  REAL(mmap);
  if (d >= 0 && hit("mmap")) return MAP_FAILED;
  return real(a, n, p, f, d, o);
}
int lstat(const char* p, struct stat* s) {
  REAL(lstat);
  if (hit("lstat")) return -1;
  return real(p, s);
}
int unlink(const char* p) {
  REAL(unlink);
  if (hit("unlink")) return -1;
  return real(p);
}
int rmdir(const char* p) {
  REAL(rmdir);
  if (hit("rmdir")) return -1;
  return real(p);
}
int remove(const char* p) {
  REAL(remove);
  if (hit("remove")) return -1;
  return real(p);
}
int access(const char* p, int m) {
  REAL(access);
  if (hit("access")) return -1;
  return real(p, m);
}
char* realpath(const char* p, char* r) {
  REAL(realpath);
  if (hit("realpath")) return NULL;
  return real(p, r);
}
int flock(int d, int o) {
  REAL(flock);
  if (hit("flock")) return -1;
  return real(d, o);
}
int pipe(int d[2]) {
  REAL(pipe);
  if (hit("pipe")) return -1;
  return real(d);
}
int pipe2(int d[2], int f) {
  REAL(pipe2);
  if (hit("pipe2")) return -1;
  return real(d, f);
}
pid_t fork(void) {
  REAL(fork);
  if (hit("fork")) return -1;
  return real();
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
