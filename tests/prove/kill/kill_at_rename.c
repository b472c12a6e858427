/* Loaded before the C library (LD_PRELOAD): where KILL_AT_RENAME is "before NAME" or "after NAME", the process that gives a file the
 * name NAME kills its parent and itself with SIGKILL just then. */
#define _DEFAULT_SOURCE
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static void kill_at(const char* moment, const char* path)
{
    const char* wanted = getenv("KILL_AT_RENAME");
    const char* slash = strrchr(path, '/');
    char here[256];
    snprintf(here, sizeof here, "%s %s", moment, slash != NULL ? slash + 1 : path);
    if (wanted == NULL || strcmp(wanted, here) != 0)
        return;
    kill(getppid(), SIGKILL);
    kill(getpid(), SIGKILL);
}

int renameat(int from_folder, const char* from, int to_folder, const char* to)
{
    kill_at("before", to);
    const int result = (int)syscall(SYS_renameat, from_folder, from, to_folder, to);
    kill_at("after", to);
    return result;
}

int rename(const char* from, const char* to)
{
    return renameat(AT_FDCWD, from, AT_FDCWD, to);
}
