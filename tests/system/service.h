#pragma once

#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/network.h"

#include "tests/support/process.h"
#include "tests/support/test_domain.h"

namespace handgraft::test {

/// Where the build put `handgraft`, `handgraft-server`, `handgraft-bridge`.
std::filesystem::path program(const std::string& name);

/// A server of its own DDS domain, so that tests run side by side.
class Service {
 public:
  /// Starts `handgraft-server` and waits until it answers.
  explicit Service(const std::vector<std::string>& server_arguments = {});

  [[nodiscard]] int domain() const { return domain_.number(); }

  [[nodiscard]] Network network() const { return {domain_.number(), "lo"}; }

  [[nodiscard]] Process& server() { return *server_; }

  /// Runs `handgraft ARGUMENTS... --domain N`.
  [[nodiscard]] Finished client(std::vector<std::string> arguments) const;
  /// As above with --json; fails the test unless it ends with 0 and prints one JSON document.
  [[nodiscard]] nlohmann::json ask(std::vector<std::string> arguments) const;
  /// Starts a program on this domain and lets it run.
  [[nodiscard]] std::unique_ptr<Process> start(const std::string& name,
                                               std::vector<std::string> arguments) const;

 private:
  TestDomain domain_;
  std::unique_ptr<Process> server_;
};

}  // namespace handgraft::test
