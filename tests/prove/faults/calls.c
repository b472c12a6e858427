/* Loaded before the C library (LD_PRELOAD): fails one chosen file system call, or records all of them.
 *
 * FAULT_COUNTS is a file of zeros that all processes map: how many calls of each kind each role made. FAULT_CALL is "ROLE KIND N
 * ERROR", all numbers: the N-th of them, over all processes of the role, fails with ERROR; 0 writes half of the bytes.
 *
 * RECORD_ROOT is a folder, RECORD_FILE a file: what changes below the folder is appended to the file, in the form that recording.py
 * reads, before the call returns. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
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
#include <sys/uio.h>
#include <unistd.h>

/* The order of both is known to shimmed.py. */
enum role { role_host, role_worker, role_helper, role_program, role_count };
enum kind { kind_open, kind_list, kind_write, kind_sync, kind_rename, kind_link, kind_unlink, kind_mkdir, kind_lock, kind_truncate, kind_close, kind_count };

enum change { change_create, change_unnamed, change_truncate, change_write, change_link, change_symlink, change_rename, change_unlink,
              change_rmdir, change_mkdir, change_sync, change_sync_all };

static _Atomic uint64_t* counts;
static enum role own_role;
static struct { unsigned role, kind; unsigned long number; int error; bool set; } plan;
static const char* record_root;
static const char* record_file;

static enum role find_role(void)
{
    char words[512] = {0};
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, "/proc/self/cmdline", O_RDONLY | O_CLOEXEC);
    const ssize_t size = syscall(SYS_read, fd, words, sizeof words - 2);
    syscall(SYS_close, fd);
    const char* slash = strrchr(words, '/');
    if (size <= 0 || strcmp(slash != NULL ? slash + 1 : words, "fresco") != 0)
        return role_program;
    const char* command = words + strlen(words) + 1;
    if (strcmp(command, "internal-run") == 0)
        return role_worker;
    return strncmp(command, "internal-", 9) == 0 ? role_helper : role_host;
}

__attribute__((constructor)) static void begin(void)
{
    own_role = find_role();
    record_root = getenv("RECORD_ROOT");
    record_file = getenv("RECORD_FILE");
    const char* file = getenv("FAULT_COUNTS");
    const char* call = getenv("FAULT_CALL");
    if (file == NULL)
        return;
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, file, O_RDWR | O_CLOEXEC);
    void* mapped = mmap(NULL, sizeof(uint64_t) * role_count * kind_count, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    syscall(SYS_close, fd);
    if (fd < 0 || mapped == MAP_FAILED)
        abort();
    counts = mapped;
    plan.set = call != NULL && sscanf(call, "%u %u %lu %d", &plan.role, &plan.kind, &plan.number, &plan.error) == 4;
}

/* Counts a call; true where it is the chosen one, with errno set. */
static bool chosen(enum kind kind)
{
    if (counts == NULL)
        return false;
    const uint64_t number = atomic_fetch_add(&counts[own_role * kind_count + kind], 1) + 1;
    if (!plan.set || own_role != plan.role || kind != plan.kind || number != plan.number)
        return false;
    errno = plan.error;
    return true;
}

/* Of a path relative to a folder's descriptor. False: it is not below the root. */
static bool absolute(int folder, const char* path, char whole[PATH_MAX])
{
    if (record_root == NULL)
        return false;
    char base[PATH_MAX] = {0};
    if (path[0] == '/')
        snprintf(whole, PATH_MAX, "%s", path);
    else if (folder == AT_FDCWD ? getcwd(base, sizeof base) == NULL : false)
        return false;
    else
    {
        if (folder != AT_FDCWD)
        {
            char link[64];
            snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
            if (readlink(link, base, sizeof base - 1) < 0)
                return false;
        }
        if (snprintf(whole, PATH_MAX, "%s/%s", base, path) >= PATH_MAX)
            abort();
    }
    const size_t size = strlen(record_root);
    return strncmp(whole, record_root, size) == 0 && (whole[size] == '/' || whole[size] == '\0');
}

static bool recorded_descriptor(int fd, struct stat* status)
{
    if (record_root == NULL)
        return false;
    char link[64];
    char target[PATH_MAX] = {0};
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    const size_t size = strlen(record_root);
    return readlink(link, target, sizeof target - 1) > 0 && strncmp(target, record_root, size) == 0 &&
           (target[size] == '/' || target[size] == '\0') && fstat(fd, status) == 0;
}

static void record(enum change change, uint64_t inode, int64_t offset, const char* path, const char* other, const void* data, size_t size)
{
    const int kept = errno;
    struct { uint32_t change, path, other, data; uint64_t inode; int64_t offset; } header = {
        (uint32_t)change, path != NULL ? (uint32_t)strlen(path) : 0, other != NULL ? (uint32_t)strlen(other) : 0, (uint32_t)size, inode, offset};
    const struct iovec parts[] = {{&header, sizeof header}, {(void*)(uintptr_t)path, header.path}, {(void*)(uintptr_t)other, header.other}, {(void*)(uintptr_t)data, size}};
    const int fd = (int)syscall(SYS_openat, AT_FDCWD, record_file, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0 || syscall(SYS_writev, fd, parts, 4) != (ssize_t)(sizeof header + header.path + header.other + size))
        abort();
    syscall(SYS_close, fd);
    errno = kept;
}

