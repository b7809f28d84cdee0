// LD_PRELOAD: a disk that fails. Writes to files whose path holds $FAILING_DISK_PATH fail as
// the first bytes of the file $FAILING_DISK say, which a test changes while the program runs:
// [0] of 256 writes fail; [1] how: 'r' at random (full, broken, torn), 'f' full, 'o' read-only.

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/limits.h>
#include <sys/mman.h>
#include <unistd.h>

namespace {

/// The two bytes; null: nothing fails.
const volatile unsigned char* orders() {
  static const volatile unsigned char* mapped = [] {
    const char* path = std::getenv("FAILING_DISK");
    const int file = path == nullptr ? -1 : open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return static_cast<const volatile unsigned char*>(nullptr);
    void* bytes = mmap(nullptr, 2, PROT_READ, MAP_SHARED, file, 0);
    close(file);
    return bytes == MAP_FAILED ? nullptr : static_cast<const volatile unsigned char*>(bytes);
  }();
  return mapped;
}

bool isMeant(int file) {
  const char* part = std::getenv("FAILING_DISK_PATH");
  if (part == nullptr) return false;
  char link[64];
  char path[PATH_MAX];
  std::strcpy(link, "/proc/self/fd/");
  char* end = link + std::strlen(link);
  char digits[16];
  int count = 0;
  do
    digits[count++] = static_cast<char>('0' + file % 10);
  while ((file /= 10) > 0);
  while (count > 0)
    *end++ = digits[--count];
  *end = '\0';
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return std::strstr(path, part) != nullptr;
}

/// Reproducible alone: threads of the program take turns as they come.
unsigned chance() {
  static unsigned state = 20;
  state = state * 1664525U + 1013904223U;
  return state >> 8U;
}

/// 0: it does; else the error. `torn`: half of it reaches the disk before.
int failure(int file, bool& torn) {
  const volatile unsigned char* order = orders();
  torn = false;
  if (order == nullptr || order[0] == 0 || !isMeant(file)) return 0;
  if (order[0] < 255 && chance() % 256 >= order[0]) return 0;
  if (order[1] == 'f') return ENOSPC;
  if (order[1] == 'o') return EROFS;
  const unsigned how = chance() % 3;
  torn = how == 2;
  return how == 0 ? ENOSPC : EIO;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  bool torn = false;
  const int error = failure(file, torn);
  if (error == 0) return real(file, bytes, size, at);
  if (torn) static_cast<void>(real(file, bytes, size / 2, at));
  errno = error;
  return -1;
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return pwrite64(file, bytes, size, at);
}

ssize_t write(int file, const void* bytes, size_t size) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  bool torn = false;
  const int error = failure(file, torn);
  if (error == 0) return real(file, bytes, size);
  if (torn) static_cast<void>(real(file, bytes, size / 2));
  errno = error;
  return -1;
}

int ftruncate64(int file, off64_t size) {
  static const auto real = next<int (*)(int, off64_t)>("ftruncate64");
  bool torn = false;
  if (const int error = failure(file, torn); error != 0) {
    errno = error;
    return -1;
  }
  return real(file, size);
}

int fdatasync(int file) {
  static const auto real = next<int (*)(int)>("fdatasync");
  bool torn = false;
  if (failure(file, torn) == 0) return real(file);
  errno = EIO;
  return -1;
}

int fsync(int file) {
  static const auto real = next<int (*)(int)>("fsync");
  bool torn = false;
  if (failure(file, torn) == 0) return real(file);
  errno = EIO;
  return -1;
}
}
