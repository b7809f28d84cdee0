#include "core/contact/own_contact.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/contact/region.h"

namespace handgraft::contact {

namespace {

/// Faces that touch with any corner: a region takes along what lies at its rim.
std::vector<char> touchingFaces(const ContactMap& map, double threshold) {
  std::vector<char> marked(static_cast<std::size_t>(map.mesh_O.faceCount()));
  for (int f = 0; f < map.mesh_O.faceCount(); ++f) {
    const Eigen::Vector3i face = map.mesh_O.face(f);
    const bool touches = std::any_of(face.begin(), face.end(), [&](int v) {
      return map.value[v] > threshold;
    });
    marked[static_cast<std::size_t>(f)] = touches ? 1 : 0;
  }
  return marked;
}

double meanDistance(const HandJoints& joints,
                    const geometry::TriangleMesh& mesh_O,
                    const std::vector<int>& vertices) {
  double sum = 0.0;
  for (const int v : vertices)
    sum += nearestBone(joints, mesh_O.vertex(v)).distance_m;
  return sum / static_cast<double>(vertices.size());
}

}  // namespace

std::vector<std::string> keepOwnContact(ContactMap& map,
                                        double threshold,
                                        const HandJoints& own,
                                        const std::vector<HandJoints>& others) {
  int kept = 0;
  int of_others = 0;
  int of_none = 0;
  double nearest_left_out = std::numeric_limits<double>::infinity();
  std::vector<int> cleared;
  for (const Region& region : connectedRegions(map.mesh_O, touchingFaces(map, threshold))) {
    std::vector<int> touching;
    for (const int f : region) {
      for (const int v : map.mesh_O.face(f))
        if (map.value[v] > threshold) touching.push_back(v);
    }
    const double distance = meanDistance(own, map.mesh_O, touching);
    const bool is_others =
        std::any_of(others.begin(), others.end(), [&](const HandJoints& other) {
          return meanDistance(other, map.mesh_O, touching) < distance;
        });
    if (!is_others && distance <= kFarthestBone) {
      ++kept;
      continue;
    }
    (is_others ? of_others : of_none) += 1;
    nearest_left_out = std::min(nearest_left_out, distance);
    cleared.insert(cleared.end(), touching.begin(), touching.end());
  }
  if (kept == 0 && of_others + of_none > 0) {
    rejectInput(
        "hand joints: the nearest contact is {:.0f} mm from their bones{}; permitted are "
        "{:.0f} "
        "mm: are they of another object, hand or frame?",
        1e3 * nearest_left_out, of_others > 0 ? " and nearer to another hand's" : "",
        1e3 * kFarthestBone);
  }
  for (const int v : cleared)
    map.value[v] = std::min(threshold, 0.0);
  std::vector<std::string> notes;
  if (of_others > 0) {
    notes.push_back(
        fmt::format("regions in contact that are nearer to another hand's joints, left out: {}",
                    of_others));
  }
  if (of_none > 0) {
    notes.push_back(fmt::format(
        "regions in contact farther than {:.0f} mm from the hand's joints, left out: {}",
        1e3 * kFarthestBone, of_none));
  }
  return notes;
}

}  // namespace handgraft::contact
