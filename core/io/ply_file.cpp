#include "core/io/ply_file.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

namespace {

enum class Encoding { kAscii, kLittleEndian, kBigEndian };
enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat64;
  std::optional<Scalar> count_type;  ///< set for a list
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Encoding encoding = Encoding::kAscii;
  std::vector<Element> elements;
  std::vector<std::string> comments;
  std::size_t size = 0;  ///< bytes up to and including the line `end_header`
};

constexpr std::size_t sizeOf(Scalar type) {
  switch (type) {
    case Scalar::kInt8:
    case Scalar::kUint8:
      return 1;
    case Scalar::kInt16:
    case Scalar::kUint16:
      return 2;
    case Scalar::kInt32:
    case Scalar::kUint32:
    case Scalar::kFloat32:
      return 4;
    case Scalar::kFloat64:
      return 8;
  }
  return 8;
}

std::optional<Scalar> scalarFrom(std::string_view name) {
  constexpr std::pair<std::string_view, Scalar> kNames[] = {
      {"char", Scalar::kInt8},      {"int8", Scalar::kInt8},       {"uchar", Scalar::kUint8},
      {"uint8", Scalar::kUint8},    {"short", Scalar::kInt16},     {"int16", Scalar::kInt16},
      {"ushort", Scalar::kUint16},  {"uint16", Scalar::kUint16},   {"int", Scalar::kInt32},
      {"int32", Scalar::kInt32},    {"uint", Scalar::kUint32},     {"uint32", Scalar::kUint32},
      {"float", Scalar::kFloat32},  {"float32", Scalar::kFloat32}, {"double", Scalar::kFloat64},
      {"float64", Scalar::kFloat64}};
  for (const auto& [known, type] : kNames) {
    if (name == known) return type;
  }
  return std::nullopt;
}

// === Header

class HeaderReader {
 public:
  HeaderReader(std::string_view bytes, std::string file)
      : bytes_(bytes), file_(std::move(file)) {}

  Header read() {
    if (nextLine() != "ply")
      rejectInput("{}: not a PLY file, its first line must be 'ply'", file_);
    bool has_format = false;
    while (true) {
      const std::string line = nextLine();
      std::istringstream words(line);
      std::string keyword;
      words >> keyword;
      if (keyword == "end_header") break;
      if (keyword == "format") {
        readFormat(words, line);
        has_format = true;
      } else if (keyword == "comment" || keyword == "obj_info") {
        const std::size_t start =
            line.find_first_not_of(" \t", line.find(keyword) + keyword.size());
        header_.comments.push_back(start == std::string::npos ? "" : line.substr(start));
      } else if (keyword == "element") {
        readElement(words, line);
      } else if (keyword == "property") {
        readProperty(words, line);
      } else if (!keyword.empty()) {
        reject(line);
      }
    }
    if (!has_format) rejectInput("{}: PLY header has no line 'format'", file_);
    header_.size = cursor_;
    return std::move(header_);
  }

 private:
  [[noreturn]] void reject(const std::string& line) const {
    rejectInput("{}: PLY header line {} is not understood", file_, handgraft::quoted(line));
  }

  std::string nextLine() {
    const std::size_t end = bytes_.find('\n', cursor_);
    if (end == std::string_view::npos) {
      rejectInput("{}: PLY header is truncated, it must end with 'end_header'", file_);
    }
    std::string line(bytes_.substr(cursor_, end - cursor_));
    cursor_ = end + 1;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return line;
  }

  void readFormat(std::istringstream& words, const std::string& line) {
    std::string format;
    words >> format;
    if (format == "ascii") {
      header_.encoding = Encoding::kAscii;
    } else if (format == "binary_little_endian") {
      header_.encoding = Encoding::kLittleEndian;
    } else if (format == "binary_big_endian") {
      header_.encoding = Encoding::kBigEndian;
    } else {
      reject(line);
    }
  }

  void readElement(std::istringstream& words, const std::string& line) {
    Element element;
    if (!(words >> element.name >> element.count) || element.count < 0) reject(line);
    header_.elements.push_back(std::move(element));
  }

