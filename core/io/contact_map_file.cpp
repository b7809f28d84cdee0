#include "core/io/contact_map_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/io/color_map.h"
#include "core/io/file_bytes.h"
#include "core/io/ply_file.h"
#include "core/io/texture_map.h"

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
std::vector<int> labelsOf(const Eigen::VectorXd& column, const std::string& property) {
  std::vector<int> labels(static_cast<std::size_t>(column.size()));
  for (Eigen::Index v = 0; v < column.size(); ++v) {
    const double label = column[v];
    if (!(label >= -1.0 && label < kMostSegments) || label != std::floor(label)) {
      rejectInput("property '{}' of vertex {} is {}; permitted are whole numbers from -1 to {}",
                  property, v, label, kMostSegments - 1);
    }
    labels[v] = static_cast<int>(label);
  }
  return labels;
}

const Eigen::VectorXd& columnOf(const PlyFile& ply, const std::string& property) {
  const auto column = ply.vertex.find(property);
  if (column == ply.vertex.end())
    rejectInput("no vertex property {}, which this contact map needs", quoted(property));
  return column->second;
}

/// In [0, 1].
Eigen::Matrix3Xd colorsOf(const PlyFile& ply) {
  Eigen::Matrix3Xd rgb(3, ply.vertex_count);
  rgb.row(0) = columnOf(ply, "red").transpose();
  rgb.row(1) = columnOf(ply, "green").transpose();
  rgb.row(2) = columnOf(ply, "blue").transpose();
  const double most = rgb.size() > 0 ? rgb.maxCoeff() : 0.0;
  if (!rgb.allFinite() || !(most <= 255.0) || (rgb.size() > 0 && rgb.minCoeff() < 0.0))
    rejectInput("a vertex has a colour outside 0 to 255");
  if (most > 1.0) rgb /= 255.0;  // else fractions; bytes of a map that is black all over, too
  return rgb;
}

bool hasColors(const PlyFile& ply) {
  return ply.vertex_count > 0 && ply.vertex.count("red") != 0 &&
         ply.vertex.count("green") != 0 && ply.vertex.count("blue") != 0;
}

/// The values themselves; where there are none but colours, says which.
Eigen::VectorXd valuesByProperty(const PlyFile& ply, const std::string& property) {
  if (ply.vertex.count(property) == 0 && hasColors(ply)) {
    rejectInput(
        "no vertex property {}, which this contact map needs; its vertices have colours: {}; "
        "name the scale that they show values by, one of {}",
        quoted(property), describeColors(colorsOf(ply)), fmt::join(colorMapNames(), ", "));
  }
  return columnOf(ply, property);
}

ContactMap contactMapFrom(const PlyFile& ply, const ContactMapSource& source) {
  Eigen::Matrix3Xd vertices(3, ply.vertex_count);
  vertices.row(0) = columnOf(ply, "x").transpose();
  vertices.row(1) = columnOf(ply, "y").transpose();
  vertices.row(2) = columnOf(ply, "z").transpose();

  ContactMap map;
  map.value = source.color_scale.empty()
                  ? valuesByProperty(ply, source.value_property)
                  : valuesOfColors(colorMap(source.color_scale), colorsOf(ply)).value;
  map.mesh_O = geometry::TriangleMesh(std::move(vertices), ply.faces);
  const bool must_have_labels = source.label_property != ContactMapSource().label_property;
  if (must_have_labels || ply.vertex.count(source.label_property) != 0) {
    map.label = labelsOf(columnOf(ply, source.label_property), source.label_property);
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

bool isContactMap(const std::filesystem::path& path, const ContactMapSource& source) {
  if (!source.picture.empty()) return true;
  if (endingOf(path) == ".ply") return true;
  std::ifstream file(path, std::ios::binary);
  char start[3] = {};
  return file.read(start, 3) && std::string(start, 3) == "ply";
}

ContactMap readContactMap(const std::filesystem::path& path, const ContactMapSource& source) {
  if (!source.picture.empty()) {
    if (source.color_scale.empty()) {
      rejectInput("{}: a picture needs a colour scale, one of {}",
                  quoted(source.picture.string()), fmt::join(colorMapNames(), ", "));
    }
    return readTextureMap(path, source.picture, colorMap(source.color_scale));
  }
  const PlyFile ply = readPly(path);
  try {
    return contactMapFrom(ply, source);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", path.string(), error.what());
  }
}

}  // namespace handgraft::io
