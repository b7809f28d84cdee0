#include "core/io/posture_json.h"

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/json_keys.h"

namespace handgraft::io {

namespace {

using nlohmann::json;

std::string partNameIn(const json& entry) {
  constexpr std::size_t kLongestPart = 256;  // bytes
  const json& value = formats::memberOf(entry, "part");
  if (!value.is_string())
    rejectInput("field 'part' is {}; it must be a text", formats::shown(value));
  std::string name = value.get<std::string>();
  if (name.size() > kLongestPart)
    rejectInput("field 'part' has {} bytes; permitted are {}", name.size(), kLongestPart);
  return name;
}

Eigen::Vector3d directionIn(const json& entry, const char* name) {
  const json& value = formats::memberOf(entry, name);
  if (!value.is_array() || value.size() != 3)
    rejectInput("field '{}' must be an array of 3 numbers", name);
  Eigen::Vector3d direction;
  for (int i = 0; i < 3; ++i)
    direction[i] = formats::finiteFrom(value[static_cast<std::size_t>(i)], name);
  if (!(direction.norm() > 0.0)) rejectInput("field '{}' has no length", name);
  return direction.normalized();
}

}  // namespace

std::vector<contact::PartDirection> postureFrom(const json& value) {
  if (!value.is_array()) rejectInput("field 'posture' is no array");
  if (value.size() > contact::kMostParts)
    rejectInput("field 'posture' has {} entries; permitted are {}", value.size(),
                contact::kMostParts);
  std::vector<contact::PartDirection> posture;
  for (const json& entry : value) {
    if (!entry.is_object()) rejectInput("field 'posture': an entry is no object");
    if (const auto fault = formats::unknownKeyIn(entry, {"part", "outward", "palmar"}))
      rejectInput("{}", *fault);
    contact::PartDirection part;
    part.part = partNameIn(entry);
    part.outward_O = directionIn(entry, "outward");
    if (entry.contains("palmar")) part.palmar_O = directionIn(entry, "palmar");
    posture.push_back(std::move(part));
  }
  return posture;
}

json postureJson(const std::vector<contact::PartDirection>& posture) {
  json list = json::array();
  for (const contact::PartDirection& part : posture) {
    const Eigen::Vector3d& out = part.outward_O;
    const Eigen::Vector3d& in = part.palmar_O;
    json entry = {{"part", part.part}, {"outward", {out.x(), out.y(), out.z()}}};
    if (!in.isZero()) entry["palmar"] = {in.x(), in.y(), in.z()};
    list.push_back(std::move(entry));
  }
  return list;
}

}  // namespace handgraft::io
