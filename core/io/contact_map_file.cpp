#include "core/io/contact_map_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "core/base/error.h"
#include "core/io/color_map.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/ply_file.h"
#include "core/io/texture_map.h"

namespace handgraft::io {
namespace {

using contact::ContactMap;

constexpr int kMostSegments = 10'000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

std::vector<std::string> namesOf(const std::map<std::string, Eigen::VectorXd>& columns) {
  std::vector<std::string> names;
  for (const auto& [name, values] : columns)
    names.push_back(name);
  return names;
}

const Eigen::VectorXd& columnOf(const PlyFile& ply, const std::string& property) {
  const auto column = ply.vertex.find(property);
  if (column == ply.vertex.end()) {
    if (ply.face_properties.empty()) {
      rejectInput("no vertex property {}, which this contact map needs; it has {}",
                  quoted(property), fmt::join(namesOf(ply.vertex), ", "));
    }
    rejectInput(
        "no vertex property {}, which this contact map needs; "
        "its faces have {}, and what faces say is not read: "
        "give it to their vertices, contact from 0 to 1 and link for the finger",
        quoted(property), fmt::join(ply.face_properties, ", "));
  }
  return column->second;
}

void requireColors(const Eigen::Matrix3Xd& rgb) {
  const auto lacks_color = rgb.array().isNaN().colwise().any().eval();
  for (Eigen::Index v = 0; v < rgb.cols(); ++v) {
    if (lacks_color[v]) {
      rejectInput(
          "vertex {} (the first is 0) has no colour, {} of {} vertices have one; "
          "permitted are red, green and blue at every vertex, all of 0 to 255 or all of 0 to 1",
          v, rgb.cols() - lacks_color.count(), rgb.cols());
    }
    if (rgb.col(v).minCoeff() < 0.0 || rgb.col(v).maxCoeff() > 255.0) {
      rejectInput("vertex {} (the first is 0) has the colour {}; permitted are 0 to 255", v,
                  fmt::join(rgb.col(v), " "));
    }
  }
}

/// In [0, 1].
Eigen::Matrix3Xd colorsOf(const PlyFile& ply) {
  Eigen::Matrix3Xd rgb(3, ply.vertex_count);
  rgb.row(0) = columnOf(ply, "red").transpose();
  rgb.row(1) = columnOf(ply, "green").transpose();
  rgb.row(2) = columnOf(ply, "blue").transpose();
  requireColors(rgb);
  // Else fractions; bytes of a map that is black all over, too.
  if (rgb.size() > 0 && rgb.maxCoeff() > 1.0) rgb /= 255.0;
  return rgb;
}

/// What to write instead, where so few colours are there that they may stand for fingers.
std::string hintOfFingers(const Eigen::Matrix3Xd& rgb) {
  constexpr std::size_t kFewest = 3;  // nothing, and two fingers
  constexpr std::size_t kMost = 12;
  std::set<std::array<long, 3>> colors;
  for (const auto& color : rgb.colwise()) {
    const Eigen::Vector3d bytes = 255.0 * color;
    colors.insert({std::lround(bytes[0]), std::lround(bytes[1]), std::lround(bytes[2])});
    if (colors.size() > kMost) return "";
  }
  if (colors.size() < kFewest) return "";
  return fmt::format(
      "; {} colours are all there are: one for each finger is not read; "
      "write contact (0 or 1) and link at each vertex, the number of the finger (-1: none), "
      "and a header comment '0=thumb 1=index ...'",
      colors.size());
}

Eigen::VectorXd valuesByColor(const PlyFile& ply, const std::string& scale) {
  const Eigen::Matrix3Xd rgb = colorsOf(ply);
  try {
    return valuesOfColors(colorMap(scale), rgb).value;
  } catch (const InvalidInput& error) {
    rejectInput("{}{}", error.what(), hintOfFingers(rgb));
  }
}

bool hasColors(const PlyFile& ply) {
  return ply.vertex_count > 0 && ply.vertex.count("red") != 0 &&
         ply.vertex.count("green") != 0 && ply.vertex.count("blue") != 0;
}

/// The values themselves; where there are none but colours, says which.
Eigen::VectorXd valuesByProperty(const PlyFile& ply, const std::string& property) {
  if (ply.vertex.count(property) == 0 && hasColors(ply)) {
    rejectInput(
        "no vertex property {}, which this contact map needs; "
        "its vertices have colours: {}; name the scale that they show values by, one of {}{}",
        quoted(property), describeColors(colorsOf(ply)), fmt::join(colorMapNames(), ", "),
        hintOfFingers(colorsOf(ply)));
  }
  return columnOf(ply, property);
}

/// Vertices at the same place, as seams of texture coordinates and unwelded exports have them,
/// become one of their mean value, labelled as the one of the largest: patches go over seams.
ContactMap welded(ContactMap map, const std::vector<int>& file_face) {
  if (map.mesh_O.faceCount() == 0) return map;
  FileMesh listed;
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v)
    listed.vertices.emplace_back(map.mesh_O.vertex(v));
  for (int f = 0; f < map.mesh_O.faceCount(); ++f) {
    const Eigen::Vector3i face = map.mesh_O.face(f);
    listed.triangles.push_back({face[0], face[1], face[2]});
  }
  listed.file_face = file_face;
  const MeshFile file = weldedMesh(listed);
  const Eigen::Index count = file.mesh.vertexCount();
  if (count == map.value.size() && file.mesh.faceCount() == map.mesh_O.faceCount()) return map;
  ContactMap one;
  one.mesh_O = file.mesh;
  one.segment_names = std::move(map.segment_names);
  one.value = Eigen::VectorXd::Zero(count);
  Eigen::VectorXd copies = Eigen::VectorXd::Zero(count);
  Eigen::VectorXd largest = Eigen::VectorXd::Constant(count, -kInfinity);
  if (!map.label.empty()) one.label.assign(static_cast<std::size_t>(count), -1);
  for (std::size_t v = 0; v < file.mesh_vertex.size(); ++v) {
    const int place = file.mesh_vertex[v];
    if (place < 0) continue;
    const double value = map.value[static_cast<Eigen::Index>(v)];
    one.value[place] += value;
    copies[place] += 1.0;
    if (value <= largest[place]) continue;
    largest[place] = value;
    if (!map.label.empty()) one.label[static_cast<std::size_t>(place)] = map.label[v];
  }
  one.value.array() /= copies.array();
  return one;
}

ContactMap contactMapFrom(const PlyFile& ply, const ContactMapSource& source) {
  Eigen::Matrix3Xd vertices(3, ply.vertex_count);
  vertices.row(0) = columnOf(ply, "x").transpose();
  vertices.row(1) = columnOf(ply, "y").transpose();
  vertices.row(2) = columnOf(ply, "z").transpose();

  ContactMap map;
  map.value = source.color_scale.empty() ? valuesByProperty(ply, source.value_property)
                                         : valuesByColor(ply, source.color_scale);
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
  return welded(std::move(map), ply.file_face);
}

/// Whether a vertex of an OBJ has three numbers behind its place.
bool hasColoredVertices(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string keyword;
    if (!(words >> keyword) || keyword != "v") continue;
    double number = 0.0;
    int count = 0;
    while (words >> number)
      ++count;
    if (count == 6) return true;
  }
  return false;
}

