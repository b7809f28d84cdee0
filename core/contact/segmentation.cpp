#include "core/contact/segmentation.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/contact/outline.h"
#include "core/contact/region.h"
#include "core/contact/threshold.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

/// Vertices in contact that belong together: a finger's, an anonymous segment's, or all.
struct Group {
  std::string name;           ///< of the finger; empty if anonymous
  std::vector<char> touches;  ///< per vertex
};

struct Component {
  Region faces;
  double area = 0.0;
  double contact = 0.0;   ///< m^2: contact integrated over the area
  bool is_grown = false;  ///< also of faces that touch with less than all corners
};

void validate(const SegmentationOptions& options) {
  if (!(options.low_share > 0.0 && options.low_share <= 1.0)) {
    rejectInput("low share of the contact threshold is {}; permitted are 0 (excluded) to 1",
                options.low_share);
  }
  if (options.joints_O) contact::validate(*options.joints_O);
  if (!(options.outline_share >= 0.0 && options.outline_share < 1.0)) {
    rejectInput(
        "share of a patch's contact at its outline is {}; permitted are 0 to 1 (excluded)",
        options.outline_share);
  }
  if (!std::isfinite(options.threshold)) {
    rejectInput("contact threshold is {}; it must be finite", options.threshold);
  }
  if (!(options.minimum_area_m2 >= 0.0)) {
    rejectInput("minimum patch area is {} m2; it must be 0 or more", options.minimum_area_m2);
  }
}

double mm2(double m2) {
  return m2 * 1e6;
}

double areaOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3d a = mesh.vertex(mesh.face(f)[0]);
  return 0.5 *
         (mesh.vertex(mesh.face(f)[1]) - a).cross(mesh.vertex(mesh.face(f)[2]) - a).norm();
}

/// Components of the faces that touch with at least `corners` of their vertices. Area and
/// contact count the share of the touching corners alone.
std::vector<Component> componentsOf(const ContactMap& map, const Group& group, int corners) {
  const TriangleMesh& mesh = map.mesh_O;
  const auto touching = [&](int f) {
    const Eigen::Vector3i face = mesh.face(f);
    return group.touches[face[0]] + group.touches[face[1]] + group.touches[face[2]];
  };
  std::vector<char> marked(static_cast<std::size_t>(mesh.faceCount()));
  for (int f = 0; f < mesh.faceCount(); ++f)
    marked[f] = touching(f) >= corners ? 1 : 0;

  std::vector<Component> components;
  for (Region& region : connectedRegions(mesh, marked)) {
    Component component;
    for (const int f : region) {
      const double corner_area = areaOf(mesh, f) / 3.0;
      for (const int v : mesh.face(f)) {
        if (group.touches[v] == 0) continue;
        component.area += corner_area;
        component.contact += corner_area * map.value[v];
      }
    }
    component.faces = std::move(region);
    components.push_back(std::move(component));
  }
  return components;
}

class Segmenter {
 public:
  /// `map` as it is after smoothing.
  Segmenter(ContactMap map, const SegmentationOptions& options)
      : map_(std::move(map)),
        options_(options),
        threshold_(thresholdOf(map_, options)),
        even_(smoothed(map_.mesh_O, map_.value, kOutlineSmoothingSteps)),
        areas_(vertexAreas(map_.mesh_O)) {}

  ContactSet run() {
    if (options_.rule == ThresholdRule::kOtsu)
      note("threshold by Otsu's rule: {:.3g}", threshold_);
    if (options_.joints_O && !namesFingers()) {
      const Group all = groupOf("", [](int) {
        return true;
      });
      assignFingers(map_, all.touches, *options_.joints_O, options_.minimum_area_m2);
    }
    for (const Group& group : groups()) {
      if (group.name.empty()) {
        collectAnonymous(group);
      } else {
        addFinger(group);
      }
    }
    addAnonymous();
    if (set_.patches.empty()) rejectInput("{}", nothingLeft());
    return std::move(set_);
  }

