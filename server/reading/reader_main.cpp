// handgraft-reader MEMORY_MB SECONDS PARENT: reads one upload for the server that started it.
//
// Standard input is the packed request (a file), standard output takes frames. All that is
// confined is confined before the first byte of anybody's file is looked at; the request is the
// server's own, and says which files those are.

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <string_view>

#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"
#include "server/reading/confinement.h"
#include "server/reading/frames.h"
#include "server/reading/packed.h"
#include "server/reading/sandbox.h"
#include "server/reading/units.h"

namespace handgraft {
namespace {
using server::FrameKind;

std::string requestBytes() {
  struct stat status {};

  if (fstat(STDIN_FILENO, &status) != 0 || !S_ISREG(status.st_mode))
    throw BrokenContract("standard input is no file");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count =
        pread(STDIN_FILENO, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (count <= 0) throw BrokenContract("the request cannot be read");
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

/// Nobody is left to tell if this fails.
void send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (count <= 0) _exit(EXIT_FAILURE);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

/// Listens to the work; tells of a stage at most every 50 ms.
Progress::Listener teller() {
  using Clock = std::chrono::steady_clock;
  return [told = Clock::time_point(), stage = std::string()](std::string_view now,
                                                             double fraction) mutable {
    constexpr std::chrono::milliseconds kOften(50);
    if (now == stage && Clock::now() - told < kOften) return;
    told = Clock::now();
    stage = now;
    send(server::progressFrame(now, fraction));
  };
}

void answer() {
  try {
    const server::ReadRequest request = server::unpackRequest(requestBytes());
    server::forbidAllButReading(server::filesOf(request));
    const std::string model = server::pack(server::readModel(request, Progress(teller())));
    if (model.size() > server::kMostModelBytes) {
      rejectInput("what it holds takes {} MB; permitted are {}", model.size() >> 20,
                  server::kMostModelBytes >> 20);
    }
    send(server::framed(FrameKind::kModel, model));
  } catch (const server::UnitsInDoubt& doubt) {
    send(server::framed(FrameKind::kUnits, doubt.what()));
  } catch (const InvalidInput& error) {
    send(server::framed(FrameKind::kWrong, error.what()));
  } catch (const std::bad_alloc&) {
    send(server::framed(FrameKind::kMemory, ""));
  } catch (const std::exception& error) {
    send(server::framed(FrameKind::kMistake, error.what()));
  }
}

}  // namespace
}  // namespace handgraft

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fputs("handgraft-reader: handgraft-server starts it, nobody else\n", stderr);
    return 2;
  }
  try {
    handgraft::server::Confinement limits;
    limits.memory_bytes = std::stoull(argv[1]) << 20;
    limits.seconds = static_cast<unsigned>(std::stoul(argv[2]));
    handgraft::server::confine(limits, static_cast<pid_t>(std::stol(argv[3])));
    handgraft::answer();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-reader: %s\n", error.what());
    _exit(EXIT_FAILURE);
  }
  _exit(EXIT_SUCCESS);  // the system frees a model's memory faster than its destructors
}
