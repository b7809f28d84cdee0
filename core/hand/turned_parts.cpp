#include "core/hand/turned_parts.h"

#include "core/hand/hand_location.h"

namespace handgraft::hand {

std::vector<TurnedPart> turnedParts(const Anatomy& anatomy) {
  std::vector<TurnedPart> parts;
  for (const NamedDigit& digit : anatomy.digits)
    for (const Segment& segment : digit.segments)
      parts.push_back({partName(digit.name, segment.name), segment.links.back(),
                       segment.boneInSkin(), segment.palmar_S});
  if (anatomy.palm)
    parts.push_back({kPalmPart, anatomy.palm->links.front(), anatomy.palm->outward_S,
                     anatomy.palm->facing_S});
  return parts;
}

}  // namespace handgraft::hand
