#include "tests/bench/contact_import.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "core/contact/segmentation.h"
#include "core/contact/threshold.h"
#include "core/geometry/surface_point.h"
#include "core/io/contact_map_file.h"

#include "tests/bench/recorded_joints.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

using contact::ContactMap;
using contact::HandJoints;
using contact::Patch;
using geometry::TriangleMesh;

/// Parts of the hand whose labels are in contact over more than a speck.
std::vector<std::string> touchingByLabels(const ContactMap& map,
                                          const contact::SegmentationOptions& options) {
  if (map.label.empty()) return {};
  const Eigen::VectorXd areas = contact::vertexAreas(map.mesh_O);
  std::vector<std::string> touching;
  for (const char* part : contact::kHandParts) {
    double area = 0.0;
    for (int v = 0; v < map.mesh_O.vertexCount(); ++v)
      if (map.value[v] > options.threshold &&
          contact::partOfLabel(map, map.label[static_cast<std::size_t>(v)]).starts_with(part))
        area += areas[v];
    if (area >= options.minimum_area_m2) touching.emplace_back(part);
  }
  return touching;
}

/// Whether the nearest of the 21 joints is one of that part; where fingers spring from the palm
/// it may be either.
bool isNearestTo(const HandJoints& joints,
                 const std::string& part,
                 const Eigen::Vector3d& p_O) {
  Eigen::Index nearest = 0;
  (joints.p_O.colwise() - p_O).colwise().squaredNorm().minCoeff(&nearest);
  const bool on_palm = nearest == 0 || (nearest > 4 && nearest % 4 == 1);
  if (part.starts_with("palm")) return on_palm;
  return nearest > 0 && part.starts_with(contact::kHandParts[(nearest - 1) / 4]);
}

double distanceToLoop(const TriangleMesh& mesh,
                      const std::vector<int>& loop,
                      const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector3d a = mesh.vertex(loop[i]);
    const Eigen::Vector3d d = mesh.vertex(loop[(i + 1) % loop.size()]) - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * d).norm());
  }
  return nearest;
}

/// Of the fan around the centre: good for what is said of sizes.
double areaInside(const TriangleMesh& mesh, const Patch& patch) {
  const Eigen::Vector3d centre = positionOf(mesh, patch.root);
  double area = 0.0;
  for (std::size_t i = 0; i < patch.boundary.size(); ++i) {
    const Eigen::Vector3d a = mesh.vertex(patch.boundary[i]) - centre;
    const Eigen::Vector3d b =
        mesh.vertex(patch.boundary[(i + 1) % patch.boundary.size()]) - centre;
    area += 0.5 * a.cross(b).norm();
  }
  return area;
}

void measurePatches(const ContactMap& map,
                    const contact::ContactSet& set,
                    const std::optional<HandJoints>& joints,
                    ContactImport& import) {
  for (const Patch& patch : set.patches) {
    import.patches.push_back(patch.name);
    import.area_mm2 +=
        1e6 * areaInside(map.mesh_O, patch) / static_cast<double>(set.patches.size());
    import.points += static_cast<int>(patch.interpolation_boundary.size());
    for (const geometry::SurfacePoint& point : patch.interpolation_boundary)
      import.off_boundary_mm = std::max(
          import.off_boundary_mm,
          1e3 * distanceToLoop(map.mesh_O, patch.boundary, positionOf(map.mesh_O, point)));
    if (!joints) continue;
    ++import.compared;
    if (isNearestTo(*joints, patch.name, positionOf(map.mesh_O, patch.root)))
      ++import.confirmed;
  }
}

}  // namespace

ContactImport importContacts(const fs::path& path) {
  ContactImport import;
  import.name = path.stem().string();
  try {
    const ContactMap map = io::readContactMap(path);
    const std::optional<HandJoints> joints = recordedJoints(path);
    contact::SegmentationOptions options;
    import.touching = touchingByLabels(map, options);
    import.without_help = static_cast<int>(contact::segment(map, options).patches.size());
    if (map.label.empty()) options.joints_O = joints;
    const contact::ContactSet set = contact::segment(map, options);
    import.notes = set.notes;
    measurePatches(map, set, joints, import);
  } catch (const InvalidInput& error) {
    import.refused = error.what();
  }
  return import;
}

std::vector<fs::path> contactMapsIn(const std::vector<std::string>& folders) {
  constexpr std::string_view kEnd = "_contact.ply";
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    if (!fs::is_directory(folder)) rejectInput("{} is no folder", quoted(folder));
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && entry.path().filename().string().ends_with(kEnd))
        files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace handgraft::bench
