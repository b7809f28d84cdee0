#include "server/store/upload_reader.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "server/base/rejection.h"
#include "server/log/log.h"
#include "server/reading/frames.h"
#include "server/reading/packed.h"
#include "server/reading/units.h"
#include "server/store/child_process.h"

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

/// How a reading process came to its end without an answer.
enum class End { kByItself, kOutOfTime, kNonsense };

/// One reading process, listened to until it has answered.
class Conversation {
 public:
  Conversation(ChildProcess& child, const Progress& progress, Clock::time_point deadline)
      : child_(child), progress_(progress), deadline_(deadline) {}

  /// The answer, or nothing if there is none: then `end` says why. Errors: Cancelled.
  std::optional<Frame> answer() {
    try {
      while (true) {
        progress_.checkpoint();
        if (Clock::now() > deadline_) {
          end_ = End::kOutOfTime;
          return std::nullopt;
        }
        const bool ended = child_.hasEnded();  // before the last look at what it said
        wait(ended);
        if (auto frame = hear()) return frame;
        if (ended && !heard_) return std::nullopt;
      }
    } catch (const InvalidInput& nonsense) {
      end_ = End::kNonsense;
      complaint_ = nonsense.what();
      return std::nullopt;
    }
  }

  [[nodiscard]] End end() const { return end_; }

  /// The start of what it wrote to standard error.
  [[nodiscard]] const std::string& complaint() const { return complaint_; }

 private:
  void wait(bool ended) {
    constexpr int kGlanceMs = 50;
    constexpr int kShortMs = 5;  // its end is no event of the pipes, if others hold them
    std::array<pollfd, 2> pipes{{{out_open_ ? child_.out().get() : -1, POLLIN, 0},
                                 {err_open_ ? child_.err().get() : -1, POLLIN, 0}}};
    poll(pipes.data(), pipes.size(), ended ? 0 : (out_open_ ? kGlanceMs : kShortMs));
  }

  std::optional<Frame> hear() {
    std::array<char, 1 << 16> piece{};
    heard_ = false;
    if (const std::size_t count = take(child_.err(), err_open_, piece); count > 0) {
      constexpr std::size_t kMostComplaint = 4096;
      complaint_.append(piece.data(), std::min(count, kMostComplaint - complaint_.size()));
      heard_ = true;
    }
    if (const std::size_t count = take(child_.out(), out_open_, piece); count > 0) {
      frames_.add({piece.data(), count});
      heard_ = true;
    }
    while (auto frame = frames_.next()) {
      if (frame->kind != FrameKind::kProgress) return frame;
      const ProgressWords words = progressIn(frame->payload);
      progress_.report(words.stage, words.fraction);
    }
    return std::nullopt;
  }

  static std::size_t take(const OwnedFd& pipe, bool& open, std::array<char, 1 << 16>& piece) {
    if (!open) return 0;
    const ssize_t count = ::read(pipe.get(), piece.data(), piece.size());
    if (count == 0) open = false;
    if (count < 0 && errno != EAGAIN && errno != EINTR) open = false;
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

  ChildProcess& child_;
  const Progress& progress_;
  Clock::time_point deadline_;
  FrameReader frames_;
  bool out_open_ = true;
  bool err_open_ = true;
  bool heard_ = false;
  End end_ = End::kByItself;
  std::string complaint_;
};

std::string timeText(const ReaderLimits& limits) {
  return fmt::format("took more than {} s", limits.time.count());
}

std::string memoryText(const ReaderLimits& limits) {
  return fmt::format("needed more than {} MB of memory", limits.memory_mb);
}

/// "took more than 120 s": how a process ended that did not answer.
std::string wayOfEnd(End end, int status, const ReaderLimits& limits) {
  if (end == End::kNonsense) return "gave no sensible answer";
  if (end == End::kOutOfTime) return timeText(limits);
  if (status < 0) return "ended without an answer";
  if (!WIFSIGNALED(status))
    return fmt::format("ended without an answer, with exit code {}", WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  // The processor's time has its limit, too.
  if (signal == SIGXCPU) return timeText(limits);
  if (signal == SIGSYS)
    return "tried what no file needs: a call of the system that is forbidden";
  if (signal == SIGKILL) return "was killed by the system, which may be out of memory";
  return fmt::format("ended by signal {} ({})", signal, sigdescr_np(signal));
}

/// Nobody vouches for what the process says.
constexpr std::size_t kLongestWords = 2000;

}  // namespace

UploadReader::UploadReader(fs::path program, ReaderLimits limits)
    : program_(std::move(program)), limits_(limits) {
  if (limits_.memory_mb < 64 || limits_.memory_mb > (1u << 20))
    rejectInput("memory of a reader is {} MB; permitted are 64 to 1048576", limits_.memory_mb);
  if (limits_.time.count() < 1 || limits_.time.count() > 86'400)
    rejectInput("time of a reader is {} s; permitted are 1 to 86400", limits_.time.count());
  if (access(program_.c_str(), X_OK) != 0) {
    rejectInput("{}: the program that reads uploads is not there, or cannot be executed",
                handgraft::quoted(program_.string()));
  }
}

ReadModel UploadReader::read(const ReadRequest& request, const Progress& progress) const {
  progress.checkpoint();
  const auto deadline = Clock::now() + limits_.time;
  const auto start = [&]() -> ChildProcess {
    return {program_,
            {std::to_string(limits_.memory_mb), std::to_string(limits_.time.count()),
             std::to_string(getpid())},
            memoryFile(pack(request))};
  };
  std::optional<Frame> answer;
  End end = End::kByItself;
  std::string complaint;
  int status = 0;
  try {
    ChildProcess child = start();
    Conversation conversation(child, progress, deadline);
    answer = conversation.answer();
    child.kill();
    end = conversation.end();
    complaint = conversation.complaint();
    status = child.status();
  } catch (const std::system_error& error) {
    log::error("event=reader_not_started what={}", handgraft::quoted(error.what()));
    reject(v1::ERROR_OVERLOADED, "no process could be started to read the file: {}",
           error.code().message());
  }
  const auto reject_logged = [&](const std::string& how) {
    log::warn("event=reader_failed model={} file={} how={} said={}",
              handgraft::quoted(request.name), handgraft::quoted(request.main_uri),
              handgraft::quoted(how), handgraft::quoted(complaint));
    rejectInput("reading {} {}; the file is damaged or beyond what is supported",
                handgraft::quoted(request.main_uri), how);
  };
  if (!answer) reject_logged(wayOfEnd(end, status, limits_));
  switch (answer->kind) {
    case FrameKind::kModel:
      break;
    case FrameKind::kUnits:
      throw UnitsInDoubt(onOneLine(answer->payload, kLongestWords));
    case FrameKind::kMemory:
      reject_logged(memoryText(limits_));
      break;
    case FrameKind::kMistake:
      throw std::runtime_error(onOneLine(answer->payload, kLongestWords));
    case FrameKind::kWrong:
    case FrameKind::kProgress:
      throw InvalidInput(onOneLine(answer->payload, kLongestWords));
  }
  std::string fault;
  try {
    ReadModel model = unpackModel(answer->payload, request.contacts.object.get());
    if (answers(model, request.kind)) return model;
    fault = "another kind of model";
  } catch (const InvalidInput& error) {
    fault = fmt::format("a model that is none ({})", error.what());
  }
  reject_logged("gave " + fault);
  throw BrokenContract("not reached");
}

fs::path readerProgram() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path("handgraft-reader") : program.parent_path() / "handgraft-reader";
}

}  // namespace handgraft::server