static uint64_t inode_of(const char* path)
{
    struct stat status;
    return lstat(path, &status) == 0 ? status.st_ino : 0;
}

static int opened(int folder, const char* path, int flags, mode_t mode)
{
    if (chosen((flags & O_DIRECTORY) != 0 && (flags & O_TMPFILE) != O_TMPFILE ? kind_list : kind_open))
        return -1;
    char whole[PATH_MAX];
    const bool changes = (flags & (O_CREAT | O_TRUNC)) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
    const bool recorded = changes && absolute(folder, path, whole);
    const bool existed = recorded && inode_of(whole) != 0;
    const int fd = (int)syscall(SYS_openat, folder, path, flags, mode);
    struct stat status;
    if (fd < 0 || !recorded || fstat(fd, &status) != 0)
        return fd;
    if ((flags & O_TMPFILE) == O_TMPFILE)
        record(change_unnamed, status.st_ino, 0, NULL, NULL, NULL, 0);
    else if (!existed)
        record(change_create, status.st_ino, 0, whole, NULL, NULL, 0);
    else if ((flags & O_TRUNC) != 0)
        record(change_truncate, status.st_ino, 0, NULL, NULL, NULL, 0);
    return fd;
}

static bool has_mode(int flags)
{
    return (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
}

#define OPEN_ARGUMENT(flags)                                                                                                               \
    mode_t mode = 0;                                                                                                                       \
    if (has_mode(flags))                                                                                                                   \
    {                                                                                                                                      \
        va_list rest;                                                                                                                      \
        va_start(rest, flags);                                                                                                             \
        mode = va_arg(rest, mode_t);                                                                                                       \
        va_end(rest);                                                                                                                      \
    }

int open(const char* path, int flags, ...)
{
    OPEN_ARGUMENT(flags)
    return opened(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...)
{
    OPEN_ARGUMENT(flags)
    return opened(folder, path, flags, mode);
}

static FILE* stream(const char* name, const char* path, const char* mode)
{
    if (chosen(kind_open))
        return NULL;
    char whole[PATH_MAX];
    const bool recorded = mode[0] != 'r' && absolute(AT_FDCWD, path, whole);
    const bool existed = recorded && inode_of(whole) != 0;
    FILE* (*original)(const char*, const char*);
    *(void**)&original = dlsym(RTLD_NEXT, name);
    FILE* file = original(path, mode);
    if (file != NULL && recorded && (!existed || mode[0] == 'w'))
        record(existed ? change_truncate : change_create, inode_of(whole), 0, whole, NULL, NULL, 0);
    return file;
}

FILE* fopen(const char* path, const char* mode) { return stream("fopen", path, mode); }
FILE* fopen64(const char* path, const char* mode) { return stream("fopen64", path, mode); }

/* What was written last, up to the descriptor's place. */
static void record_write(int fd, int64_t offset, const void* data, ssize_t size)
{
    struct stat status;
    if (size <= 0 || !recorded_descriptor(fd, &status) || !S_ISREG(status.st_mode))
        return;
    if (offset < 0)
        offset = lseek(fd, 0, SEEK_CUR) - size;
    record(change_write, status.st_ino, offset, NULL, NULL, data, (size_t)size);
}

/* Only of files: what goes over pipes is no part of the promise. Sets `size` to what is to be written; true: nothing is. */
static bool write_fails(int fd, size_t* size)
{
    struct stat status;
    if (counts == NULL || fstat(fd, &status) != 0 || !S_ISREG(status.st_mode) || !chosen(kind_write))
        return false;
    if (plan.error != 0)
        return true;
    *size = (*size + 1) / 2;
    return false;
}

ssize_t write(int fd, const void* data, size_t size)
{
    if (write_fails(fd, &size))
        return -1;
    const ssize_t done = syscall(SYS_write, fd, data, size);
    record_write(fd, -1, data, done);
    return done;
}

ssize_t pwrite(int fd, const void* data, size_t size, off_t offset)
{
    if (write_fails(fd, &size))
        return -1;
    const ssize_t done = syscall(SYS_pwrite64, fd, data, size, offset);
    record_write(fd, offset, data, done);
    return done;
}

/* One part of several is less than was asked for, as a short write is. */
ssize_t writev(int fd, const struct iovec* parts, int count)
{
    int part = 0;
    while (part + 1 < count && parts[part].iov_len == 0)
        ++part;
    return count > 0 ? write(fd, parts[part].iov_base, parts[part].iov_len) : 0;
}

/* Whoever copies within the kernel writes for himself instead. */
ssize_t copy_file_range(int from, off64_t* from_at, int to, off64_t* to_at, size_t size, unsigned flags)
{
    (void)from, (void)from_at, (void)to, (void)to_at, (void)size, (void)flags;
    errno = ENOSYS;
    return -1;
}

ssize_t sendfile(int to, int from, off_t* at, size_t size)
{
    (void)to, (void)from, (void)at, (void)size;
    errno = ENOSYS;
    return -1;
}

static int synced(int fd, long number, enum change change)
{
    if (chosen(kind_sync))
        return -1;
    struct stat status;
    const int result = (int)syscall(number, fd);
    if (result == 0 && recorded_descriptor(fd, &status))
        record(change, status.st_ino, 0, NULL, NULL, NULL, 0);
    return result;
}

int fsync(int fd) { return synced(fd, SYS_fsync, change_sync); }
int fdatasync(int fd) { return synced(fd, SYS_fdatasync, change_sync); }
int syncfs(int fd) { return synced(fd, SYS_syncfs, change_sync_all); }

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags)
{
    if (chosen(kind_rename))
        return -1;
    char whole_from[PATH_MAX];
    char whole_to[PATH_MAX];
    const bool recorded = absolute(from_folder, from, whole_from) && absolute(to_folder, to, whole_to);
    const int result = (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, flags);
    if (result == 0 && recorded)
        record(change_rename, 0, 0, whole_from, whole_to, NULL, 0);
    return result;
}

int renameat(int from_folder, const char* from, int to_folder, const char* to) { return renameat2(from_folder, from, to_folder, to, 0); }
int rename(const char* from, const char* to) { return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0); }

