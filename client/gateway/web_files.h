#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace handgraft::client::gateway {

/// One file of the page, as it is served.
struct WebFile {
  std::string content_type;
  std::string bytes;
  std::string gzipped;  ///< the same, smaller; empty: there is none
};

/// The whole page by the paths of its addresses, "/" for its first file. Read once: whatever an
/// address says, no path of this machine is looked up for it.
using WebFiles = std::map<std::string, WebFile, std::less<>>;

/// Where the page lies: `share/handgraft/web` beside the folder of this program.
std::filesystem::path webFolder();

/// Errors: InvalidInput if the page was not built, saying what was missing.
WebFiles readWebFiles(const std::filesystem::path& folder);

}  // namespace handgraft::client::gateway
