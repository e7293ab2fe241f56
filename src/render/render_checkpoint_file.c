// SPDX-License-Identifier: Apache-2.0
// The file of a checkpoint: see render_checkpoint_file.h. Entries are appended as results come, so
// a process that is killed loses at most the one that it was writing, which its checksum shows. The
// state of an image is replaced as a whole: by a new file that is renamed.
#include "render/render_checkpoint_file.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/fileio.h"
#include "base/fileio_output.h"
#include "base/stats.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "files have the byte order of memory");

enum { CHECKPOINT_VERSION = 14 };
static const char checkpoint_magic[8] = {'s', 'a', 't', 'i', 'n', 'c', 'k', 'p'};

struct file_head {
    char magic[8];
    uint32_t version, unused;
};

struct entry_head {
    uint32_t kind, passing;  // of a passing entry, the number of its loop; else 0
    uint64_t size;           // of what follows
    uint64_t checksum;       // of the members before, and of what follows
};

struct checkpoint_file {
    const char *path;
    int fd;
    struct log log;
    bool warned;     // that an entry is damaged
    uint64_t next;   // offset of the next entry
    uint64_t first;  // offset behind the identity
    // Offsets of passing entries: of the first that is of use beside a new image, and of the next.
    uint64_t passing, next_passing;
};

// Goes to the entry that is the next one, which passing ones may follow.
static void go_to(struct checkpoint_file *file, uint64_t next) {
    file->next = file->passing = file->next_passing = next;
}

// ---- Entries ------------------------------------------------------------------------------------

static struct entry_head head_of(unsigned kind, uint32_t passing, const struct bytes *entry) {
    struct entry_head head = {.kind = kind, .passing = passing, .size = entry->count};
    const uint64_t hash = fileio_hash(FILEIO_HASH, &head, offsetof(struct entry_head, checksum));
    head.checksum = fileio_hash_large(hash, entry->data, entry->count);
    return head;
}

