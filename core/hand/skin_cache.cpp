#include "core/hand/skin_cache.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <utility>

#include "core/base/content_hash.h"
#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace fs = std::filesystem;

namespace {

/// Raise it with every change of the method or the file, and old files are made anew.
constexpr std::string_view kFormat = "handgraft-skin/3\n";
constexpr const char* kFolder = "handgraft/skins";

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
  std::string bytes;
  const std::array<std::uint64_t, 3> counts{
      static_cast<std::uint64_t>(skin.mesh_S.vertexCount()),
      static_cast<std::uint64_t>(skin.mesh_S.faceCount()), skin.notes.size()};
  appendNumbers(bytes, counts.data(), counts.size());
  appendNumbers(bytes, skin.mesh_S.vertices().data(),
                static_cast<std::size_t>(skin.mesh_S.vertices().size()));
  appendNumbers(bytes, skin.mesh_S.faces().data(),
                static_cast<std::size_t>(skin.mesh_S.faces().size()));
  for (const std::string& note : skin.notes) {
    const std::uint64_t length = note.size();
    appendNumbers(bytes, &length, 1);
    bytes += note;
  }
  const std::uint64_t link_count = skin.face_links.size();
  appendNumbers(bytes, &link_count, 1);
  appendNumbers(bytes, skin.face_links.data(), skin.face_links.size());
  return sealed(kFormat, key, bytes);
}

std::optional<StoredSkin> deserialise(std::string_view file, const std::string& key) {
  const auto content = unsealed(file, kFormat, key);
  if (!content) return std::nullopt;
  std::string_view bytes = *content;
  std::array<std::uint64_t, 3> counts{};
  if (!takeNumbers(bytes, counts.data(), counts.size()) ||
      counts[0] > bytes.size() / sizeof(double) || counts[1] > bytes.size() / sizeof(int))
    return std::nullopt;
  Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(counts[0]));
  Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(counts[1]));
  if (!takeNumbers(bytes, vertices.data(), static_cast<std::size_t>(vertices.size())) ||
      !takeNumbers(bytes, faces.data(), static_cast<std::size_t>(faces.size())))
    return std::nullopt;
  StoredSkin skin;
  for (std::uint64_t i = 0; i < counts[2]; ++i) {
    std::uint64_t length = 0;
    if (!takeNumbers(bytes, &length, 1) || length > bytes.size()) return std::nullopt;
    skin.notes.emplace_back(bytes.substr(0, static_cast<std::size_t>(length)));
    bytes.remove_prefix(static_cast<std::size_t>(length));
  }
  std::uint64_t link_count = 0;
  if (!takeNumbers(bytes, &link_count, 1) || (link_count != 0 && link_count != counts[1]))
    return std::nullopt;
  skin.face_links.resize(link_count);
  if (!takeNumbers(bytes, skin.face_links.data(), skin.face_links.size()) || !bytes.empty())
    return std::nullopt;
  try {
    skin.mesh_S = geometry::TriangleMesh(std::move(vertices), std::move(faces));
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  if (skin.mesh_S.faceCount() == 0 || !skin.mesh_S.isClosed()) return std::nullopt;
  return skin;
}

SkinCache::SkinCache(std::optional<fs::path> folder, fs::path shipped)
    : files_(std::make_shared<const KeptFiles>(std::move(folder), std::move(shipped))) {}

SkinCache SkinCache::fromEnvironment(fs::path shipped) {
  std::optional<fs::path> cache = userFolder("XDG_CACHE_HOME", ".cache");
  if (cache) *cache /= kFolder;
  return SkinCache(std::move(cache), std::move(shipped));
}

Skin SkinCache::get(const HandModel& model,
                    const SkinOptions& options,
                    const Progress& progress,
                    SkinReport* report) const {
  const auto start = std::chrono::steady_clock::now();
  const std::string key = skinKey(model, options);
  const std::string name = key + ".skin";
  const auto parse = [&](std::string_view bytes) {
    auto stored = deserialise(bytes, key);
    const bool names_links =
        stored &&
        std::all_of(stored->face_links.begin(), stored->face_links.end(), [&](int link) {
          return link >= -1 && link < model.linkCount();
        });
    return names_links ? std::move(stored) : std::nullopt;
  };
  if (auto stored = files_->find(name, parse)) {
    progress.report("relating skin and links", 0.9);
    Skin skin = stored->face_links.empty()
                    ? Skin(model, std::move(stored->mesh_S), skinReferencePose(model),
                           options.epsilon_m, options.source)
                    : Skin(model, std::move(stored->mesh_S), skinReferencePose(model),
                           options.epsilon_m, options.source, std::move(stored->face_links));
    skin.keepIn(files_);
    if (report != nullptr) {
      *report = SkinReport();
      report->from_cache = true;
      report->notes = std::move(stored->notes);
      report->time_s =
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }
    return skin;
  }
  SkinReport made;
  Skin skin = buildSkin(model, options, progress, &made);
  if (files_->folder())
    files_->keep(name, serialise({skin.mesh(), made.notes, skin.faceLinks()}, key));
  skin.keepIn(files_);
  if (report != nullptr) *report = std::move(made);
  return skin;
}

}  // namespace handgraft::hand
