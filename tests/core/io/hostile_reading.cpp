#include "tests/core/io/hostile_reading.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/sanitized.h"

namespace handgraft::test {

namespace {

double largestMb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void writeAll(int file, const void* bytes, std::size_t size) {
  const auto* at = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t count = write(file, at, size);
    if (count <= 0) return;
    at += count;
    size -= static_cast<std::size_t>(count);
  }
}

[[noreturn]] void runChild(const std::function<void()>& read, int answer) {
  constexpr unsigned kLongest = 600;  // s
  alarm(kLongest);
  Reading reading;
  const double before = largestMb();
  try {
    read();
    reading.end = Reading::End::kRead;
  } catch (const InvalidInput& error) {
    reading.end = Reading::End::kRefused;
    reading.message = error.what();
  } catch (const std::exception& error) {
    reading.end = Reading::End::kThrew;
    reading.message = error.what();
  }
  reading.grown_mb = largestMb() - before;
  writeAll(answer, &reading.end, sizeof reading.end);
  writeAll(answer, &reading.grown_mb, sizeof reading.grown_mb);
  writeAll(answer, reading.message.data(), reading.message.size());
  _exit(0);
}

std::string readAll(int file) {
  std::string bytes;
  std::array<char, 4096> part{};
  while (true) {
    const ssize_t count = ::read(file, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return bytes;
    bytes.append(part.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace

Reading readApart(const std::function<void()>& read) {
  std::array<int, 2> pipe_ends{};
  HANDGRAFT_REQUIRE(pipe(pipe_ends.data()) == 0);
  const pid_t child = fork();
  HANDGRAFT_REQUIRE(child >= 0);
  if (child == 0) {
    close(pipe_ends[0]);
    runChild(read, pipe_ends[1]);
  }
  close(pipe_ends[1]);
  const std::string answer = readAll(pipe_ends[0]);
  close(pipe_ends[0]);
  int status = 0;
  waitpid(child, &status, 0);

  Reading reading;
  constexpr std::size_t kHead = sizeof reading.end + sizeof reading.grown_mb;
  if (!WIFEXITED(status) || answer.size() < kHead) {
    reading.message = WIFSIGNALED(status)
                          ? "ended by signal " + std::to_string(WTERMSIG(status))
                          : "ended without an answer";
    return reading;
  }
  std::memcpy(&reading.end, answer.data(), sizeof reading.end);
  std::memcpy(&reading.grown_mb, answer.data() + sizeof reading.end, sizeof reading.grown_mb);
  reading.message = answer.substr(kHead);
  return reading;
}

bool canMeasureMemory() {
  return !kIsSanitized;
}

void expectRefused(const std::filesystem::path& path,
                   const std::string& thing,
                   const std::function<void()>& read) {
  constexpr std::size_t kLongestMessage = 3000;
  SCOPED_TRACE(path.string());
  const Reading reading = readApart(read);
  EXPECT_EQ(reading.end, Reading::End::kRefused) << reading.message;
  EXPECT_THAT(reading.message, ::testing::HasSubstr(path.filename().string()));
  EXPECT_THAT(reading.message, ::testing::HasSubstr(thing));
  EXPECT_THAT(reading.message, ::testing::Not(::testing::HasSubstr("\n")));
  EXPECT_LT(reading.message.size(), kLongestMessage);
  if (!canMeasureMemory()) return;
  const double file_mb =
      static_cast<double>(std::filesystem::file_size(path)) / (1024.0 * 1024.0);
  EXPECT_LE(reading.grown_mb, 64.0 + 20.0 * file_mb);
}

}  // namespace handgraft::test