static bool read_range(int fd, void *data, size_t size, uint64_t offset) {
    for (size_t done = 0; done < size;) {
        const ssize_t n = pread(fd, (char *)data + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        done += (size_t)n;
    }
    return true;
}

static bool write_range(int fd, const void *data, size_t size, uint64_t offset) {
    for (size_t done = 0; done < size;) {
        const ssize_t n =
            pwrite(fd, (const char *)data + done, size - done, (off_t)(offset + done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        done += (size_t)n;
    }
    return true;
}

// The bytes from this offset to the end of the file.
static uint64_t file_bytes_from(int fd, uint64_t at) {
    struct stat st;
    return fstat(fd, &st) == 0 && (uint64_t)st.st_size > at ? (uint64_t)st.st_size - at : 0;
}

// Whether the head of an entry, which begins at this offset, can be that of one.
static bool is_valid_head(const struct entry_head *head, uint64_t begin) {
    if (begin == sizeof(struct file_head)) return head->kind == CHECKPOINT_IDENTITY;
    const unsigned kind = head->kind & ~(unsigned)CHECKPOINT_PASSING;
    const bool passing = head->kind & CHECKPOINT_PASSING,
               loop = kind == CHECKPOINT_LOOP || kind == CHECKPOINT_PIECE;
    return passing == (head->passing != 0) && (loop || (kind == CHECKPOINT_IMAGE && !passing));
}

// An entry that cannot be read, as that of a process which was killed while it wrote. It returns
// false.
static bool leave_entry(struct checkpoint_file *file, unsigned kind, uint64_t at) {
    if (file->warned || kind == CHECKPOINT_IDENTITY) return false;
    file->warned = true;
    log_message(file->log, SATIN_LOG_WARNING,
                "%s: the entry at byte %llu is damaged or incomplete; what it had is made again",
                file->path, (unsigned long long)at);
    return false;
}

bool render_checkpoint_file_read(struct checkpoint_file *file, unsigned kind, uint32_t passing,
                                 struct bytes *out) {
    const uint64_t begin = passing ? file->next_passing : file->next,
                   at = begin + sizeof(struct entry_head);
    struct entry_head head;
    if (file_bytes_from(file->fd, begin) == 0) return false;
    if (!read_range(file->fd, &head, sizeof head, begin) || !is_valid_head(&head, begin))
        return leave_entry(file, kind, begin);
    if (head.kind != kind || head.passing != passing) return false;
    if (head.size > file_bytes_from(file->fd, at)) return leave_entry(file, kind, begin);
    out->count = 0;
    if (!array_reserve((void **)&out->data, &out->capacity, (size_t)head.size + 1, 1) ||
        !read_range(file->fd, out->data, (size_t)head.size, at))
        return false;
    out->count = (size_t)head.size;
    if (head_of(kind, passing, out).checksum != head.checksum)
        return leave_entry(file, kind, begin);
    if (passing)
        file->next_passing = at + head.size;
    else if (kind == CHECKPOINT_IMAGE)
        file->passing = file->next_passing = at + head.size;
    else
        go_to(file, at + head.size);
    if (kind == CHECKPOINT_IDENTITY) file->first = file->next;
    return true;
}

satin_status render_checkpoint_file_append(struct checkpoint_file *file, unsigned kind,
                                           uint32_t passing, const struct bytes *entry,
                                           struct log log) {
    const struct entry_head head = head_of(kind, passing, entry);
    const uint64_t begin = passing ? file->next_passing : file->next, at = begin + sizeof head;
    if (ftruncate(file->fd, (off_t)begin) == 0 &&
        write_range(file->fd, &head, sizeof head, begin) &&
        write_range(file->fd, entry->data, entry->count, at)) {
        if (passing)
            file->next_passing = at + entry->count;
        else
            go_to(file, at + entry->count);
        return SATIN_OK;
    }
    const int error = errno;
    // What cannot be cut off is found to be damaged when it is read.
    if (ftruncate(file->fd, (off_t)begin) != 0) errno = error;
    return log_fail(log, SATIN_ERROR_IO, "%s: cannot write: %s", file->path, strerror(error));
}

// ---- The whole file -----------------------------------------------------------------------------

// Writes what a checkpoint begins with: its head and its identity.
static void put_begin(struct fileio_output *out, const struct bytes *identity) {
    struct file_head head = {.version = CHECKPOINT_VERSION};
    memcpy(head.magic, checkpoint_magic, sizeof head.magic);
    const struct entry_head first = head_of(CHECKPOINT_IDENTITY, 0, identity);
    fileio_output_append(out, &head, sizeof head);
    fileio_output_append(out, &first, sizeof first);
    fileio_output_append(out, identity->data, identity->count);
}

static uint64_t bytes_of_begin(const struct bytes *identity) {
    return sizeof(struct file_head) + sizeof(struct entry_head) + identity->count;
}

// Checks the head of an open file. An empty file may become a checkpoint.
static satin_status check_head(const char *path, int fd, struct log log, bool *empty) {
    struct file_head head;
    struct stat st;
    if (fstat(fd, &st) != 0 || !S_ISREG(st.st_mode))
        return log_fail(log, SATIN_ERROR_INPUT, "%s: it is not a regular file", path);
    *empty = st.st_size == 0;
    if (*empty) return SATIN_OK;
    if (!read_range(fd, &head, sizeof head, 0) ||
        memcmp(head.magic, checkpoint_magic, sizeof head.magic) != 0)
        return log_fail(log, SATIN_ERROR_INPUT,
                        "%s: the file exists and is not a checkpoint; it is not replaced", path);
    return SATIN_OK;
}

// How long a checkpoint is waited for that another process writes, as one that has just
// been interrupted may.
static const double LOCK_SECONDS = 10.0;

// Locks an open file. False if another process uses it, or has replaced it meanwhile.
static bool lock_file(const char *path, int fd) {
    struct stat own, named;
    return flock(fd, LOCK_EX | LOCK_NB) == 0 && fstat(fd, &own) == 0 && stat(path, &named) == 0 &&
           own.st_dev == named.st_dev && own.st_ino == named.st_ino;
}

static satin_status check_version(const char *path, int fd, struct log log) {
    struct file_head head;
    if (!read_range(fd, &head, sizeof head, 0))
        return log_fail(log, SATIN_ERROR_INPUT, "%s: the checkpoint is empty", path);
    if (head.version == CHECKPOINT_VERSION) return SATIN_OK;
    return log_fail(log, SATIN_ERROR_INPUT,
                    "%s: a checkpoint of version %u, but this satin reads version %d", path,
                    head.version, CHECKPOINT_VERSION);
}

// Opens the file for reading and writing and locks it. *exists is false if there is none, or an
// empty one.
static satin_status open_existing(const char *path, struct log log, bool *exists, int *fd) {
    const double start = stats_wall();
    bool empty = true;
    *exists = false;
    for (;;) {
        *fd = open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
        *exists = false;
        if (*fd < 0 && errno == ENOENT) return SATIN_OK;
        if (*fd < 0)
            return log_fail(log, SATIN_ERROR_INPUT, "%s: cannot open: %s", path, strerror(errno));
        const satin_status status = check_head(path, *fd, log, &empty);
        *exists = !empty;
        if (status != SATIN_OK || empty || lock_file(path, *fd)) return status;
        if (stats_wall() - start > LOCK_SECONDS)
            return log_fail(log, SATIN_ERROR_INPUT, "%s: another process uses this checkpoint",
                            path);
        close(*fd);
        usleep(100000);
    }
}

// Replaces the open file by a new one, which is locked before it has its name.
static satin_status begin_new(const char *path, const struct bytes *identity, struct log log,
                              int *fd) {
    struct fileio_output out;
    int made;
    satin_status status = fileio_output_open(log, path, FILEIO_SEEK, &out);
    if (status != SATIN_OK) return status;
    put_begin(&out, identity);
    status = fileio_output_commit_locked(log, &out, &made);
    if (status != SATIN_OK) return status;
    if (*fd >= 0) close(*fd);
    *fd = made;
    return SATIN_OK;
}

satin_status render_checkpoint_file_open(const char *path, const struct bytes *identity,
                                         bool resume, struct log log, bool *resumed,
                                         struct checkpoint_file **out) {
    int fd;
    satin_status status = open_existing(path, log, resumed, &fd);
    *resumed = *resumed && resume;
    if (status == SATIN_OK && *resumed) status = check_version(path, fd, log);
    if (status == SATIN_OK && !*resumed) status = begin_new(path, identity, log, &fd);
    struct checkpoint_file *file = status == SATIN_OK ? malloc(sizeof *file) : NULL;
    if (status == SATIN_OK && !file) status = SATIN_ERROR_MEMORY;
    if (file) {
        const uint64_t first = bytes_of_begin(identity);
        *file = (struct checkpoint_file){
            .path = path, .fd = fd, .log = log, .first = *resumed ? 0 : first};
        go_to(file, *resumed ? sizeof(struct file_head) : first);
        *out = file;
    } else if (fd >= 0) {
        close(fd);
    }
    return status;
}

void render_checkpoint_file_close(struct checkpoint_file *file) {
    if (!file) return;
    close(file->fd);
    free(file);
}

void render_checkpoint_file_drop(struct checkpoint_file *file) {
    file->passing = file->next_passing;
}

int render_checkpoint_file_number(const struct checkpoint_file *file) { return file->fd; }

// Copies the bytes [begin, end) of the file to the end of an output.
static bool copy_range(const struct checkpoint_file *file, uint64_t begin, uint64_t end,
                       struct fileio_output *out) {
    enum { BLOCK = 1 << 20 };
    char *block = malloc(BLOCK);
    bool done = block;
    while (done && begin < end) {
        const size_t n = end - begin < BLOCK ? (size_t)(end - begin) : BLOCK;
        done = read_range(file->fd, block, n, begin) && fileio_output_append(out, block, n);
        begin += n;
    }
    free(block);
    return done;
}

satin_status render_checkpoint_file_replace(struct checkpoint_file *file,
                                            const struct bytes *identity, const struct bytes *image,
                                            struct log log) {
    const struct entry_head last = head_of(CHECKPOINT_IMAGE, 0, image);
    const uint64_t begin = bytes_of_begin(identity);
    struct fileio_output out;
    satin_status status = fileio_output_open(log, file->path, FILEIO_SEEK, &out);
    if (status != SATIN_OK) return status;
    put_begin(&out, identity);
    if (!copy_range(file, file->first, file->next, &out) && !out.error) out.error = EIO;
    fileio_output_append(&out, &last, sizeof last);
    fileio_output_append(&out, image->data, image->count);
    const uint64_t kept = file->next_passing - file->passing;
    if (!copy_range(file, file->passing, file->passing + kept, &out) && !out.error) out.error = EIO;
    int fd;
    status = fileio_output_commit_locked(log, &out, &fd);
    if (status != SATIN_OK) return status;
    close(file->fd);
    file->fd = fd;
    file->next = begin + (file->next - file->first);
    file->first = begin;
    file->passing = file->next + sizeof last + image->count;
    file->next_passing = file->passing + kept;
    return SATIN_OK;
}
