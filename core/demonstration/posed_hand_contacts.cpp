#include "core/demonstration/posed_hand_contacts.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/contact/edge_refinement.h"
#include "core/contact/reproject.h"
#include "core/contact/threshold.h"
#include "core/demonstration/shown_posture.h"
#include "core/geometry/tangent.h"
#include "core/hand/turned_parts.h"

namespace handgraft::demonstration {

namespace {

/// A hand in its pose, seen from the object.
struct PosedHand {
  const hand::Hand& hand;
  const hand::FingerCoordinates& coordinates;
  const hand::HandParts& parts;
  const placement::SkinFaces& skin_faces;
  hand::LinkPoses X_OL;
  hand::LinkPoses X_SO;  ///< Skin::fromWorld, seen from the object
};

/// The part of each link: a segment's, or what HandParts calls it.
std::vector<std::string> partsOf(const hand::FingerCoordinates& coordinates,
                                 const hand::HandParts& parts) {
  std::vector<std::string> names;
  for (std::size_t link = 0; link < parts.names().size(); ++link) {
    const auto& [digit, segment] = coordinates.parts()[link];
    names.push_back(digit.empty() ? parts.names()[link] : hand::partName(digit, segment));
  }
  return names;
}

/// Gives a patch on `mesh_O` its place on the hand and its direction towards the wrist; returns
/// how far from its root that place is (m), infinite where none looks at it.
double findPlace(const PosedHand& posed,
                 const geometry::TriangleMesh& mesh_O,
                 const std::vector<char>& links,
                 contact::Patch& patch) {
  const hand::Skin& skin = *posed.hand.skin;
  const Eigen::Vector3d n_O = geometry::normalOf(mesh_O, patch.root);
  const auto root_S = placement::rootShownBy(posed.skin_faces, posed.X_SO, links,
                                             geometry::positionOf(mesh_O, patch.root), n_O);
  if (!root_S) return std::numeric_limits<double>::infinity();
  patch.place = posed.coordinates.placeOf(*root_S);
  const int link = skin.faceLinks()[static_cast<std::size_t>(root_S->face)];
  const auto L = static_cast<std::size_t>(link);
  const Pose X_OS = inverse(posed.X_SO[L]);
  std::optional<Eigen::Vector3d> direction_O;
  if (const auto direction_S = posed.coordinates.towardsWrist(*root_S)) {
    direction_O = X_OS.linear() * *direction_S;
  } else if (const Pose& X_OL = posed.X_OL[L]; const auto d_L = posed.parts.towardsWrist(
                                                   link, -(X_OL.linear().transpose() * n_O))) {
    direction_O = X_OL.linear() * *d_L;
  }
  if (direction_O) patch.direction_O = tangentAt(mesh_O, patch.root, *direction_O);
  const Eigen::Vector3d p_O = X_OS * geometry::positionOf(skin.mesh(), *root_S);
  return (p_O - geometry::positionOf(mesh_O, patch.root)).norm();
}

/// Takes patches out that the hand's surface is too far from: an object's far side, felt
/// through a wall or beyond an edge. The last patch of a digit stays.
void dropUnmet(const std::vector<double>& away_m,
               double reach_m,
               std::map<std::string, int>& patches_of_digit,
               contact::ContactSet& set) {
  std::vector<contact::Patch> kept;
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    contact::Patch& patch = set.patches[i];
    const auto place = hand::placeNamed(patch.name);
    int& left = patches_of_digit[place ? place->digit : patch.name];
    if (away_m[i] <= reach_m || left == 1) {
      kept.push_back(std::move(patch));
      continue;
    }
    --left;
    set.notes.push_back(
        std::isfinite(away_m[i])
            ? fmt::format("{} dropped: what of the hand looks at it is {:.0f} mm away",
                          quoted(patch.name), 1e3 * away_m[i])
            : fmt::format("{} dropped: nothing of the hand looks at it", quoted(patch.name)));
  }
  set.patches = std::move(kept);
}

/// Of each digit, all of its segments together, in contact above the threshold; m^2.
std::map<std::string, double> touchedAreas(const contact::ContactMap& map,
                                           const contact::SegmentationOptions& segmentation) {
  const double threshold = contact::thresholdOf(map, segmentation);
  const Eigen::VectorXd areas = contact::vertexAreas(map.mesh_O);
  std::map<std::string, double> touched;
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    const int label = map.label[static_cast<std::size_t>(v)];
    if (label < 0 || !(map.value[v] > threshold)) continue;
    const std::string& part = map.segment_parts[static_cast<std::size_t>(label)];
    const auto place = hand::placeNamed(part);
    touched[place ? place->digit : part] += areas[v];
  }
  return touched;
}

/// Which digits touch nothing, and which too little for a patch.
std::vector<std::string> notesOnIdle(const std::vector<std::string>& idle,
                                     const contact::ContactMap& map,
                                     const contact::SegmentationOptions& segmentation) {
  constexpr double kSquareMillimetres = 1e6;
  if (idle.empty()) return {};
  const std::map<std::string, double> touched = touchedAreas(map, segmentation);
  std::vector<std::string> notes;
  std::vector<std::string> apart;
  for (const std::string& digit : idle) {
    const auto area = touched.find(digit);
    if (area == touched.end()) {
      apart.push_back(digit);
      continue;
    }
    notes.push_back(fmt::format(
        "{} touches too little: {:.1f} mm2 in all; a patch has {:.1f} mm2 in one piece at "
        "least",
        quoted(digit), kSquareMillimetres * area->second,
        kSquareMillimetres * segmentation.minimum_area_m2));
  }
  if (!apart.empty())
    notes.push_back(fmt::format("touches nothing: {}", fmt::join(apart, ", ")));
  return notes;
}

