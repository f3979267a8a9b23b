/* Temporary files, PATH.XXXXXXXXXXXXXXXX.tmp with sixteen hexadecimal digits, which are written beside PATH and renamed to PATH. A
   writer holds a lock on its temporary file. The system releases the lock of a killed writer, so that a file without a lock is one
   that nobody will rename. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

enum { DIGITS = 16 };

/* Network file systems lock only what is open for writing, and a mask of modes may forbid writing. */
static int open_to_lock(const char *path)
{
    int flags = O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
    int descriptor = open(path, O_RDWR | flags);

    return descriptor < 0 && errno == EACCES ? open(path, O_RDONLY | flags) : descriptor;
}

/* Locks a new temporary file: the descriptor to be closed before the renaming, or -1 where another process removes the file. Where
   the file system has no locks, nobody removes the file. */
int geartrain_lock_temporary(const char *path)
{
    struct stat mine, there;
    int descriptor = open_to_lock(path);

    if (descriptor < 0) return -1;
    if ((flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) || fstat(descriptor, &mine) != 0 ||
        stat(path, &there) != 0 || mine.st_ino != there.st_ino || mine.st_dev != there.st_dev) {
        close(descriptor);
        return -1;
    }
    return descriptor;
}

static int is_temporary(const char *name, const char *of)
{
    size_t length = strlen(of);

    if (strncmp(name, of, length) != 0 || name[length] != '.') return 0;
    name += length + 1;
    return strspn(name, "0123456789ABCDEF") == DIGITS && strcmp(name + DIGITS, ".tmp") == 0;
}

/* Removes the temporary files of PATH that killed writers have left. */
void geartrain_remove_left(const char *path)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    size_t length = (size_t)(name - path);
    char *folder = malloc(length + 2), *file = NULL;
    struct stat status;
    struct dirent *entry;
    DIR *stream;
    int descriptor;

    if (!folder) return;
    memcpy(folder, path, length);
    strcpy(folder + length, length ? "" : ".");
    stream = opendir(folder);
    while (stream && (entry = readdir(stream))) {
        if (!is_temporary(entry->d_name, name)) continue;
        file = malloc(length + strlen(entry->d_name) + 1);
        if (!file) break;
        memcpy(file, path, length);
        strcpy(file + length, entry->d_name);
        descriptor = open_to_lock(file);
        if (descriptor >= 0) {
            if (fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && flock(descriptor, LOCK_EX | LOCK_NB) == 0) unlink(file);
            close(descriptor);
        }
        free(file);
    }
    if (stream) closedir(stream);
    free(folder);
}
