#pragma once

#include <filesystem>

#include <Eigen/Core>

namespace handgraft::io {

/// A picture as its file holds it.
struct Picture {
  int width = 0;
  int height = 0;
  /// Pixels row by row from the top left corner, 3 x (width height), in [0, 1].
  Eigen::Matrix3Xf rgb;
};

/// Largest picture accepted, in pixels (600 MB while it is read); checked before memory is
/// taken.
inline constexpr long kMostPixels = 32L << 20;

/// Reads a PNG of any kind: 1 to 16 bits, grey, palette or colour, interlaced or not; 16 bits
/// stay 16 bits. Transparency is left out, gamma and profiles are not applied: contact maps
/// hold numbers. Errors: InvalidInput naming the file and the fault.
Picture readPng(const std::filesystem::path& path);

}  // namespace handgraft::io
