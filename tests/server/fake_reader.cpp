// A reader of uploads that comes to a bad end, or lies: the model's name says how.

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/reading/confinement.h"
#include "server/reading/frames.h"
#include "server/reading/packed.h"
#include "server/reading/sandbox.h"

namespace {

using namespace handgraft::server;

void say(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = write(STDOUT_FILENO, bytes.data() + done, bytes.size() - done);
    if (count <= 0) _exit(3);
    done += static_cast<std::size_t>(count);
  }
}

std::string request() {
  struct stat status {};

  fstat(STDIN_FILENO, &status);
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  return pread(STDIN_FILENO, bytes.data(), bytes.size(), 0) < 0 ? "" : bytes;
}

void eat() {
  try {
    std::vector<std::string> eaten;
    while (true)
      eaten.emplace_back(std::size_t{16} << 20, 'x');
  } catch (const std::bad_alloc&) {
    say(framed(FrameKind::kMemory, ""));
  }
}

int openDescriptors() {
  int open = 0;
  for (int fd = 0; fd < 1024; ++fd)
    open += fcntl(fd, F_GETFD) >= 0 ? 1 : 0;
  return open;
}

void act(const std::string& name) {
  if (name == "crashes") std::raise(SIGSEGV);
  if (name == "aborts") {
    std::fputs("a long\nstory", stderr);
    std::abort();
  }
  if (name == "quits") _exit(7);
  if (name == "eats") eat();
  while (name == "tells_its_id") {
    say(progressFrame(std::to_string(getpid()), 0.5));
    usleep(10'000);
  }
  while (name == "sleeps") {
    say(progressFrame("sleeping", 0.5));
    usleep(10'000);
  }
  volatile unsigned turns = 0;
  while (name == "spins")
    turns = turns + 1;
  if (name == "writes") {
    const int file = open("/dev/shm/handgraft-fake-reader", O_CREAT | O_WRONLY, 0600);
    if (file >= 0 && write(file, "x", 1) == 1) say(framed(FrameKind::kWrong, "wrote"));
  }
  if (name == "opens") {
    if (open("/etc/hostname", O_RDONLY) >= 0) say(framed(FrameKind::kWrong, "opened"));
    say(framed(FrameKind::kWrong, errno == EACCES ? "denied" : "another error"));
  }
  if (name == "connects" && socket(AF_INET, SOCK_STREAM, 0) != -2)
    say(framed(FrameKind::kWrong, "went on"));
  if (name == "forks" && fork() != -2) say(framed(FrameKind::kWrong, "went on"));
  if (name == "executes" && execl("/bin/true", "true", nullptr) != -2)
    say(framed(FrameKind::kWrong, "went on"));
  if (name == "signals" && kill(getppid(), 0) != -2) say(framed(FrameKind::kWrong, "went on"));
  if (name == "removes" && unlink("/tmp/handgraft-no-such-file") != -2)
    say(framed(FrameKind::kWrong, "went on"));
  if (name == "babbles") say(std::string(1 << 20, 'z'));
  if (name == "boasts") say(std::string("m") + std::string(8, '\x7f'));
  if (name == "stops_short")
    say(framed(FrameKind::kModel, std::string(100, 'a')).substr(0, 50));
  if (name == "lies") say(framed(FrameKind::kModel, std::string(100, '\x01')));
  if (name == "mistakes_kinds")
    say(framed(FrameKind::kModel, pack(ReadModel(ObjectName{"x"}))));
  if (name == "counts")
    say(framed(FrameKind::kWrong, std::to_string(openDescriptors()) + " open descriptors"));
  if (name == "errs") say(framed(FrameKind::kMistake, "it is\nmy fault"));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  Confinement limits;
  limits.memory_bytes = std::stoull(argv[1]) << 20;
  limits.seconds = static_cast<unsigned>(std::stoul(argv[2]));
  confine(limits, static_cast<pid_t>(std::stol(argv[3])));
  const ReadRequest asked = unpackRequest(request());
  forbidAllButReading(filesOf(asked));
  act(asked.name);
  return 0;
}
