#include "core/io/sites_file.h"

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <yaml-cpp/yaml.h>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

// A site takes 150 bytes; a node of yaml-cpp's several hundred, for as little as two of the
// file.
constexpr std::uintmax_t kLargestFile = 128 << 10;
constexpr std::size_t kLongestText = 256;
constexpr const char* kFormat = "handgraft-sites/1";

/// Of a code point in UTF-8, by its first byte; 0 for one that begins none.
std::size_t utf8Length(unsigned char first) {
  if (first < 0x80) return 1;
  if (first < 0xc2) return 0;
  if (first < 0xe0) return 2;
  if (first < 0xf0) return 3;
  return first < 0xf5 ? 4 : 0;
}

/// Whether Unicode has that code point, and writes it in so many bytes.
bool isCodePoint(unsigned code, std::size_t length) {
  const bool is_longer_than_needed =
      (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool is_surrogate = code >= 0xd800 && code <= 0xdfff;
  return !is_longer_than_needed && !is_surrogate && code <= 0x10ffff;
}

/// Other bytes would not be written as they were read.
bool isUtf8(const std::string& text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const auto first = static_cast<unsigned char>(text[at]);
    const std::size_t length = utf8Length(first);
    if (length == 0 || at + length > text.size()) return false;
    unsigned code = length == 1 ? first : first & (0x7fU >> length);
    for (std::size_t i = 1; i < length; ++i) {
      const auto next = static_cast<unsigned char>(text[at + i]);
      if ((next & 0xc0U) != 0x80U) return false;
      code = code << 6U | (next & 0x3fU);
    }
    if (!isCodePoint(code, length)) return false;
    at += length;
  }
  return true;
}

std::string textOf(const YAML::Node& site, const char* field, const std::string& owner) {
  const YAML::Node node = site[field];
  if (!node || !node.IsScalar() || node.Scalar().empty())
    rejectInput("{}: '{}' is missing or no text", owner, field);
  if (node.Scalar().size() > kLongestText || !isUtf8(node.Scalar()))
    rejectInput("{}: '{}' is {}; it must be UTF-8 of at most {} bytes", owner, field,
                handgraft::quoted(node.Scalar()), kLongestText);
  return node.Scalar();
}

Eigen::Vector3d vectorOf(const YAML::Node& site, const char* field, const std::string& owner) {
  const YAML::Node node = site[field];
  if (!node || !node.IsSequence() || node.size() != 3)
    rejectInput("{}: '{}' must be three numbers", owner, field);
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) {
    if (!YAML::convert<double>::decode(node[i], v[i]) || !std::isfinite(v[i]))
      rejectInput("{}: '{}' must be three finite numbers", owner, field);
  }
  return v;
}

Eigen::Vector3d directionOf(const YAML::Node& site,
                            const char* field,
                            const std::string& owner) {
  const Eigen::Vector3d v = vectorOf(site, field, owner);
  const double length = v.stableNorm();
  if (!(length > 1e-9) || !std::isfinite(length))
    rejectInput("{}: '{}' ({} {} {}) has no direction", owner, field, v.x(), v.y(), v.z());
  return v / length;
}

hand::ContactSite siteOf(const YAML::Node& node, std::size_t number) {
  std::string owner = fmt::format("site {}", number);
  if (!node.IsMap()) rejectInput("{}: a site is a map of name, link, point_m, ...", owner);
  static const std::set<std::string> known_fields{"name", "link", "point_m", "normal",
                                                  "direction"};
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || !known_fields.contains(entry.first.Scalar()))
      rejectInput("{}: unknown field {} (name, link, point_m, normal, direction)", owner,
                  handgraft::quoted(entry.first.IsScalar() ? entry.first.Scalar() : "?"));
  }

  hand::ContactSite site;
  site.name = textOf(node, "name", owner);
  owner = "site " + handgraft::quoted(site.name);
  site.link = textOf(node, "link", owner);
  site.p_L = vectorOf(node, "point_m", owner);
  site.n_L = directionOf(node, "normal", owner);
  // Files give a few digits: what remains along the normal is taken away.
  const Eigen::Vector3d d = directionOf(node, "direction", owner);
  const Eigen::Vector3d tangent = d - d.dot(site.n_L) * site.n_L;
  if (tangent.norm() < 0.1)
    rejectInput("{}: 'direction' must not be parallel to 'normal'", owner);
  site.direction_L = tangent.normalized();
  return site;
}

