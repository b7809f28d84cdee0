#pragma once

#include <string>

namespace handgraft::client {

/// One line on standard error that shows what goes on; only where that is a terminal. Cleared
/// when this goes out of scope.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& stage, double fraction);
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
};

}  // namespace handgraft::client
