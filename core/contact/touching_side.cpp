#include "core/contact/touching_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/hand/hand_location.h"

namespace handgraft::contact {

namespace {

// Of recorded right hands the mean cosine is -0.82 to -0.64.
constexpr double kClear = 0.4;
constexpr double kClearAlone = 0.5;  // without the palm's posture

// Length of the mean of directions that agree.
constexpr double kAgreeing = 0.6;

constexpr std::array<const char*, 4> kAcross{"index", "middle", "ring", "little"};

std::string fingerOf(const Patch& patch) {
  if (patch.place) return patch.place->digit;
  const auto place = hand::placeNamed(patch.name);
  return place ? place->digit : patch.name;
}

/// How a palm stood, as its posture tells.
std::optional<PartDirection> palmIn(const ContactSet& contacts) {
  for (const PartDirection& part : contacts.posture)
    if (part.part == hand::kPalmPart) return part;
  return std::nullopt;
}

/// How it stood by the fingers' contacts: they lead away from the wrist, and their pads face
/// what they touch. Nothing where they do not agree.
std::optional<PartDirection> palmOver(const ContactSet& contacts,
                                      const geometry::TriangleMesh& object_O) {
  PartDirection palm{std::string(hand::kPalmPart), Eigen::Vector3d::Zero(),
                     Eigen::Vector3d::Zero()};
  double count = 0.0;
  for (const Patch& patch : contacts.patches) {
    if (!patch.direction_O) continue;
    if (std::find(kAcross.begin(), kAcross.end(), fingerOf(patch)) == kAcross.end()) continue;
    palm.outward_O -= *patch.direction_O;
    palm.palmar_O -= normalOf(object_O, patch.root);
    count += 1.0;
  }
  if (palm.outward_O.norm() < kAgreeing * count || palm.palmar_O.norm() < kAgreeing * count)
    return std::nullopt;
  palm.outward_O.normalize();
  palm.palmar_O -= palm.palmar_O.dot(palm.outward_O) * palm.outward_O;
  if (palm.palmar_O.norm() < kAgreeing) return std::nullopt;
  palm.palmar_O.normalize();
  return palm;
}

}  // namespace

hand::Chirality touchingSide(const ContactSet& contacts,
                             const geometry::TriangleMesh& object_O) {
  if (contacts.side != hand::Chirality::kUnknown) return contacts.side;
  const std::optional<PartDirection> own = palmIn(contacts);
  const std::optional<PartDirection> palm = own ? own : palmOver(contacts, object_O);
  if (!palm) return hand::Chirality::kUnknown;
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
  const double clear = own ? kClear : kClearAlone;
  if (whole <= 0.0 || std::abs(along) < clear * whole) return hand::Chirality::kUnknown;
  return along < 0.0 ? hand::Chirality::kRight : hand::Chirality::kLeft;
}

}  // namespace handgraft::contact
