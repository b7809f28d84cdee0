#include "core/base/resource_uri.h"

#include <algorithm>
#include <optional>
#include <set>
#include <sstream>
#include <string>

#include "core/base/environment.h"
#include "core/base/error.h"

namespace handgraft {

namespace fs = std::filesystem;

namespace {

bool startsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string decodePercent(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size()) {
      const int high = hexDigit(text[i + 1]);
      const int low = hexDigit(text[i + 2]);
      if (high >= 0 && low >= 0) {
        out.push_back(static_cast<char>(high * 16 + low));
        i += 2;
        continue;
      }
    }
    out.push_back(text[i]);
  }
  return out;
}

bool isFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool isFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

fs::path packageDirectory(const std::string& package,
                          const std::string& uri,
                          const fs::path& base_directory,
                          const PackageMap& packages) {
  if (const auto found = packages.find(package); found != packages.end()) return found->second;
  std::error_code error;
  fs::path folder = fs::absolute(base_directory, error);
  while (true) {
    if (folder.filename() == package) return folder;
    if (isFolder(folder / package)) return folder / package;
    if (!folder.has_relative_path()) break;
    folder = folder.parent_path();
  }
  rejectInput(
      "{}: package {} is not known, and no folder of that name lies above {}; name it "
      "with --package {}=DIR",
      quoted(uri), quoted(package), base_directory.string(), package);
}

struct PlaceInPackage {
  std::string package;
  std::string path;
};

/// Of "package://NAME/PATH"; nothing for other URIs.
std::optional<PlaceInPackage> placeInPackage(const std::string& uri) {
  const std::string scheme = "package://";
  if (!startsWith(uri, scheme)) return std::nullopt;
  const std::string rest = decodePercent(uri.substr(scheme.size()));
  const std::size_t slash = rest.find('/');
  if (slash == std::string::npos || slash == 0)
    rejectInput("{}: a package URI reads package://NAME/PATH", quoted(uri));
  return PlaceInPackage{rest.substr(0, slash), rest.substr(slash + 1)};
}

/// What stands in quotes behind `name=` in the text of one element. By hand: a std::regex takes
/// stack for every character, and names may have a million.
std::optional<std::string> attributeIn(const std::string& element, const std::string& name) {
  constexpr const char* kBlank = " \t\r\n\v\f";
  for (std::size_t at = element.find(name); at != std::string::npos;
       at = element.find(name, at + 1)) {
    const std::size_t sign = element.find_first_not_of(kBlank, at + name.size());
    if (sign == std::string::npos || element[sign] != '=') continue;
    const std::size_t quote = element.find_first_not_of(kBlank, sign + 1);
    if (quote == std::string::npos) continue;
    if (element[quote] != '"' && element[quote] != '\'') continue;
    const std::size_t end = element.find(element[quote], quote + 1);
    if (end != std::string::npos) return element.substr(quote + 1, end - quote - 1);
  }
  return std::nullopt;
}

}  // namespace

PackageMap amentPackages() {
  PackageMap packages;
  std::istringstream list(environment("AMENT_PREFIX_PATH"));
  for (std::string prefix; std::getline(list, prefix, ':');) {
    if (prefix.empty()) continue;
    std::error_code error;
    for (const fs::directory_entry& entry :
         fs::directory_iterator(fs::path(prefix) / "share", error))
      if (isFolder(entry.path())) packages.emplace(entry.path().filename(), entry.path());
  }
  return packages;
}

fs::path resolveResource(const std::string& uri,
                         const fs::path& base_directory,
                         const PackageMap& packages) {
  const std::string file_scheme = "file://";
  fs::path path;
  if (const auto inside = placeInPackage(uri)) {
    path = packageDirectory(inside->package, uri, base_directory, packages) / inside->path;
  } else if (startsWith(uri, file_scheme)) {
    path = decodePercent(uri.substr(file_scheme.size()));
  } else if (uri.find("://") != std::string::npos) {
    rejectInput("{}: only package://, file:// and plain paths can be read", quoted(uri));
  } else {
    path = uri;
  }
  if (path.is_relative()) path = base_directory / path;
  if (!isFile(path)) {
    rejectInput("{}: no such file (looked at {})", quoted(uri), quoted(path.string()));
  }
  return path;
}

fs::path resolveResourceWithin(const fs::path& within,
                               const std::string& uri,
                               const fs::path& base_directory,
                               const PackageMap& packages) {
  fs::path path;
  if (const auto inside = placeInPackage(uri)) {
    const auto found = packages.find(inside->package);
    if (found == packages.end()) {
      rejectInput("{}: package {} is not among the files that were given", quoted(uri),
                  quoted(inside->package));
    }
    path = found->second / fs::path(inside->path).relative_path();
  } else if (uri.find("://") != std::string::npos || fs::path(uri).is_absolute()) {
    rejectInput(
        "{}: only package:// and relative paths can be read of files that were given without "
        "their place",
        quoted(uri));
  } else {
    path = base_directory / uri;
  }
  path = path.lexically_normal();
  const fs::path root = within.lexically_normal();
  const auto [end, rest] = std::mismatch(root.begin(), root.end(), path.begin(), path.end());
  if (end != root.end() || rest == path.end()) {
    rejectInput("{}: it leads out of the files that were given", quoted(uri));
  }
  if (!isFile(path)) {
    rejectInput("{}: no such file among those that were given (looked for {})", quoted(uri),
                quoted(path.lexically_relative(root).string()));
  }
  return path;
}

std::vector<std::string> meshUrisIn(const std::string& urdf_text) {
  // A commented-out mesh need not exist.
  const std::string open = "<!--";
  const std::string close = "-->";
  std::string text;
  for (std::size_t at = 0; at < urdf_text.size();) {
    const std::size_t begin = urdf_text.find(open, at);
    text += urdf_text.substr(at, begin - at);
    if (begin == std::string::npos) break;
    const std::size_t end = urdf_text.find(close, begin + open.size());
    if (end == std::string::npos) break;
    at = end + close.size();
  }

  std::vector<std::string> uris;
  std::set<std::string> known;
  const std::string tag = "<mesh";
  for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at + 1)) {
    const std::size_t end = text.find('>', at);
    if (end == std::string::npos) break;
    const auto uri = attributeIn(text.substr(at, end - at), "filename");
    if (uri && known.insert(*uri).second) uris.push_back(*uri);
  }
  return uris;
}

}  // namespace handgraft
