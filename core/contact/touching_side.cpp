#include "core/contact/touching_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/hand/hand_location.h"

namespace handgraft::contact {

namespace {

// Of recorded right hands the mean cosine is -0.82 to -0.64.
constexpr double kClear = 0.4;

constexpr std::array<const char*, 4> kAcross{"index", "middle", "ring", "little"};

std::string fingerOf(const Patch& patch) {
  if (patch.place) return patch.place->digit;
  const auto place = hand::placeNamed(patch.name);
  return place ? place->digit : patch.name;
}

}  // namespace

hand::Chirality touchingSide(const ContactSet& contacts,
                             const geometry::TriangleMesh& object_O) {
  const auto palm = std::find_if(contacts.posture.begin(), contacts.posture.end(),
                                 [](const PartDirection& part) {
                                   return part.part == hand::kPalmPart;
                                 });
  if (palm == contacts.posture.end()) return hand::Chirality::kUnknown;
  const Eigen::Vector3d across_O = palm->outward_O.cross(palm->palmar_O);
  std::vector<std::pair<std::ptrdiff_t, Eigen::Vector3d>> touches;
  for (const Patch& patch : contacts.patches) {
    const auto finger = std::find(kAcross.begin(), kAcross.end(), fingerOf(patch));
    if (finger == kAcross.end()) continue;
    touches.emplace_back(finger - kAcross.begin(), positionOf(object_O, patch.root));
  }
  double along = 0.0;
  double whole = 0.0;
  for (const auto& [before, from_O] : touches) {
    for (const auto& [after, to_O] : touches) {
      if (after <= before) continue;
      along += (to_O - from_O).dot(across_O);
      whole += (to_O - from_O).norm();
    }
  }
  if (whole <= 0.0 || std::abs(along) < kClear * whole) return hand::Chirality::kUnknown;
  return along < 0.0 ? hand::Chirality::kRight : hand::Chirality::kLeft;
}

}  // namespace handgraft::contact
