/* Loaded before the C library (LD_PRELOAD): fails one chosen file system call of fresco's processes.
 *
 * FAULT_COUNTS is a file of zeros that all of them map: how many calls of each kind they made. FAULT_CALL is "KIND N ERROR", all
 * numbers: the N-th of them fails with ERROR; 0 writes half of the bytes. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

/* failing_calls.py knows the order. */
enum kind { kind_open, kind_list, kind_write, kind_sync, kind_rename, kind_link, kind_unlink, kind_mkdir, kind_lock, kind_truncate, kind_close, kind_count };

static _Atomic uint64_t* counts;
static struct { unsigned kind; unsigned long number; int error; bool set; } plan;

__attribute__((constructor)) static void begin(void)
{
    char program[4096] = {0};
    const char* file = getenv("FAULT_COUNTS");
    const char* call = getenv("FAULT_CALL");
    const char* slash = readlink("/proc/self/exe", program, sizeof program - 1) > 0 ? strrchr(program, '/') : NULL;
    if (file == NULL || slash == NULL || strcmp(slash, "/fresco") != 0)
        return;
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC);
    void* mapped = mmap(NULL, sizeof(uint64_t) * kind_count, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    syscall(SYS_close, fd);
    if (fd < 0 || mapped == MAP_FAILED)
        abort();
    counts = mapped;
    plan.set = call != NULL && sscanf(call, "%u %lu %d", &plan.kind, &plan.number, &plan.error) == 3;
}

/* Counts a call; true where it is the chosen one, with errno set. */
static bool chosen(enum kind kind)
{
    if (counts == NULL || atomic_fetch_add(&counts[kind], 1) + 1 != plan.number || !plan.set || kind != plan.kind)
        return false;
    errno = plan.error;
    return true;
}

static int opened(int folder, const char* path, int flags, mode_t mode)
{
    const bool lists = (flags & O_DIRECTORY) != 0 && (flags & O_TMPFILE) != O_TMPFILE;
    return chosen(lists ? kind_list : kind_open) ? -1 : (int)syscall(SYS_openat, folder, path, flags, mode);
}

#define OPEN(folder)                                                                                                                       \
    {                                                                                                                                      \
        va_list rest;                                                                                                                      \
        va_start(rest, flags);                                                                                                             \
        const mode_t mode = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(rest, mode_t) : 0;                         \
        va_end(rest);                                                                                                                      \
        return opened(folder, path, flags, mode);                                                                                          \
    }

int open(const char* path, int flags, ...) OPEN(AT_FDCWD)
int openat(int folder, const char* path, int flags, ...) OPEN(folder)

static FILE* stream(const char* name, const char* path, const char* mode)
{
    FILE* (*original)(const char*, const char*);
    *(void**)&original = dlsym(RTLD_NEXT, name);
    return chosen(kind_open) ? NULL : original(path, mode);
}

FILE* fopen(const char* path, const char* mode) { return stream("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return stream("fopen64", path, mode); }

/* Only of files: nothing is promised of pipes. */
ssize_t write(int fd, const void* data, size_t size)
{
    struct stat status;
    if (counts != NULL && fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && chosen(kind_write))
    {
        if (plan.error != 0)
            return -1;
        size = (size + 1) / 2;
    }
    return syscall(SYS_write, fd, data, size);
}

/* Copies within the kernel fall back to writes. */
ssize_t copy_file_range(int from, off64_t* from_at, int to, off64_t* to_at, size_t size, unsigned flags)
{
    (void)from, (void)from_at, (void)to, (void)to_at, (void)size, (void)flags;
    errno = ENOSYS;
    return -1;
}

#define FAIL(kind, ...) return chosen(kind) ? -1 : (int)syscall(__VA_ARGS__)

int fsync(int fd) { FAIL(kind_sync, SYS_fsync, fd); }
int fdatasync(int fd) { FAIL(kind_sync, SYS_fdatasync, fd); }
int syncfs(int fd) { FAIL(kind_sync, SYS_syncfs, fd); }
int renameat(int from_folder, const char* from, int to_folder, const char* to) { FAIL(kind_rename, SYS_renameat2, from_folder, from, to_folder, to, 0); }
int rename(const char* from, const char* to) { return renameat(AT_FDCWD, from, AT_FDCWD, to); }
int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags) { FAIL(kind_link, SYS_linkat, from_folder, from, to_folder, to, flags); }
int symlinkat(const char* target, int folder, const char* path) { FAIL(kind_link, SYS_symlinkat, target, folder, path); }
int unlinkat(int folder, const char* path, int flags) { FAIL(kind_unlink, SYS_unlinkat, folder, path, flags); }
int unlink(const char* path) { return unlinkat(AT_FDCWD, path, 0); }
int mkdirat(int folder, const char* path, mode_t mode) { FAIL(kind_mkdir, SYS_mkdirat, folder, path, mode); }
int mkdir(const char* path, mode_t mode) { return mkdirat(AT_FDCWD, path, mode); }
int flock(int fd, int operation) { FAIL(kind_lock, SYS_flock, fd, operation); }
int ftruncate(int fd, off_t size) { FAIL(kind_truncate, SYS_ftruncate, fd, size); }

/* Linux closes the descriptor even where it says that it failed. */
int close(int fd)
{
    const int result = (int)syscall(SYS_close, fd);
    return chosen(kind_close) ? -1 : result;
}

/* On 64-bit machines both are the same. */
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));
int ftruncate64(int fd, off64_t size) __attribute__((alias("ftruncate")));
