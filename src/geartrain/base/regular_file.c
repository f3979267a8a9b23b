/* Whether a path leads to a regular file: 1, or 0 for all else and where nothing is. Asked without opening, which a pipe that
   nobody writes to would make wait. */
#include <sys/stat.h>

int geartrain_is_regular_file(const char *path)
{
    struct stat status;

    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}
