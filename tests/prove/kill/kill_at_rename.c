/* Loaded before the C library (LD_PRELOAD): where KILL_AT_RENAME is "before NAME" or "after NAME", the process that gives a file the
 * name NAME kills its parent and itself with SIGKILL just then. */
#define _POSIX_C_SOURCE 200809L
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

int rename(const char* from, const char* to)
{
    kill_at("before", to);
    const int result = renameat(AT_FDCWD, from, AT_FDCWD, to);
    kill_at("after", to);
    return result;
}