/// Whether the file speaks of a mirrored hand.
bool isMirrored(const YAML::Node& root) {
  const YAML::Node node = root["mirrored"];
  bool mirrored = false;
  if (node && !YAML::convert<bool>::decode(node, mirrored))
    rejectInput("'mirrored' must be true or false");
  return mirrored;
}

void mirror(hand::ContactSite& site) {
  site.p_L.x() = -site.p_L.x();
  site.n_L.x() = -site.n_L.x();
  site.direction_L.x() = -site.direction_L.x();
}

std::vector<hand::ContactSite> parseSites(const std::string& text,
                                          const hand::HandModel& model,
                                          bool mirrored) {
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& error) {
    rejectInput("line {}: {}", error.mark.line + 1, handgraft::quoted(error.msg));
  }
  if (!root.IsMap() || !root["format"] || !root["format"].IsScalar() ||
      root["format"].Scalar() != kFormat)
    rejectInput("'format' must be {}", kFormat);
  const YAML::Node list = root["sites"];
  if (!list || !list.IsSequence()) rejectInput("'sites' must be a list");

  std::vector<hand::ContactSite> sites;
  sites.reserve(list.size());
  for (std::size_t i = 0; i < list.size(); ++i)
    sites.push_back(siteOf(list[i], i));
  if (isMirrored(root) != mirrored) {
    for (hand::ContactSite& site : sites)
      mirror(site);
  }
  hand::validate(model, sites);
  return sites;
}

}  // namespace

std::vector<hand::ContactSite> readSites(const std::filesystem::path& path,
                                         const hand::HandModel& model,
                                         bool mirrored) {
  const std::string name = handgraft::quoted(path.string());
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) rejectInput("{}: {}", name, error.message());
  if (size > kLargestFile)
    rejectInput("{}: {} bytes, more than the {} of a sites file", name, size, kLargestFile);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) rejectInput("{}: cannot be read", name);
  try {
    return parseSites(text.str(), model, mirrored);
  } catch (const InvalidInput& fault) {
    rejectInput("{}: {}", name, fault.what());
  } catch (const YAML::Exception& fault) {
    rejectInput("{}: {}", name, handgraft::quoted(fault.what()));
  }
}

std::string sitesText(const std::vector<hand::ContactSite>& sites, bool mirrored) {
  YAML::Emitter out;
  out.SetDoublePrecision(9);
  const auto vector = [&](const char* field, const Eigen::Vector3d& v) {
    out << YAML::Key << field << YAML::Value << YAML::Flow << YAML::BeginSeq;
    for (const double number : v)
      out << number;
    out << YAML::EndSeq;
  };
  out << YAML::Comment(
      "Where contacts belong on this hand when nobody says otherwise. Edit freely: a name is\n"
      "what a contact set calls its patch; point_m (m), normal (outwards) and direction "
      "(along\n"
      "the surface, towards the wrist) are in the link's frame.");
  out << YAML::BeginMap << YAML::Key << "format" << YAML::Value << kFormat;
  if (mirrored) out << YAML::Key << "mirrored" << YAML::Value << true;
  out << YAML::Key << "sites" << YAML::Value << YAML::BeginSeq;
  for (const hand::ContactSite& site : sites) {
    out << YAML::BeginMap;
    // Quoted, so that a link named `12` or `no` stays a text.
    out << YAML::Key << "name" << YAML::Value << YAML::DoubleQuoted << site.name;
    out << YAML::Key << "link" << YAML::Value << YAML::DoubleQuoted << site.link;
    vector("point_m", site.p_L);
    vector("normal", site.n_L);
    vector("direction", site.direction_L);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq << YAML::EndMap;
  HANDGRAFT_REQUIRE(out.good());
  return std::string(out.c_str()) + "\n";
}

void writeSites(const std::filesystem::path& path,
                const std::vector<hand::ContactSite>& sites) {
  std::ofstream file(path, std::ios::binary);
  file << sitesText(sites);
  file.close();
  if (!file) rejectInput("{}: cannot be written", handgraft::quoted(path.string()));
}

}  // namespace handgraft::io
