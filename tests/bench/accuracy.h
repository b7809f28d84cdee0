#pragma once

#include <string>
#include <vector>

#include "core/geometry/log_map.h"

#include "tests/bench/measured_surface.h"

namespace handgraft::bench {

/// How far log maps of one method lie from the truth.
struct Accuracy {
  std::string source;   ///< "vertex", "face", "edge" or "all"
  double r_mean = 0.0;  ///< relative, over vertices off the source
  double r_max = 0.0;
  double phi_mean = 0.0;  ///< rad, after one constant rotation per source
  double phi_max = 0.0;
  long long compared = 0;
  long long missing = 0;  ///< vertices inside the disk that have no coordinates
  int maps = 0;
  int exact_maps = 0;   ///< of them made by `exact`: what `auto` took
  std::string refusal;  ///< why the method cannot use the mesh; then nothing was compared
};

inline constexpr int kSourcesOfAKind = 3;

/// Three sources at vertices, three inside faces, three on edges, drawn with a fixed seed; one
/// Accuracy for each kind and, last, one for all.
std::vector<Accuracy> measureAccuracy(const MeasuredSurface& surface,
                                      geometry::LogMapMethod method);

}  // namespace handgraft::bench