std::vector<int> linksWithSurface(const hand::HandModel& model) {
  std::vector<int> links;
  for (int i = 0; i < model.linkCount(); ++i)
    if (!model.links()[static_cast<std::size_t>(i)].surface().empty()) links.push_back(i);
  return links;
}

/// All of a link's shapes, seen from where it is at `X`.
geometry::TriangleMesh surfaceOf(const hand::HandModel& model,
                                 int link,
                                 const Eigen::Affine3d& X) {
  std::vector<geometry::TriangleMesh> shapes;
  for (const hand::Shape& shape : model.links()[static_cast<std::size_t>(link)].surface())
    shapes.push_back(geometry::transformed(shape.mesh_L, X));
  return geometry::merged(shapes);
}

}  // namespace

std::vector<contact::PosedSurface> posedSurfaces(const hand::HandModel& model,
                                                 const hand::HandPose& pose,
                                                 const Pose& X_WO) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, pose);
  const Pose X_OW = X_WO.inverse();
  std::vector<contact::PosedSurface> parts;
  for (const int link : linksWithSurface(model)) {
    const Pose X_OL = X_OW * X_WL[static_cast<std::size_t>(link)];
    parts.push_back({model.links()[static_cast<std::size_t>(link)].name,
                     surfaceOf(model, link, Eigen::Affine3d(Eigen::Isometry3d(X_OL)))});
  }
  return parts;
}

ContactCutter::ContactCutter(const hand::Hand& hand,
                             const geometry::TriangleMesh& object_O,
                             const contact::PoseContactOptions& reach)
    : hand_(hand),
      object_O_(object_O),
      reach_(reach),
      coordinates_(*hand.model, *hand.skin, hand.sites),
      parts_(*hand.model, hand.sites),
      skin_faces_(*hand.skin),
      part_of_link_(partsOf(coordinates_, parts_)),
      surface_links_(linksWithSurface(*hand.model)),
      refined_O_(contact::refineEdges(object_O, reach.longest_edge_m)) {
  surfaces_.reserve(surface_links_.size());
  for (const int link : surface_links_)
    surfaces_.emplace_back(hand.model->links()[static_cast<std::size_t>(link)].name,
                           surfaceOf(*hand.model, link, Eigen::Affine3d::Identity()));
}

PosedContacts ContactCutter::at(const hand::HandPose& pose,
                                const Pose& X_WO,
                                const contact::SegmentationOptions& segmentation,
                                const Progress& progress) const {
  const hand::HandModel& model = *hand_.model;
  const hand::HandPose pose_O{X_WO.inverse() * pose.X_WH, pose.q};
  const PosedHand posed{hand_,
                        coordinates_,
                        parts_,
                        skin_faces_,
                        forwardKinematics(model, pose_O),
                        hand_.skin->fromWorld(model, pose_O)};

  // === The map, and its patches by segments
  std::vector<Pose> X_OL;
  for (const int link : surface_links_)
    X_OL.push_back(posed.X_OL[static_cast<std::size_t>(link)]);
  PosedContacts result;
  contact::ContactMap& map = result.map;
  map = contact::contactsOnVertices(refined_O_, surfaces_, X_OL, reach_, progress);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const std::string& part = part_of_link_[static_cast<std::size_t>(surface_links_[i])];
    map.segment_parts.push_back(part.empty() ? contact::fingerOfSegment(surfaces_[i].name())
                                             : part);
  }
  result.set = contact::segment(map, segmentation);
  result.set.posture = shownPosture(turnedParts(coordinates_.anatomy()), posed.X_SO);
  result.set.side = sideOf(posed.coordinates.anatomy());

  // === Where on the hand each of them was
  std::map<std::string, int> patches_of_digit;
  std::vector<double> away_m;
  for (contact::Patch& patch : result.set.patches) {
    const auto place = hand::placeNamed(patch.name);
    const std::string part = place ? hand::partName(place->digit, place->segment) : patch.name;
    std::vector<char> links;
    links.reserve(part_of_link_.size());
    for (const std::string& one : part_of_link_)
      links.push_back(one == part ? 1 : 0);
    away_m.push_back(findPlace(posed, map.mesh_O, links, patch));
    ++patches_of_digit[place ? place->digit : patch.name];
  }
  dropUnmet(away_m, reach_.reach_m, patches_of_digit, result.set);
  std::vector<std::string> idle;
  for (const hand::NamedDigit& digit : coordinates_.anatomy().digits)
    if (!patches_of_digit.contains(digit.name)) idle.push_back(digit.name);
  for (const std::string& note : notesOnIdle(idle, map, segmentation))
    result.set.notes.push_back(note);

  const bool is_refined = map.mesh_O.vertexCount() != object_O_.vertexCount() ||
                          map.mesh_O.faces() != object_O_.faces();
  if (is_refined) result.set = contact::reproject(result.set, map.mesh_O, object_O_);
  return result;
}

PosedContacts contactsOfPosedHand(const hand::Hand& hand,
                                  const hand::HandPose& pose,
                                  const geometry::TriangleMesh& object_O,
                                  const Pose& X_WO,
                                  const contact::PoseContactOptions& reach,
                                  const contact::SegmentationOptions& segmentation,
                                  const Progress& progress) {
  HANDGRAFT_REQUIRE(hand.model != nullptr && hand.skin != nullptr);
  return ContactCutter(hand, object_O, reach).at(pose, X_WO, segmentation, progress);
}

}  // namespace handgraft::demonstration
