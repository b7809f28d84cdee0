#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace handgraft::io {

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
  struct Member {
    std::string name;
    std::string content;
  };

  void add(const std::string& name,
           const std::string& type,
           const std::vector<std::size_t>& shape,
           std::string_view values);

  std::vector<Member> members_;
};

/// An array of a file: numbers in double precision, the last index fastest.
struct NpzArray {
  std::vector<std::size_t> shape;
  std::vector<double> values;
  std::string text;  ///< of a single text, which has no values
};

/// What `numpy.savez` wrote: arrays of numbers, and single texts, by name. Arrays of anything
/// else are left out. Errors: InvalidInput for what is no such file, breaks off, is compressed
/// (`numpy.savez_compressed`), or holds more than 2^28 numbers.
std::map<std::string, NpzArray> readNpz(std::string_view bytes);

/// As such files begin.
bool isNpz(std::string_view bytes);

}  // namespace handgraft::io