  void readProperty(std::istringstream& words, const std::string& line) {
    if (header_.elements.empty()) reject(line);
    Property property;
    std::string type;
    words >> type;
    if (type == "list") {
      std::string count_type;
      words >> count_type >> type;
      property.count_type = scalarFrom(count_type);
      if (!property.count_type) reject(line);
    }
    const std::optional<Scalar> scalar = scalarFrom(type);
    if (!scalar || !(words >> property.name)) reject(line);
    property.type = *scalar;
    header_.elements.back().properties.push_back(std::move(property));
  }

  std::string_view bytes_;
  std::string file_;
  Header header_;
  std::size_t cursor_ = 0;
};

// === Body

class BodyReader {
 public:
  BodyReader(std::string_view bytes, const Header& header, std::string file)
      : bytes_(bytes),
        encoding_(header.encoding),
        file_(std::move(file)),
        cursor_(header.size) {}

  double read(Scalar type) {
    return encoding_ == Encoding::kAscii ? readWord() : readBinary(type);
  }

  std::int64_t readCount(Scalar type) {
    const double count = read(type);
    const double remaining = static_cast<double>(bytes_.size() - cursor_);
    if (!(count >= 0.0) || count > remaining) {
      rejectInput("{}: PLY list of length {} at byte {}, {} bytes are left", file_, count,
                  cursor_, bytes_.size() - cursor_);
    }
    return static_cast<std::int64_t>(count);
  }

  /// Believes a count of the header only if the bytes left can hold it.
  void requireRoom(const Element& element) const {
    // A list takes its count at least; an ascii value one character and a separator.
    std::size_t least = 0;
    for (const Property& p : element.properties) {
      least += encoding_ == Encoding::kAscii ? 2 : sizeOf(p.count_type.value_or(p.type));
    }
    const std::size_t left = bytes_.size() - cursor_ + 1;  // the last separator may be missing
    const auto count = static_cast<std::uint64_t>(element.count);
    if (count > static_cast<std::uint64_t>(kMostVertices) * 4 || count * least > left) {
      rejectInput(
          "{}: PLY header claims {} of element {}, the {} bytes that follow are too few "
          "(truncated?)",
          file_, count, handgraft::quoted(element.name), left - 1);
    }
  }

 private:
  double readWord() {
    while (cursor_ < bytes_.size() && isSpace(bytes_[cursor_]))
      ++cursor_;
    std::size_t end = cursor_;
    while (end < bytes_.size() && !isSpace(bytes_[end]))
      ++end;
    if (end == cursor_)
      rejectInput("{}: PLY is truncated after {} bytes", file_, bytes_.size());
    const std::string word(bytes_.substr(cursor_, end - cursor_));
    bool is_number = false;
    const double value = numberFrom(word, is_number);
    if (!is_number) {
      rejectInput("{}: PLY has {} at byte {}, where a number is needed", file_,
                  handgraft::quoted(word), cursor_);
    }
    cursor_ = end;
    return value;
  }

  static bool isSpace(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t' || c == '\v' || c == '\f';
  }

