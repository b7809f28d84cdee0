#pragma once

#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace handgraft::hand {

/// Folders of files that take long to make, named by what they are made from: one that came
/// with the program and is only read, and one that is added to; either may be missing.
///
/// Several processes may share a folder: files appear whole. A folder that cannot be written
/// costs the next one who asks time, nothing else. Const, safe from several threads.
class KeptFiles {
 public:
  explicit KeptFiles(std::optional<std::filesystem::path> folder,
                     std::filesystem::path shipped = {});

  /// What `parse(bytes)` makes of the first file of that name of which it makes something (an
  /// optional); the shipped one comes first.
  template <class Parse>
  [[nodiscard]] auto find(const std::string& name, const Parse& parse) const
      -> decltype(parse(std::string_view())) {
    for (const std::filesystem::path& folder : {shipped_, folder_.value_or("")}) {
      const auto bytes = folder.empty() ? std::nullopt : contentOf(folder / name);
      if (!bytes) continue;
      if (auto found = parse(*bytes)) return found;
    }
    return std::nullopt;
  }

  void keep(const std::string& name, const std::string& bytes) const;

  [[nodiscard]] const std::optional<std::filesystem::path>& folder() const { return folder_; }

 private:
  static std::optional<std::string> contentOf(const std::filesystem::path& path);

  std::optional<std::filesystem::path> folder_;
  std::filesystem::path shipped_;
};

/// Bytes that say what they are (`format`, with its version), what they are made from (`key`,
/// 64 digits), and by a checksum at their end that they are whole.
std::string sealed(std::string_view format, const std::string& key, std::string_view content);

/// Their content; nothing if they are damaged, or of another format or key.
std::optional<std::string_view> unsealed(std::string_view bytes,
                                         std::string_view format,
                                         const std::string& key);

template <class Number>
void appendNumbers(std::string& bytes, const Number* numbers, std::size_t count) {
  const std::size_t start = bytes.size();
  bytes.resize(start + count * sizeof(Number));
  if (count > 0) std::memcpy(bytes.data() + start, numbers, count * sizeof(Number));
}

/// Takes numbers off the front; false if there are not as many.
template <class Number>
bool takeNumbers(std::string_view& bytes, Number* numbers, std::size_t count) {
  if (bytes.size() / sizeof(Number) < count) return false;
  if (count > 0) std::memcpy(numbers, bytes.data(), count * sizeof(Number));
  bytes.remove_prefix(count * sizeof(Number));
  return true;
}

}  // namespace handgraft::hand
