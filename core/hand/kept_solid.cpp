#include "core/hand/kept_solid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/hand/kept_files.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

/// Raise it with every change of the method or the file, and old files are made anew.
constexpr std::string_view kFormat = "handgraft-solid/2\n";

void add(const geometry::TriangleMesh& mesh, ContentHash& hash) {
  hash.addNumber<std::int64_t>(mesh.vertexCount());
  hash.addNumber<std::int64_t>(mesh.faceCount());
  hash.addNumbers(mesh.vertices().data(), static_cast<std::size_t>(mesh.vertices().size()));
  hash.addNumbers(mesh.faces().data(), static_cast<std::size_t>(mesh.faces().size()));
}

template <class Number>
void appendList(std::string& bytes, const std::vector<Number>& list) {
  const std::uint64_t count = list.size();
  appendNumbers(bytes, &count, 1);
  appendNumbers(bytes, list.data(), list.size());
}

template <class Number>
bool takeList(std::string_view& bytes, std::vector<Number>& list) {
  std::uint64_t count = 0;
  if (!takeNumbers(bytes, &count, 1) || count > bytes.size() / sizeof(Number)) return false;
  list.resize(count);
  return takeNumbers(bytes, list.data(), list.size());
}

/// Their coordinates, one after another.
std::vector<double> coordinatesOf(const geometry::SignedDistance::Corners& corners) {
  std::vector<double> coordinates;
  coordinates.reserve(3 * corners.size());
  for (const Eigen::Vector3d& corner : corners)
    coordinates.insert(coordinates.end(), {corner.x(), corner.y(), corner.z()});
  return coordinates;
}

/// Whole faces of finite corners; nothing if that is not what they are.
std::optional<geometry::SignedDistance::Corners> cornersOf(
    const std::vector<double>& coordinates) {
  const bool is_finite = std::all_of(coordinates.begin(), coordinates.end(), [](double value) {
    return std::isfinite(value);
  });
  if (coordinates.size() % 9 != 0 || !is_finite) return std::nullopt;
  geometry::SignedDistance::Corners corners;
  corners.reserve(coordinates.size() / 3);
  for (std::size_t i = 0; i < coordinates.size(); i += 3)
    corners.emplace_back(coordinates[i], coordinates[i + 1], coordinates[i + 2]);
  return corners;
}

}  // namespace

std::string solidKey(const HandModel& model, const Skin& skin) {
  ContentHash hash;
  hash.add(kFormat);
  add(skin.mesh(), hash);
  hash.addNumbers(skin.faceLinks().data(), skin.faceLinks().size());
  hash.addNumber(skin.epsilon());
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  for (int link = 0; link < model.linkCount(); ++link) {
    hash.addNumbers(X_SL[static_cast<std::size_t>(link)].matrix().data(), 16);
    const geometry::TriangleMesh* surface = skin.links().surfaceOf(link);
    hash.addNumber<std::int64_t>(surface == nullptr ? 0 : 1);
    if (surface != nullptr) add(*surface, hash);
  }
  for (const HandModel::Node& node : model.nodes()) {
    hash.addNumber<std::int64_t>(node.parent_link);
    hash.addNumber<std::int64_t>(static_cast<std::int64_t>(node.type));
  }
  return hash.finish();
}

std::string serialise(const SolidFindings& findings, const std::string& key) {
  std::string bytes;
  const std::uint64_t count = findings.links.size();
  appendNumbers(bytes, &count, 1);
  for (const SolidFindings::OfLink& link : findings.links) {
    appendList(bytes, link.for_links);
    appendList(bytes, link.for_objects);
    appendList(bytes, coordinatesOf(link.outer_faces));
  }
  return sealed(kFormat, key, bytes);
}

std::optional<SolidFindings> deserialiseFindings(std::string_view bytes,
                                                 const std::string& key) {
  const auto content = unsealed(bytes, kFormat, key);
  if (!content) return std::nullopt;
  std::string_view rest = *content;
  std::uint64_t count = 0;
  if (!takeNumbers(rest, &count, 1) || count > rest.size()) return std::nullopt;
  SolidFindings findings;
  for (std::uint64_t i = 0; i < count; ++i) {
    SolidFindings::OfLink& link = findings.links.emplace_back();
    std::vector<double> coordinates;
    if (!takeList(rest, link.for_links) || !takeList(rest, link.for_objects) ||
        !takeList(rest, coordinates))
      return std::nullopt;
    auto corners = cornersOf(coordinates);
    if (!corners) return std::nullopt;
    link.outer_faces = std::move(*corners);
  }
  if (!rest.empty()) return std::nullopt;
  return findings;
}

std::shared_ptr<const HandSolid> keptSolid(const HandModel& model,
                                           const Skin& skin,
                                           const Progress& progress) {
  if (skin.keptIn() == nullptr) {
    return std::make_shared<const HandSolid>(model, skin, progress);
  }
  const std::string key = solidKey(model, skin);
  const std::string name = key + ".solid";
  auto known = skin.keptIn()->find(name, [&](std::string_view bytes) {
    return deserialiseFindings(bytes, key);
  });
  const bool is_known = known.has_value();
  SolidFindings findings = is_known ? std::move(*known) : SolidFindings();
  auto solid =
      std::make_shared<const HandSolid>(model, skin, progress, HandSolidOptions(), &findings);
  if (!is_known && skin.keptIn()->folder()) {
    skin.keptIn()->keep(name, serialise(findings, key));
  }
  return solid;
}

}  // namespace handgraft::hand