  template <class T>
  double take() {
    if (bytes_.size() - cursor_ < sizeof(T)) {
      rejectInput("{}: PLY is truncated after {} bytes", file_, bytes_.size());
    }
    unsigned char raw[sizeof(T)];
    std::memcpy(raw, bytes_.data() + cursor_, sizeof(T));
    cursor_ += sizeof(T);
    const bool swap =
        (encoding_ == Encoding::kBigEndian) == (std::endian::native == std::endian::little);
    if (swap) std::reverse(raw, raw + sizeof(T));
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  double readBinary(Scalar type) {
    switch (type) {
      case Scalar::kInt8:
        return take<std::int8_t>();
      case Scalar::kUint8:
        return take<std::uint8_t>();
      case Scalar::kInt16:
        return take<std::int16_t>();
      case Scalar::kUint16:
        return take<std::uint16_t>();
      case Scalar::kInt32:
        return take<std::int32_t>();
      case Scalar::kUint32:
        return take<std::uint32_t>();
      case Scalar::kFloat32:
        return take<float>();
      case Scalar::kFloat64:
        return take<double>();
    }
    return 0.0;
  }

  std::string_view bytes_;
  Encoding encoding_;
  std::string file_;
  std::size_t cursor_;
};

void readVertices(BodyReader& body, const Element& element, PlyFile& ply) {
  ply.vertex_count = static_cast<int>(element.count);
  std::vector<Eigen::VectorXd*> columns;
  for (const Property& property : element.properties) {
    Eigen::VectorXd* column = nullptr;
    if (!property.count_type) {
      column = &ply.vertex[property.name];
      column->resize(ply.vertex_count);
    }
    columns.push_back(column);
  }
  for (int v = 0; v < ply.vertex_count; ++v) {
    for (std::size_t p = 0; p < columns.size(); ++p) {
      const Property& property = element.properties[p];
      if (columns[p]) {
        (*columns[p])[v] = body.read(property.type);
        continue;
      }
      for (std::int64_t n = body.readCount(*property.count_type); n > 0; --n) {
        body.read(property.type);
      }
    }
  }
}

using FileFaces = std::vector<std::vector<double>>;

FileFaces readFaces(BodyReader& body, const Element& element) {
  FileFaces faces(static_cast<std::size_t>(element.count));
  for (std::vector<double>& face : faces) {
    for (const Property& property : element.properties) {
      if (!property.count_type) {
        body.read(property.type);
        continue;
      }
      const bool is_face = property.name == "vertex_indices" || property.name == "vertex_index";
      for (std::int64_t n = body.readCount(*property.count_type); n > 0; --n) {
        const double value = body.read(property.type);
        if (is_face) face.push_back(value);
      }
    }
  }
  return faces;
}

void skip(BodyReader& body, const Element& element) {
  for (std::int64_t i = 0; i < element.count; ++i) {
    for (const Property& property : element.properties) {
      std::int64_t n = property.count_type ? body.readCount(*property.count_type) : 1;
      for (; n > 0; --n)
        body.read(property.type);
    }
  }
}

void triangulate(const FileFaces& faces, const std::string& file, PlyFile& ply) {
  std::vector<int> corners;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (const double index : faces[f]) {
      if (!(index >= 0.0 && index < ply.vertex_count) || index != static_cast<int>(index)) {
        rejectInput("{}: face {} names vertex {}, the file has vertices 0 to {}", file, f,
                    index, ply.vertex_count - 1);
      }
    }
    for (std::size_t c = 2; c < faces[f].size(); ++c) {
      for (const std::size_t corner : {std::size_t{0}, c - 1, c}) {
        corners.push_back(static_cast<int>(faces[f][corner]));
      }
      ply.file_face.push_back(static_cast<int>(f));
    }
  }
  ply.faces = Eigen::Map<const Eigen::Matrix3Xi>(corners.data(), 3,
                                                 static_cast<Eigen::Index>(corners.size() / 3));
}

}  // namespace

PlyFile readPly(const std::filesystem::path& path) {
  const std::string bytes = readFileBytes(path);
  const std::string file = handgraft::quoted(path.string());
  Header header = HeaderReader(bytes, file).read();

  PlyFile ply;
  ply.comments = std::move(header.comments);
  BodyReader body(bytes, header, file);
  FileFaces faces;
  for (const Element& element : header.elements) {
    // Elements without properties take no bytes, whatever count they claim.
    if (element.properties.empty()) continue;
    body.requireRoom(element);
    if (element.name == "vertex" && ply.vertex.empty()) {
      if (element.count > kMostVertices) {
        rejectInput("{}: has {} vertices, at most {} are permitted", file, element.count,
                    kMostVertices);
      }
      readVertices(body, element, ply);
    } else if (element.name == "face" && faces.empty()) {
      faces = readFaces(body, element);
      for (const Property& property : element.properties)
        if (!property.count_type) ply.face_properties.push_back(property.name);
    } else {
      skip(body, element);
    }
  }
  triangulate(faces, file, ply);
  return ply;
}

void writePly(const std::filesystem::path& path, const geometry::TriangleMesh& mesh) {
  static_assert(std::endian::native == std::endian::little, "written as the machine holds it");
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << mesh.vertexCount()
      << "\nproperty double x\nproperty double y\nproperty double z\nelement face "
      << mesh.faceCount() << "\nproperty list uchar int vertex_indices\nend_header\n";
  out.write(reinterpret_cast<const char*>(mesh.vertices().data()),
            static_cast<std::streamsize>(sizeof(double)) * mesh.vertices().size());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    out.put(3);
    out.write(reinterpret_cast<const char*>(mesh.faces().col(f).data()), 3 * sizeof(int));
  }
  out.close();
  if (!out) rejectInput("{}: cannot be written", handgraft::quoted(path.string()));
}

}  // namespace handgraft::io
