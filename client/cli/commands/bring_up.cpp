#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "client/cli/commands/commands.h"
#include "core/base/error.h"

namespace handgraft::client {

// The bridge's program takes this one's place: standard input and signals are its own then.
int run(const BringUpOptions& options,
        const CommonOptions& /*common*/,
        Interruption& /*interruption*/) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  const fs::path beside = self.parent_path() / "handgraft-bridge";
  const std::string program =
      !error && fs::exists(beside) ? beside.string() : std::string("handgraft-bridge");
  std::vector<std::string> all = options.arguments;
  all.insert(all.begin(), program);
  std::vector<char*> arguments;
  arguments.reserve(all.size() + 1);
  for (std::string& argument : all)
    arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  execvp(program.c_str(), arguments.data());
  throw TransportError(fmt::format("{} cannot be started", quoted(program)));
}

}  // namespace handgraft::client
