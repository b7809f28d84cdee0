#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace handgraft::test {

/// How reading a file in a process of its own ended.
struct Reading {
  enum class End {
    kRead,     ///< without an error
    kRefused,  ///< InvalidInput
    kThrew,    ///< any other exception
    kDied,     ///< a signal: it crashed, or was stopped as it never came back
  };
  End end = End::kDied;
  std::string message;    ///< of the exception, or the signal's number
  double grown_mb = 0.0;  ///< the process's largest size beyond that before reading
};

/// Runs `read` in a child, which may crash, grow or hang without harm to other tests. A child
/// that has not come back after ten minutes is stopped.
Reading readApart(const std::function<void()>& read);

/// Whether memory can be judged: sanitizers keep what is freed, and shadows of it.
bool canMeasureMemory();

/// Requires that the file is refused in one line of bounded length that names it and `thing`,
/// for which the process grows by no more than 64 MB and 20 times the file's size.
void expectRefused(const std::filesystem::path& path,
                   const std::string& thing,
                   const std::function<void()>& read);

}  // namespace handgraft::test
