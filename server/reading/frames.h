#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace handgraft::server {

/// What the reading process says on its standard output, one frame after another: progress,
/// then one answer.
enum class FrameKind : std::uint8_t {
  kProgress = 'p',  ///< a fraction (double), then the stage
  kModel = 'm',     ///< `pack(ReadModel)`
  kWrong = 'w',     ///< InvalidInput's words
  kUnits = 'u',     ///< UnitsInDoubt's
  kMemory = 'o',    ///< it ran out of memory
  kMistake = 'x',   ///< another exception's words: our own mistake
};

struct Frame {
  FrameKind kind = FrameKind::kProgress;
  std::string payload;
};

/// Largest model that a reading process may send.
inline constexpr std::size_t kMostModelBytes = 1ull << 30;
/// Of all other frames.
inline constexpr std::size_t kMostWords = 16u << 10;

/// The bytes of a frame; words longer than permitted are cut.
std::string framed(FrameKind kind, std::string_view payload);
std::string progressFrame(std::string_view stage, double fraction);

/// Puts frames together from pieces of a stream that nobody vouches for.
class FrameReader {
 public:
  /// Errors: InvalidInput for a kind that does not exist, or a size beyond the permitted one.
  void add(std::string_view bytes);

  /// The next whole frame.
  std::optional<Frame> next();

 private:
  std::string bytes_;
};

struct ProgressWords {
  std::string stage;  ///< printable ASCII, cut at 100 characters
  double fraction = 0.0;
};

/// What a progress frame says. Errors: InvalidInput if it says nothing sensible.
ProgressWords progressIn(const std::string& payload);

}  // namespace handgraft::server