int linkat(int from_folder, const char* from, int to_folder, const char* to, int flags)
{
    if (chosen(kind_link))
        return -1;
    char whole[PATH_MAX];
    const int result = (int)syscall(SYS_linkat, from_folder, from, to_folder, to, flags);
    if (result == 0 && absolute(to_folder, to, whole))
        record(change_link, inode_of(whole), 0, whole, NULL, NULL, 0);
    return result;
}

int link(const char* from, const char* to) { return linkat(AT_FDCWD, from, AT_FDCWD, to, 0); }

int symlinkat(const char* target, int folder, const char* path)
{
    if (chosen(kind_link))
        return -1;
    char whole[PATH_MAX];
    const int result = (int)syscall(SYS_symlinkat, target, folder, path);
    if (result == 0 && absolute(folder, path, whole))
        record(change_symlink, inode_of(whole), 0, whole, target, NULL, 0);
    return result;
}

int symlink(const char* target, const char* path) { return symlinkat(target, AT_FDCWD, path); }

int unlinkat(int folder, const char* path, int flags)
{
    if (chosen(kind_unlink))
        return -1;
    char whole[PATH_MAX];
    const int result = (int)syscall(SYS_unlinkat, folder, path, flags);
    if (result == 0 && absolute(folder, path, whole))
        record((flags & AT_REMOVEDIR) != 0 ? change_rmdir : change_unlink, 0, 0, whole, NULL, NULL, 0);
    return result;
}

int unlink(const char* path) { return unlinkat(AT_FDCWD, path, 0); }
int rmdir(const char* path) { return unlinkat(AT_FDCWD, path, AT_REMOVEDIR); }

int remove(const char* path)
{
    struct stat status;
    return unlinkat(AT_FDCWD, path, lstat(path, &status) == 0 && S_ISDIR(status.st_mode) ? AT_REMOVEDIR : 0);
}

int mkdirat(int folder, const char* path, mode_t mode)
{
    if (chosen(kind_mkdir))
        return -1;
    char whole[PATH_MAX];
    const int result = (int)syscall(SYS_mkdirat, folder, path, mode);
    if (result == 0 && absolute(folder, path, whole))
        record(change_mkdir, inode_of(whole), 0, whole, NULL, NULL, 0);
    return result;
}

int mkdir(const char* path, mode_t mode) { return mkdirat(AT_FDCWD, path, mode); }
int flock(int fd, int operation) { return chosen(kind_lock) ? -1 : (int)syscall(SYS_flock, fd, operation); }

int ftruncate(int fd, off_t size)
{
    if (chosen(kind_truncate))
        return -1;
    struct stat status;
    const int result = (int)syscall(SYS_ftruncate, fd, size);
    if (result == 0 && recorded_descriptor(fd, &status))
        record(change_truncate, status.st_ino, size, NULL, NULL, NULL, 0);
    return result;
}

/* Linux closes the descriptor even where it says that it failed. */
int close(int fd)
{
    const int result = (int)syscall(SYS_close, fd);
    return chosen(kind_close) ? -1 : result;
}

/* On 64-bit machines both are the same. */
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));
ssize_t pwrite64(int fd, const void* data, size_t size, off64_t offset) __attribute__((alias("pwrite")));
ssize_t sendfile64(int to, int from, off64_t* at, size_t size) __attribute__((alias("sendfile")));
int ftruncate64(int fd, off64_t size) __attribute__((alias("ftruncate")));
