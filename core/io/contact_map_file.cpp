#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/ply_file.h"

namespace handgraft::io {
namespace {

using contact::ContactMap;

constexpr int kMostSegments = 10'000;

/// Names from comments that list `0=name 1=name`; what is no such pair is prose.
std::vector<std::string> segmentNamesIn(const std::vector<std::string>& comments) {
  std::vector<std::string> names;
  for (const std::string& comment : comments) {
    std::istringstream words(comment);
    for (std::string word; words >> word;) {
      const std::size_t sign = word.find('=');
      if (sign == 0 || sign == std::string::npos || sign > 5 || sign + 1 == word.size())
        continue;
      const std::string number = word.substr(0, sign);
      if (number.find_first_not_of("0123456789") != std::string::npos) continue;
      const std::size_t index = std::stoul(number);
      if (index >= kMostSegments) continue;
      if (index >= names.size()) names.resize(index + 1);
      names[index] = word.substr(sign + 1);
      while (!names[index].empty() &&
             (names[index].back() == ',' || names[index].back() == ';')) {
        names[index].pop_back();
      }
    }
  }
  return names;
}

/// Labels as the file has them; names are appended where it uses more than it names.
std::vector<int> labelsOf(const Eigen::VectorXd& column) {
  std::vector<int> labels(static_cast<std::size_t>(column.size()));
  for (Eigen::Index v = 0; v < column.size(); ++v) {
    const double label = column[v];
    if (!(label >= -1.0 && label < kMostSegments) || label != std::floor(label)) {
      rejectInput(
          "property 'link' of vertex {} is {}; permitted are whole numbers from -1 to {}", v,
          label, kMostSegments - 1);
    }
    labels[v] = static_cast<int>(label);
  }
  return labels;
}

ContactMap contactMapFrom(const PlyFile& ply) {
  for (const char* property : {"x", "y", "z", "contact"}) {
    if (ply.vertex.count(property) == 0) {
      rejectInput("no vertex property '{}', which a contact map needs", property);
    }
  }
  Eigen::Matrix3Xd vertices(3, ply.vertex_count);
  vertices.row(0) = ply.vertex.at("x").transpose();
  vertices.row(1) = ply.vertex.at("y").transpose();
  vertices.row(2) = ply.vertex.at("z").transpose();

  ContactMap map;
  map.mesh_O = geometry::TriangleMesh(std::move(vertices), ply.faces);
  map.value = ply.vertex.at("contact");
  if (const auto link = ply.vertex.find("link"); link != ply.vertex.end()) {
    map.label = labelsOf(link->second);
    map.segment_names = segmentNamesIn(ply.comments);
    const int most =
        map.label.empty() ? -1 : *std::max_element(map.label.begin(), map.label.end());
    if (!map.segment_names.empty() && most >= std::ssize(map.segment_names)) {
      map.segment_names.resize(static_cast<std::size_t>(most) + 1);
    }
  }
  validate(map);
  return map;
}

}  // namespace

ContactMap readContactMap(const std::filesystem::path& path) {
  const PlyFile ply = readPly(path);
  try {
    return contactMapFrom(ply);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", path.string(), error.what());
  }
}

}  // namespace handgraft::io
