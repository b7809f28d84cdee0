#pragma once

#include <string>

#include "core/base/error.h"

namespace handgraft::server {

/// The size of a mesh says that it is in other units than metres, and nobody said which. The
/// message names the size and what to say of the units that would make sense.
class UnitsInDoubt : public InvalidInput {
 public:
  using InvalidInput::InvalidInput;
};

/// Metres per unit; 1 for empty. Errors: InvalidInput naming those that are no kLengthUnits.
double metresPer(const std::string& units);

/// What an object's lengths are to be multiplied with: by its units where they are given, else
/// 1.
///
/// `size` is across, in the file's own units. Errors: UnitsInDoubt if no units are given, the
/// object is wider than kLargestUnasked_m as metres, and other units would make sense;
/// InvalidInput if it is not 1 mm to 10 m across.
double objectScale(double size, const std::string& units, const std::string& name);

/// Which units a contact map is in: a map lies on its object, so its size (of its mesh, or of
/// the points that it lists) cannot be more than the object's.
struct MapScale {
  double scale = 1.0;
  std::string note;  ///< if it is other than one would think
};

/// The first that fits the object, of: the units given for the map, or else the object's own;
/// and metres. Fits: a hundredth to one and a half of the object's size. If none does, metres;
/// but where units are given, those that make it half to one and a half of the object, or else
/// the given ones. Errors: UnitsInDoubt if no units are given and it is too wide for metres;
/// InvalidInput for unknown units.
MapScale mapScale(double size,
                  const std::string& units,
                  const std::string& object_units,
                  double object_m,
                  const std::string& name);

/// Wider objects may be meant, but nobody grasps them: most are in millimetres.
inline constexpr double kLargestUnasked = 3.0;  // m

}  // namespace handgraft::server
