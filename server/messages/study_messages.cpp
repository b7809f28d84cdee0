#include "server/messages/study_messages.h"

#include <algorithm>

#include "core/base/error.h"
#include "server/messages/convert.h"

namespace handgraft::server {

hand::HandProperty propertyFrom(v1::HandProperty property) {
  switch (property) {
    case v1::PROPERTY_LOWER:
      return hand::HandProperty::kLower;
    case v1::PROPERTY_UPPER:
      return hand::HandProperty::kUpper;
    case v1::PROPERTY_RANGE:
      return hand::HandProperty::kRange;
    case v1::PROPERTY_LENGTH:
      return hand::HandProperty::kLength;
    case v1::PROPERTY_SIZE:
      return hand::HandProperty::kSize;
  }
  rejectInput("property {} of a hand does not exist", static_cast<unsigned>(property));
}

hand::HandChange changeFrom(const v1::HandChange& change) {
  return {propertyFrom(change.property()), change.target(), change.value()};
}

sweep::SweepAxis axisFrom(const v1::SweepAxis& axis) {
  return {propertyFrom(axis.property()), axis.target(), axis.values()};
}

v1::SweepRow toMessage(const sweep::SweepRow& row) {
  v1::SweepRow message;
  message.grasp(static_cast<std::uint32_t>(row.grasp));
  message.values(row.values);
  message.error(row.error);
  message.outcome(toMessage(row.outcome));
  message.terms(toMessage(row.terms));
  message.point_count(static_cast<std::uint32_t>(row.point_count));
  message.mean_mm(row.mean_mm);
  message.max_mm(row.max_mm);
  message.normal_deg(row.normal_deg);
  message.max_depth_m(row.depths.object_m);
  message.self_depth_m(row.depths.self_m);
  message.patch_count(static_cast<std::uint32_t>(row.patch_count));
  message.reached_count(static_cast<std::uint32_t>(row.reached_count));
  for (const sweep::LimitedJoint& limit : row.joints_at_limit)
    message.joints_at_limit().push_back(limitOf(limit.joint, limit.upper));
  message.joint_positions({row.q.data(), row.q.data() + row.q.size()});
  message.solve_ms(row.solve_ms);
  return message;
}

v1::SweepRow toMessage(const sweep::SweepRow& row, const std::string& patch) {
  v1::SweepRow message = toMessage(row);
  message.patch_count(static_cast<std::uint32_t>(row.frame_count));
  message.reached_count(static_cast<std::uint32_t>(row.frames_reached));
  if (patch.empty()) return message;
  const auto found =
      std::find_if(row.patches.begin(), row.patches.end(), [&](const sweep::SweepPatch& one) {
        return one.name == patch;
      });
  const sweep::SweepPatch fit = found == row.patches.end() ? sweep::SweepPatch() : *found;
  message.patch_count(static_cast<std::uint32_t>(fit.frames));
  message.reached_count(static_cast<std::uint32_t>(fit.reached));
  message.point_count(static_cast<std::uint32_t>(fit.point_count));
  message.mean_mm(fit.mean_mm);
  message.max_mm(fit.max_mm);
  message.normal_deg(fit.normal_deg);
  return message;
}

}  // namespace handgraft::server