/// An OBJ with colours at its vertices as a PLY that has the same.
PlyFile coloredObj(const std::filesystem::path& path) {
  const FileMesh mesh = readObj(path);
  PlyFile ply;
  ply.vertex_count = static_cast<int>(mesh.vertices.size());
  ply.file_face = mesh.file_face;
  ply.faces.resize(3, static_cast<Eigen::Index>(mesh.triangles.size()));
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f)
    ply.faces.col(static_cast<Eigen::Index>(f)) =
        Eigen::Map<const Eigen::Vector3i>(mesh.triangles[f].data());
  const auto column = [&](const std::vector<Eigen::Vector3d>& rows, int axis) {
    Eigen::VectorXd values(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t v = 0; v < rows.size(); ++v)
      values[static_cast<Eigen::Index>(v)] = rows[v][axis];
    return values;
  };
  constexpr std::array<std::array<const char*, 2>, 3> kNames{
      {{"x", "red"}, {"y", "green"}, {"z", "blue"}}};
  for (int axis = 0; axis < 3; ++axis) {
    ply.vertex[kNames[axis][0]] = column(mesh.vertices, axis);
    if (!mesh.rgb.empty()) ply.vertex[kNames[axis][1]] = column(mesh.rgb, axis);
  }
  return ply;
}

}  // namespace

bool isContactMap(const std::filesystem::path& path, const ContactMapSource& source) {
  if (!source.picture.empty()) return true;
  if (endingOf(path) == ".ply") return true;
  if (endingOf(path) == ".obj") return hasColoredVertices(path);
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
  const PlyFile ply = endingOf(path) == ".obj" ? coloredObj(path) : readPly(path);
  try {
    return contactMapFrom(ply, source);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", path.string(), error.what());
  }
}

}  // namespace handgraft::io
