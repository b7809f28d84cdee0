#include "core/contact/segmentation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/contact/outline.h"
#include "core/contact/own_contact.h"
#include "core/contact/region.h"
#include "core/contact/threshold.h"
#include "core/hand/hand_location.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

/// Vertices in contact that belong together: a finger's, an anonymous segment's, or all.
struct Group {
  std::string name;           ///< of the finger; empty if anonymous
  std::vector<char> touches;  ///< per vertex
};

/// Share of a digit's region in one piece below which a segment's part is but a border.
constexpr double kSliver = 0.15;
/// A segment's vertices along the border of another's region make no contact of their own.
constexpr double kNoise = 5e-6;  // m^2
// Of one segment of a finger; a thumb's pad has some 600 mm2.
constexpr double kLargestTouch = 8e-4;  // m^2
// Nor a hand so much of an object: what is painted is what was not touched, or all of it.
constexpr double kNoTouch = 0.5;

/// `index` and `proximal` of `index_proximal_2`; `index` and nothing of `index`.
std::pair<std::string, std::string> splitPart(const std::string& part) {
  if (const auto place = hand::placeNamed(part)) return {place->digit, place->segment};
  return {part, ""};
}

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
  for (const HandJoints& joints : options.other_joints_O)
    contact::validate(joints);
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
    else
      tellAnotherScale();
    tellBelowZero();
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

  /// Contact is a share, 0 to 1, for most who write it; bytes and forces are other scales.
  void tellAnotherScale() {
    constexpr double kNoShare = 1.5;  // leaves room for shares that are not quite
    const double most = map_.value.size() > 0 ? map_.value.maxCoeff() : 0.0;
    if (most < kNoShare || threshold_ >= 1.0) return;
    note(
        "contact up to {:.4g} is no share from 0 to 1, and all above the threshold {:.3g} "
        "counts; as a share of the largest that would be a threshold of {:.3g}",
        most, threshold_, threshold_ * most);
  }

  /// Nothing touches less than not at all: such values mean something else (distances, a mark
  /// for "not measured", another zero).
  void tellBelowZero() {
    constexpr double kRounding = 1e-9;
    const auto count = (map_.value.array() < -kRounding).count();
    if (count == 0) return;
    note("{} of {} vertices have contact below 0, down to {:.4g}; it counts as none", count,
         map_.value.size(), map_.value.minCoeff());
  }

  [[nodiscard]] bool touches(int v) const { return map_.value[v] > threshold_; }

  /// Whether labels say which finger touches, somewhere.
  [[nodiscard]] bool namesFingers() const {
    for (int v = 0; v < map_.mesh_O.vertexCount() && !map_.label.empty(); ++v) {
      if (touches(v) && !partOf(map_.label[v]).empty()) return true;
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

  [[nodiscard]] std::string partOf(int label) const { return partOfLabel(map_, label); }

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

    std::map<int, std::string> part_of;  // of each label in contact that names one
    for (const int label : segments)
      if (std::string part = partOf(label); !part.empty()) part_of[label] = std::move(part);
    std::vector<int> label = map_.label;
    giveSliversAway(part_of, label);

    // The usual parts in their order, then others by their names.
    std::set<std::string> parts;
    for (const auto& [one, part] : part_of)
      parts.insert(part);
    std::vector<std::string> order(parts.begin(), parts.end());
    std::stable_sort(order.begin(), order.end(),
                     [](const std::string& a, const std::string& b) {
                       return rankOf(a) < rankOf(b);
                     });

    std::vector<Group> groups;
    groups.reserve(order.size());
    for (const std::string& part : order) {
      groups.push_back(groupOf(part, [&](int v) {
        const auto found = part_of.find(label[static_cast<std::size_t>(v)]);
        return found != part_of.end() && found->second == part;
      }));
    }
    for (const int one : segments) {
      if (part_of.contains(one)) continue;
      if (order.empty()) {
        groups.push_back(groupOf("", [&](int v) {
          return map_.label[v] == one;
        }));
      } else {
        note("segment {} names no finger: left out", segmentName(one));
      }
    }
    return groups;
  }

  /// Fingers as usual, palm last; of each its segments from the palm outwards.
  static int rankOf(const std::string& part) {
    const auto [digit, segment] = splitPart(part);
    const auto at = std::find(std::begin(kHandParts), std::end(kHandParts), digit);
    static constexpr std::string_view kSegments[] = {"", "proximal", "middle", "distal"};
    const auto where = std::find(std::begin(kSegments), std::end(kSegments), segment);
    return static_cast<int>(8 * (at - std::begin(kHandParts)) +
                            (where - std::begin(kSegments)));
  }

  /// Where a digit touches in one piece with several segments, those with little of it leave it
  /// to the one with most: a label's border beside a patch is no contact of its own.
  void giveSliversAway(const std::map<int, std::string>& part_of, std::vector<int>& label) {
    const TriangleMesh& mesh = map_.mesh_O;
    std::set<std::string> digits;
    for (const auto& [one, part] : part_of)
      if (!splitPart(part).second.empty()) digits.insert(splitPart(part).first);
    const auto part_at = [&](int v) -> const std::string* {
      const auto found = part_of.find(label[static_cast<std::size_t>(v)]);
      return touches(v) && found != part_of.end() ? &found->second : nullptr;
    };
    for (const std::string& digit : digits) {
      std::vector<char> marked(static_cast<std::size_t>(mesh.faceCount()), 0);
      for (int f = 0; f < mesh.faceCount(); ++f) {
        const Eigen::Vector3i face = mesh.face(f);
        marked[static_cast<std::size_t>(f)] = std::all_of(face.begin(), face.end(), [&](int v) {
          const std::string* part = part_at(v);
          return part != nullptr && splitPart(*part).first == digit;
        });
      }
      for (const Region& region : connectedRegions(mesh, marked))
        giveSliversOfRegionAway(region, label);
    }
  }

  void giveSliversOfRegionAway(const Region& region, std::vector<int>& label) const {
    std::set<int> vertices;
    for (const int f : region)
      for (const int v : map_.mesh_O.face(f))
        vertices.insert(v);
    std::map<int, double> area;
    double whole = 0.0;
    for (const int v : vertices) {
      area[label[static_cast<std::size_t>(v)]] += areas_[v];
      whole += areas_[v];
    }
    const auto most = std::max_element(area.begin(), area.end(), [](auto& a, auto& b) {
      return a.second < b.second;
    });
    const double least = std::max(options_.minimum_area_m2, kSliver * whole);
    for (const int v : vertices)
      if (area[label[static_cast<std::size_t>(v)]] < least)
        label[static_cast<std::size_t>(v)] = most->first;
  }

  [[nodiscard]] std::string segmentName(int label) const {
    return label < std::ssize(map_.segment_names) ? quoted(map_.segment_names[label])
                                                  : std::to_string(label);
  }

  void addFinger(const Group& group) {
    std::vector<Component> components = componentsOfFinger(group);
    if (components.empty()) return;
    const bool is_segment =
        group.name == hand::kPalmPart || !splitPart(group.name).second.empty();
    std::stable_sort(components.begin(), components.end(),
                     [](const Component& a, const Component& b) {
                       return a.contact > b.contact;
                     });
    double dropped = 0.0;
    int count = 0;
    for (const Component& component : components) {
      const bool is_patch = count == 0 || (is_segment && !component.is_grown &&
                                           component.area >= options_.minimum_area_m2);
      const std::string name =
          count == 0 ? group.name : fmt::format("{}_{}", group.name, count + 1);
      if (is_patch && addPatch(name, component, false)) {
        ++count;
      } else {
        dropped += component.area;
      }
    }
    if (dropped > 0.0 && !is_segment) {
      note("'{}' touches in {} places: the one with most contact was taken, {:.0f} mm2 dropped",
           group.name, components.size(), mm2(dropped));
    } else if (dropped > 0.0) {
      note("'{}': specks of {:.0f} mm2 in all dropped", group.name, mm2(dropped));
    }
  }

  /// Of the faces that touch with all corners; where these are too small, grown. Nothing if
  /// even so they are no patch.
  std::vector<Component> componentsOfFinger(const Group& group) {
    std::vector<Component> components = componentsOf(map_, group, 3);
    auto best = mostContact(components);
    if (best != components.end() && best->area >= options_.minimum_area_m2) return components;
    components = componentsOf(map_, group, 1);
    best = mostContact(components);
    const double area = best == components.end() ? 0.0 : best->area;
    // Its neighbours have it.
    if (area < kNoise && !splitPart(group.name).second.empty()) return {};
    if (best == components.end() || area < options_.minimum_area_m2) {
      note("'{}' dropped: its contact covers {:.0f} mm2 at most, below {:.0f} mm2", group.name,
           mm2(area), mm2(options_.minimum_area_m2));
      return {};
    }
    note("'{}' grown to all faces that it touches: the mesh is coarse there", group.name);
    for (Component& component : components)
      component.is_grown = true;
    return components;
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
        continue;
      }
      const std::string name = fmt::format("c{}", count + 1);
      if (!addPatch(name, component, true)) continue;
      ++count;
      if (component.area > kNoTouch * areas_.sum()) {
        note(
            "'{}' covers {:.0f} % of the object, which no hand does: is contact where the map "
            "is low, or are its colours of another scale, or of none?",
            name, 100.0 * component.area / areas_.sum());
      } else if (component.area > kLargestTouch) {
        note(
            "'{}' covers {:.0f} mm2, more than one finger touches: where the joints of the "
            "hand that touched are known, they part it",
            name, mm2(component.area));
      }
    }
    // Behind the others, whose names do not depend on them.
    for (const Region& part : further_)
      if (addPatch(fmt::format("c{}", count + 1), part)) ++count;
    if (specks > 0) {
      note("specks below {:.0f} mm2 dropped: {}", mm2(options_.minimum_area_m2), specks);
    }
  }

  /// One at least, that with most contact first.
  [[nodiscard]] std::vector<Region> touchingParts(const Component& component) const {
    if (component.is_grown || options_.outline_share == 0.0) return {component.faces};
    return outlined(map_.mesh_O, component.faces, map_.value, even_, areas_,
                    {options_.outline_share, options_.minimum_area_m2});
  }

  /// The part with most contact; what its region has beside it becomes patches where nobody
  /// says which finger touched, and is told of a finger, which touches once.
  bool addPatch(const std::string& name, const Component& component, bool is_anonymous) {
    std::vector<Region> parts = touchingParts(component);
    if (!addPatch(name, parts.front())) return false;
    if (is_anonymous) {
      std::move(parts.begin() + 1, parts.end(), std::back_inserter(further_));
    } else if (parts.size() > 1) {
      double dropped = 0.0;
      for (std::size_t i = 1; i < parts.size(); ++i)
        for (const int f : parts[i])
          dropped += areaOf(map_.mesh_O, f);
      note(
          "'{}': its outline falls into {} parts: the one with most contact was taken, {:.0f} "
          "mm2 dropped",
          name, parts.size(), mm2(dropped));
    }
    return true;
  }

  bool addPatch(const std::string& name, const Region& faces) {
    const TriangleMesh& mesh = map_.mesh_O;
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
      const Eigen::Vector3d p_O = geometry::positionOf(mesh, patch.root);
      const Eigen::Vector3d n_O = geometry::normalOf(mesh, patch.root);
      const std::string digit = splitPart(name).first;
      patch.direction_O = directionTowardsWrist(*options_.joints_O, digit, p_O, n_O);
      if (hand::placeNamed(name))
        patch.place = placeByJoints(*options_.joints_O, name, p_O, n_O);
    }
    set_.patches.push_back(std::move(patch));
    return true;
  }

  /// What is above the threshold, and is no patch even so.
  [[nodiscard]] std::string whereItIsAbove() const {
    const Group all{
        "", aboveWithHysteresis(
                map_.mesh_O, map_.value,
                std::vector<char>(static_cast<std::size_t>(map_.mesh_O.vertexCount()), 1),
                threshold_, threshold_)};
    double largest = 0.0;
    for (const Component& component : componentsOf(map_, all, 3))
      largest = std::max(largest, component.area);
    const double least = options_.minimum_area_m2;
    if (largest == 0.0)
      return "; but no face of the mesh is above it at all three corners: the mesh is coarse "
             "there";
    if (largest >= least) return "";  // the notes say why
    return fmt::format(
        "; but what is above it covers {:.3g} mm2 at most in one place, and the "
        "least area of a patch is {:.3g} mm2",
        mm2(largest), mm2(least));
  }

  [[nodiscard]] std::string nothingLeft() const {
    const double most = map_.value.size() > 0 ? map_.value.maxCoeff() : 0.0;
    std::string message = fmt::format(
        "contact map leaves no patch: its largest contact is {:.3g}, {} the "
        "threshold {:.3g}",
        most, most > threshold_ ? "above" : "not above", threshold_);
    if (most > threshold_) message += whereItIsAbove();
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
  std::vector<Region> further_;  ///< parts of those, beside the ones with most contact
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
  if (!options.joints_O) return Segmenter(std::move(even), options).run();
  std::vector<std::string> notes = keepOwnContact(even, thresholdOf(even, options),
                                                  *options.joints_O, options.other_joints_O);
  ContactSet set = Segmenter(std::move(even), options).run();
  set.notes.insert(set.notes.begin(), notes.begin(), notes.end());
  return set;
}

}  // namespace handgraft::contact
