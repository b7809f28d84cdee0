// LD_PRELOAD: threads that wait for datagrams never come back in the process whose id stands in
// the file $DEAF_NETWORK, which a test writes while the program runs: as where a library spins
// or waits for a lock.

#include <cstdio>
#include <cstdlib>

#include <dlfcn.h>
#include <sys/socket.h>
#include <unistd.h>

namespace {

void wedge() {
  const char* path = std::getenv("DEAF_NETWORK");
  std::FILE* file = path == nullptr ? nullptr : std::fopen(path, "re");
  if (file == nullptr) return;
  int process = 0;
  const bool is_told = std::fscanf(file, "%d", &process) == 1;
  std::fclose(file);
  while (is_told && process == getpid())
    pause();
}

}  // namespace

extern "C" ssize_t recvmsg(int socket, msghdr* message, int flags) {
  static const auto next =
      reinterpret_cast<ssize_t (*)(int, msghdr*, int)>(dlsym(RTLD_NEXT, "recvmsg"));
  const ssize_t size = next(socket, message, flags);
  wedge();
  return size;
}

extern "C" ssize_t recvfrom(
    int socket, void* bytes, size_t size, int flags, sockaddr* from, socklen_t* length) {
  static const auto next =
      reinterpret_cast<ssize_t (*)(int, void*, size_t, int, sockaddr*, socklen_t*)>(
          dlsym(RTLD_NEXT, "recvfrom"));
  const ssize_t got = next(socket, bytes, size, flags, from, length);
  wedge();
  return got;
}
