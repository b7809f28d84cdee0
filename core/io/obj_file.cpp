#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

namespace {

/// Words of one line, which ends at a newline not preceded by a backslash.
class LineReader {
 public:
  explicit LineReader(std::string_view bytes) : bytes_(bytes) {}

  [[nodiscard]] bool endsWithNewline() const { return bytes_.ends_with('\n'); }

  bool nextLine() {
    while (cursor_ < bytes_.size() && !nextWord().empty())
      continue;
    if (cursor_ < bytes_.size()) ++cursor_;
    ++line_;
    return cursor_ < bytes_.size();
  }

  /// Empty at the end of the line.
  std::string_view nextWord() {
    while (cursor_ < bytes_.size()) {
      const char c = bytes_[cursor_];
      if (c == '\\') {
        const std::size_t next = cursor_ + 1;
        const bool carriage = next < bytes_.size() && bytes_[next] == '\r';
        const std::size_t end = carriage ? next + 1 : next;
        if (end < bytes_.size() && bytes_[end] == '\n') {
          cursor_ = end + 1;
          ++line_;
          continue;
        }
      }
      if (c != ' ' && c != '\t' && c != '\r') break;
      ++cursor_;
    }
    const std::size_t begin = cursor_;
    while (cursor_ < bytes_.size() && !isBlank(bytes_[cursor_]))
      ++cursor_;
    return bytes_.substr(begin, cursor_ - begin);
  }

  [[nodiscard]] int line() const { return line_; }

 private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

  std::string_view bytes_;
  std::size_t cursor_ = 0;
  int line_ = 1;
};

const Eigen::Vector3d no_color =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

class ObjReader {
 public:
  ObjReader(std::string_view bytes, std::string file) : lines_(bytes), file_(std::move(file)) {}

  FileMesh read() {
    do {
      const std::string_view keyword = lines_.nextWord();
      if (keyword == "v") {
        readVertex();
      } else if (keyword == "f") {
        readFace();
      }
    } while (lines_.nextLine());
    judgeEnd();
    if (!mesh_.rgb.empty()) mesh_.rgb.resize(mesh_.vertices.size(), no_color);
    return std::move(mesh_);
  }

 private:
  /// OBJ has no end mark; a file cut short among its faces shows in vertices left without one.
  void judgeEnd() {
    constexpr double kNotableShare = 0.1;
    std::vector<bool> used(mesh_.vertices.size(), false);
    for (const std::array<int, 3>& triangle : mesh_.triangles)
      for (const int v : triangle)
        used[v] = true;
    const auto unused = std::count(used.begin(), used.end(), false);
    if (mesh_.triangles.empty() && !used.empty()) {
      rejectInput(
          "{}: {} vertices and no face: is the file cut short? Point clouds are read from PLY "
          "files",
          file_, used.size());
    }
    if (unused > 0 && !lines_.endsWithNewline()) {
      rejectInput(
          "{}: ends in the middle: {} of {} vertices have no face; is the file cut short?",
          file_, unused, used.size());
    }
    if (static_cast<double>(unused) > kNotableShare * static_cast<double>(used.size())) {
      mesh_.notes.push_back(fmt::format(
          "{} of {} vertices have no face; is the file cut short?", unused, used.size()));
    }
  }

  void readVertex() {
    Eigen::Vector3d p;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = lines_.nextWord();
      bool is_number = false;
      p[axis] = numberFrom(word, is_number);
      if (!is_number) {
        rejectInput("{}: line {}: vertex {} has {} where a coordinate is needed (truncated?)",
                    file_, lines_.line(), mesh_.vertices.size(), quoted(std::string(word)));
      }
    }
    if (mesh_.vertices.size() >= static_cast<std::size_t>(kMostVertices)) {
      rejectInput("{}: has more than {} vertices", file_, kMostVertices);
    }
    mesh_.vertices.push_back(p);
    readColor();
  }

  /// `v x y z r g b`, as MeshLab and others write vertices' colours. One number more is a
  /// weight.
  void readColor() {
    Eigen::Vector3d rgb;
    for (double& channel : rgb) {
      bool is_number = false;
      channel = numberFrom(lines_.nextWord(), is_number);
      if (!is_number) return;
    }
    mesh_.rgb.resize(mesh_.vertices.size(), no_color);
    mesh_.rgb.back() = rgb;
  }

  /// Faces may name any vertex listed so far: 1 is the first of the file, -1 the newest.
  int readCorner(std::string_view word) {
    const std::string_view digits = word.substr(0, word.find('/'));
    long long index = 0;
    const auto [stop, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), index);
    const auto count = static_cast<long long>(mesh_.vertices.size());
    if (error == std::errc::invalid_argument || stop != digits.data() + digits.size()) {
      rejectInput("{}: line {}: face {} has {} where a vertex is needed", file_, lines_.line(),
                  face_count_, quoted(std::string(word)));
    }
    const long long v = index > 0 ? index - 1 : count + index;
    if (error != std::errc() || index == 0 || v < 0 || v >= count) {
      rejectInput(
          "{}: line {}: face {} names vertex {}, permitted here are 1 to {} and -1 to -{}",
          file_, lines_.line(), face_count_, quoted(std::string(digits)), count, count);
    }
    return static_cast<int>(v);
  }

  void readFace() {
    std::vector<int> corners;
    for (std::string_view word = lines_.nextWord(); !word.empty(); word = lines_.nextWord()) {
      if (word.front() == '#') break;
      corners.push_back(readCorner(word));
    }
    if (corners.size() < 3) {
      rejectInput("{}: line {}: face {} has {} vertices, it needs at least 3 (truncated?)",
                  file_, lines_.line(), face_count_, corners.size());
    }
    Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(corners.size()));
    for (std::size_t c = 0; c < corners.size(); ++c) {
      places.col(static_cast<Eigen::Index>(c)) = mesh_.vertices[corners[c]];
    }
    for (const std::array<int, 3>& t : cutPolygon(places)) {
      mesh_.triangles.push_back({corners[t[0]], corners[t[1]], corners[t[2]]});
      mesh_.file_face.push_back(face_count_);
    }
    ++face_count_;
  }

  LineReader lines_;
  std::string file_;
  FileMesh mesh_;
  int face_count_ = 0;
};

}  // namespace

FileMesh readObj(const std::filesystem::path& path) {
  return ObjReader(readFileBytes(path), handgraft::quoted(path.string())).read();
}

}  // namespace handgraft::io
