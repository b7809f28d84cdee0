#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/formats/zip_file.h"

namespace handgraft::formats {

/// NumPy arrays by name, as `numpy.load` reads them: a zip file whose members are NPY 1.0, not
/// compressed. The same arrays give the same bytes.
/// Source: numpy.lib.format; PKWARE's APPNOTE 6.3.
class NpzFile {
 public:
  /// Double precision, the last index fastest. Errors: BrokenContract unless the shape holds as
  /// many values.
  void add(const std::string& name,
           const std::vector<double>& values,
           const std::vector<std::size_t>& shape);
  /// A row of texts, UTF-8 in and Unicode in NumPy; bytes that are no UTF-8 become `?`.
  void add(const std::string& name, const std::vector<std::string>& texts);

  /// Errors: InvalidInput beyond 4 GiB, zip's own limit.
  [[nodiscard]] std::string bytes() const;

 private:
  void add(const std::string& name,
           const std::string& type,
           const std::vector<std::size_t>& shape,
           std::string_view values);

  std::vector<ZipMember> members_;
};

/// An array of a file: numbers in double precision, the last index fastest, whatever order they
/// were written in.
struct NpzArray {
  std::string type;  ///< as NumPy writes it: "<f8"
  std::vector<std::size_t> shape;
  std::vector<double> values;  ///< empty of what holds no numbers
  std::string text;            ///< of a single text
};

/// What `numpy.savez` or `numpy.savez_compressed` wrote, by name: arrays of numbers, single
/// texts, and of anything else the type alone. Errors: InvalidInput for what is no such file
/// (zip_file.h), breaks off, or holds more than 4 million numbers and two a byte of the file.
std::map<std::string, NpzArray> readNpz(std::string_view bytes);

}  // namespace handgraft::formats
