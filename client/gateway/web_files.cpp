#include "client/gateway/web_files.h"

#include "client/link/model_files.h"
#include "core/base/error.h"

namespace handgraft::client::gateway {

namespace fs = std::filesystem;

namespace {

constexpr const char* kFirst = "index.html";
constexpr const char* kZipped = ".gz";

std::string contentTypeOf(const fs::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".html") return "text/html; charset=utf-8";
  if (extension == ".js") return "text/javascript; charset=utf-8";
  if (extension == ".css") return "text/css; charset=utf-8";
  if (extension == ".svg") return "image/svg+xml";
  if (extension == ".txt") return "text/plain; charset=utf-8";
  return "application/octet-stream";
}

}  // namespace

fs::path webFolder() {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return self.parent_path().parent_path() / "share/handgraft/web";
}

WebFiles readWebFiles(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_regular_file(folder / kFirst, error)) {
    rejectInput(
        "there is no page in {}: it is built with Handgraft where nodejs and npm are installed "
        "and npm reaches its registry; install them and build again",
        quoted(folder.string()));
  }
  WebFiles files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (!entry.is_regular_file() || path.extension() == kZipped) continue;
    WebFile file{contentTypeOf(path), readFile(path), {}};
    const fs::path zipped = path.string() + kZipped;
    if (fs::is_regular_file(zipped, error)) file.gzipped = readFile(zipped);
    const std::string name = path.filename().string();
    files[name == kFirst ? "/" : "/" + name] = std::move(file);
  }
  return files;
}

}  // namespace handgraft::client::gateway