 private:
  template <class... Args>
  void note(fmt::format_string<Args...> format, Args&&... args) {
    set_.notes.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  [[nodiscard]] bool touches(int v) const { return map_.value[v] > threshold_; }

  /// Whether labels say which finger touches, somewhere.
  [[nodiscard]] bool namesFingers() const {
    for (int v = 0; v < map_.mesh_O.vertexCount() && !map_.label.empty(); ++v) {
      if (touches(v) && !fingerOf(map_.label[v]).empty()) return true;
    }
    return false;
  }

  template <class Belongs>
  [[nodiscard]] Group groupOf(const std::string& name, const Belongs& belongs) const {
    std::vector<char> candidates(static_cast<std::size_t>(map_.mesh_O.vertexCount()));
    for (int v = 0; v < map_.mesh_O.vertexCount(); ++v)
      candidates[v] = belongs(v) ? 1 : 0;
    return {name, aboveWithHysteresis(map_.mesh_O, map_.value, candidates,
                                      std::min(options_.low_share * threshold_, threshold_),
                                      threshold_)};
  }

  [[nodiscard]] std::string fingerOf(int label) const { return partOfLabel(map_, label); }

  std::vector<Group> groups() {
    if (map_.label.empty()) {
      return {groupOf("", [](int) {
        return true;
      })};
    }
    std::set<int> segments;
    int unlabelled = 0;
    for (int v = 0; v < map_.mesh_O.vertexCount(); ++v) {
      if (!touches(v)) continue;
      if (map_.label[v] >= 0) segments.insert(map_.label[v]);
      if (map_.label[v] < 0) ++unlabelled;
    }
    if (unlabelled > 0) note("vertices in contact without label, left out: {}", unlabelled);

    std::set<std::string> fingers;
    for (const int label : segments)
      fingers.insert(fingerOf(label));
    fingers.erase("");

    // The usual parts in their order, then others by their names.
    std::vector<std::string> order;
    for (const char* part : kHandParts) {
      if (fingers.erase(part) > 0) order.emplace_back(part);
    }
    order.insert(order.end(), fingers.begin(), fingers.end());

    std::vector<Group> groups;
    for (const std::string& finger : order) {
      groups.push_back(groupOf(finger, [&](int v) {
        return fingerOf(map_.label[v]) == finger;
      }));
    }
    for (const int label : segments) {
      if (!fingerOf(label).empty()) continue;
      if (order.empty()) {
        groups.push_back(groupOf("", [&](int v) {
          return map_.label[v] == label;
        }));
      } else {
        note("segment {} names no finger: left out", segmentName(label));
      }
    }
    return groups;
  }

  [[nodiscard]] std::string segmentName(int label) const {
    return label < std::ssize(map_.segment_names) ? quoted(map_.segment_names[label])
                                                  : std::to_string(label);
  }

  void addFinger(const Group& group) {
    std::vector<Component> components = componentsOf(map_, group, 3);
    auto best = mostContact(components);
    if (best == components.end() || best->area < options_.minimum_area_m2) {
      components = componentsOf(map_, group, 1);
      best = mostContact(components);
      if (best == components.end() || best->area < options_.minimum_area_m2) {
        note("'{}' dropped: its contact covers {:.0f} mm2 at most, below {:.0f} mm2",
             group.name, best == components.end() ? 0.0 : mm2(best->area),
             mm2(options_.minimum_area_m2));
        return;
      }
      best->is_grown = true;
      note("'{}' grown to all faces that it touches: the mesh is coarse there", group.name);
    }
    if (components.size() > 1) {
      double rest = -best->area;
      for (const Component& component : components)
        rest += component.area;
      note("'{}' touches in {} places: the one with most contact was taken, {:.0f} mm2 dropped",
           group.name, components.size(), mm2(rest));
    }
    addPatch(group.name, *best);
  }

  static std::vector<Component>::iterator mostContact(std::vector<Component>& components) {
    return std::max_element(components.begin(), components.end(),
                            [](const Component& a, const Component& b) {
                              return a.contact < b.contact;
                            });
  }

  void collectAnonymous(const Group& group) {
    for (Component& component : componentsOf(map_, group, 3)) {
      anonymous_.push_back(std::move(component));
    }
  }

  void addAnonymous() {
    std::stable_sort(anonymous_.begin(), anonymous_.end(),
                     [](const Component& a, const Component& b) {
                       return a.area > b.area;
                     });
    int specks = 0;
    int count = 0;
    for (const Component& component : anonymous_) {
      if (component.area < options_.minimum_area_m2) {
        ++specks;
      } else if (addPatch(fmt::format("c{}", count + 1), component)) {
        ++count;
      }
    }
    if (specks > 0) {
      note("specks below {:.0f} mm2 dropped: {}", mm2(options_.minimum_area_m2), specks);
    }
  }

  [[nodiscard]] Region touchingPart(const Component& component) const {
    if (component.is_grown || options_.outline_share == 0.0) return component.faces;
    return outlined(map_.mesh_O, component.faces, map_.value, even_, areas_,
                    {options_.outline_share, options_.minimum_area_m2});
  }

  bool addPatch(const std::string& name, const Component& component) {
    const TriangleMesh& mesh = map_.mesh_O;
    const Region faces = touchingPart(component);
    OuterBoundary boundary = outerBoundary(mesh, faces);
    if (boundary.loop.empty()) {
      note("'{}' dropped: it covers a closed surface whole and has no boundary", name);
      return false;
    }
    if (boundary.other_loops > 0) {
      note("'{}': only the outer boundary counts, holes or pinches left out: {}", name,
           boundary.other_loops);
    }
    point_count_ += static_cast<std::size_t>(std::max(0, options_.interpolation_count));
    if (set_.patches.size() >= kMostPatches || point_count_ > kMostPoints) {
      rejectInput(
          "contact map gives more than {} patches of {} points; permitted are {} patches "
          "and {} points in all; a larger minimum area or threshold leaves fewer",
          set_.patches.size(), options_.interpolation_count, kMostPatches, kMostPoints);
    }
    Patch patch;
    patch.name = name;
    patch.root =
        geometry::surfacePointAtVertex(mesh, geodesicCentre(mesh, faces, boundary.loop));
    patch.interpolation_boundary =
        sampleLoop(mesh, boundary.loop, options_.interpolation_count);
    patch.boundary = std::move(boundary.loop);
    if (options_.joints_O) {
      patch.direction_O = directionTowardsWrist(*options_.joints_O, name,
                                                geometry::positionOf(mesh, patch.root),
                                                geometry::normalOf(mesh, patch.root));
    }
    set_.patches.push_back(std::move(patch));
    return true;
  }

  [[nodiscard]] std::string nothingLeft() const {
    const double most = map_.value.size() > 0 ? map_.value.maxCoeff() : 0.0;
    std::string message = fmt::format(
        "contact map leaves no patch: its largest contact is {:.3g}, the threshold {:.3g}",
        most, threshold_);
    for (const std::string& remark : set_.notes)
      message += "; " + remark;
    return message;
  }

  ContactMap map_;
  const SegmentationOptions& options_;
  double threshold_;
  Eigen::VectorXd even_;   ///< values without noise
  Eigen::VectorXd areas_;  ///< of the vertices
  std::vector<Component> anonymous_;
  std::size_t point_count_ = 0;
  ContactSet set_;
};

}  // namespace

double thresholdOf(const ContactMap& map, const SegmentationOptions& options) {
  if (options.rule == ThresholdRule::kGiven) return options.threshold;
  const Eigen::VectorXd areas = vertexAreas(map.mesh_O);
  return otsuThreshold(map.value, (map.value.array() > 0.0).select(areas, 0.0));
}

ContactSet segment(const ContactMap& map, const SegmentationOptions& options) {
  validate(map);
  validate(options);
  ContactMap even = map;
  even.value = smoothed(map.mesh_O, map.value, options.smoothing_steps);
  return Segmenter(std::move(even), options).run();
}

}  // namespace handgraft::contact
