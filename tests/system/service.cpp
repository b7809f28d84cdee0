#include "tests/system/service.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <gtest/gtest.h>

#include "idl/cyclone/requester.h"

namespace handgraft::test {

std::filesystem::path program(const std::string& name) {
  return std::filesystem::path(HANDGRAFT_BIN_DIR) / name;
}

Service::Service(const std::vector<std::string>& server_arguments) {
  server_ = start("handgraft-server", server_arguments);
  const idl::cyclone::Participant participant(network());
  idl::cyclone::Requester requester(participant);
  // Generous: a loaded machine or a sanitizer makes the start slow, not wrong.
  if (!requester.waitForServer(std::chrono::seconds(60))) {
    throw std::runtime_error("the server does not answer; it wrote:\n" + server_->err());
  }
}

std::unique_ptr<Process> Service::start(const std::string& name,
                                        std::vector<std::string> arguments) const {
  const bool keeps =
      std::find(arguments.begin(), arguments.end(), "--state") != arguments.end();
  if (name == "handgraft-server" && !keeps)
    arguments.insert(arguments.end(), {"--state", ":memory:"});
  arguments.insert(arguments.end(), {"--domain", std::to_string(domain_.number())});
  return std::make_unique<Process>(program(name), arguments);
}

Finished Service::client(std::vector<std::string> arguments) const {
  arguments.insert(arguments.end(), {"--domain", std::to_string(domain_.number())});
  return run(program("handgraft"), arguments);
}

nlohmann::json Service::ask(std::vector<std::string> arguments) const {
  arguments.emplace_back("--json");
  const Finished finished = client(arguments);
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  nlohmann::json document = nlohmann::json::parse(finished.out, nullptr, false);
  EXPECT_FALSE(document.is_discarded()) << "not one JSON document:\n" << finished.out;
  return document;
}

}  // namespace handgraft::test
