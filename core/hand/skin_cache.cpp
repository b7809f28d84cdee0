#include "core/hand/skin_cache.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace fs = std::filesystem;

namespace {

/// Raise it with every change of the method or the file, and old files are made anew.
constexpr std::string_view kFormat = "handgraft-skin/2\n";
constexpr const char* kFolder = "handgraft/skins";
constexpr std::size_t kDigits = 64;
constexpr std::uintmax_t kLargestFile = 1U << 30U;

std::string digestOf(std::string_view bytes) {
  ContentHash hash;
  hash.add(bytes);
  return hash.finish();
}

template <class Number>
void append(std::string& bytes, const Number* numbers, std::size_t count) {
  const std::size_t start = bytes.size();
  bytes.resize(start + count * sizeof(Number));
  std::memcpy(bytes.data() + start, numbers, count * sizeof(Number));
}

/// Takes numbers off the front; false if there are not as many.
template <class Number>
bool take(std::string_view& bytes, Number* numbers, std::size_t count) {
  if (bytes.size() / sizeof(Number) < count) return false;
  std::memcpy(numbers, bytes.data(), count * sizeof(Number));
  bytes.remove_prefix(count * sizeof(Number));
  return true;
}

std::optional<std::string> contentOf(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > kLargestFile) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(size))) return std::nullopt;
  return bytes;
}

/// Under another name first: a reader never sees half a file.
void keep(const fs::path& path, const std::string& bytes) {
  static std::atomic<unsigned> count{0};
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  fs::path half = path;
  half += fmt::format(".{}.{}.part", ::getpid(), count++);
  std::ofstream file(half, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (file) fs::rename(half, path, error);
  if (!file || error) fs::remove(half, error);
}

}  // namespace

std::string skinKey(const HandModel& model, const SkinOptions& options) {
  const Eigen::VectorXd q = skinReferencePose(model);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), q, X_SL);
  const LinkSurfaces links = linkSurfaces(model, X_SL, options.source);
  ContentHash hash;
  hash.add(kFormat);
  const std::array<double, 4> lengths{options.alpha_m, options.offset_m, options.edge_m,
                                      options.epsilon_m};
  hash.addNumbers(lengths.data(), lengths.size());
  const std::array<std::int64_t, 4> counts{options.source == SurfaceSource::kVisuals ? 0 : 1,
                                           q.size(), links.mesh_A.vertexCount(),
                                           links.mesh_A.faceCount()};
  hash.addNumbers(counts.data(), counts.size());
  hash.addNumbers(q.data(), static_cast<std::size_t>(q.size()));
  hash.addNumbers(links.mesh_A.vertices().data(),
                  static_cast<std::size_t>(links.mesh_A.vertices().size()));
  hash.addNumbers(links.mesh_A.faces().data(),
                  static_cast<std::size_t>(links.mesh_A.faces().size()));
  hash.addNumbers(links.face_links.data(), links.face_links.size());
  return hash.finish();
}

std::string serialise(const StoredSkin& skin, const std::string& key) {
  HANDGRAFT_REQUIRE(key.size() == kDigits);
  std::string bytes(kFormat);
  bytes += key;
  const std::array<std::uint64_t, 3> counts{
      static_cast<std::uint64_t>(skin.mesh_S.vertexCount()),
      static_cast<std::uint64_t>(skin.mesh_S.faceCount()), skin.notes.size()};
  append(bytes, counts.data(), counts.size());
  append(bytes, skin.mesh_S.vertices().data(),
         static_cast<std::size_t>(skin.mesh_S.vertices().size()));
  append(bytes, skin.mesh_S.faces().data(),
         static_cast<std::size_t>(skin.mesh_S.faces().size()));
  for (const std::string& note : skin.notes) {
    const std::uint64_t length = note.size();
    append(bytes, &length, 1);
    bytes += note;
  }
  return bytes + digestOf(bytes);
}

std::optional<StoredSkin> deserialise(std::string_view bytes, const std::string& key) {
  if (bytes.size() < kFormat.size() + 2 * kDigits || !bytes.starts_with(kFormat) ||
      bytes.substr(kFormat.size(), kDigits) != key ||
      bytes.substr(bytes.size() - kDigits) != digestOf(bytes.substr(0, bytes.size() - kDigits)))
    return std::nullopt;
  bytes.remove_prefix(kFormat.size() + kDigits);
  bytes.remove_suffix(kDigits);

  std::array<std::uint64_t, 3> counts{};
  if (!take(bytes, counts.data(), counts.size()) || counts[0] > bytes.size() / sizeof(double) ||
      counts[1] > bytes.size() / sizeof(int))
    return std::nullopt;
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(counts[0]));
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(counts[1]));
  if (!take(bytes, vertices.data(), static_cast<std::size_t>(vertices.size())) ||
      !take(bytes, faces.data(), static_cast<std::size_t>(faces.size())))
    return std::nullopt;
  StoredSkin skin;
  for (std::uint64_t i = 0; i < counts[2]; ++i) {
    std::uint64_t length = 0;
    if (!take(bytes, &length, 1) || length > bytes.size()) return std::nullopt;
    skin.notes.emplace_back(bytes.substr(0, static_cast<std::size_t>(length)));
    bytes.remove_prefix(static_cast<std::size_t>(length));
  }
  if (!bytes.empty()) return std::nullopt;
  try {
    skin.mesh_S = geometry::TriangleMesh(std::move(vertices), std::move(faces));
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  if (skin.mesh_S.faceCount() == 0 || !skin.mesh_S.isClosed()) return std::nullopt;
  return skin;
}

SkinCache::SkinCache(std::optional<fs::path> folder, fs::path shipped)
    : folder_(std::move(folder)), shipped_(std::move(shipped)) {}

SkinCache SkinCache::fromEnvironment(fs::path shipped) {
  const auto absolute = [](const char* name) -> std::optional<fs::path> {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody writes the environment.
    const char* value = std::getenv(name);
    if (value == nullptr || !fs::path(value).is_absolute()) return std::nullopt;
    return fs::path(value);
  };
  if (const auto cache = absolute("XDG_CACHE_HOME")) {
    return SkinCache(*cache / kFolder, std::move(shipped));
  }
  if (const auto home = absolute("HOME")) {
    return SkinCache(*home / ".cache" / kFolder, std::move(shipped));
  }
  return SkinCache(std::nullopt, std::move(shipped));
}

Skin SkinCache::get(const HandModel& model,
                    const SkinOptions& options,
                    const Progress& progress,
                    SkinReport* report) const {
  const auto start = std::chrono::steady_clock::now();
  const std::string key = skinKey(model, options);
  const std::string name = key + ".skin";
  for (const fs::path& folder : {shipped_, folder_.value_or(fs::path())}) {
    const auto bytes = folder.empty() ? std::nullopt : contentOf(folder / name);
    if (auto stored = bytes ? deserialise(*bytes, key) : std::nullopt) {
      progress.report("relating skin and links", 0.9);
      Skin skin(model, std::move(stored->mesh_S), skinReferencePose(model), options.epsilon_m,
                options.source);
      if (report != nullptr) {
        *report = SkinReport();
        report->from_cache = true;
        report->notes = std::move(stored->notes);
        report->time_s =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      }
      return skin;
    }
  }
  SkinReport made;
  Skin skin = buildSkin(model, options, progress, &made);
  if (folder_) keep(*folder_ / name, serialise({skin.mesh(), made.notes}, key));
  if (report != nullptr) *report = std::move(made);
  return skin;
}

}  // namespace handgraft::hand
