#include "server/reading/packed_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"
#include "core/io/srdf_file.h"
#include "server/reading/read_model.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostVertices = io::kMostVertices;
constexpr std::size_t kMostFaces = 2 * kMostVertices;
constexpr std::size_t kSize = sizeof(std::uint64_t);  ///< of a count

Eigen::Vector3d takePoint(ByteReader& in) {
  Eigen::Vector3d p;
  for (double& coordinate : p)
    coordinate = in.finite();
  return p;
}

void requireAll(bool fine, const char* what) {
  if (!fine) rejectInput("what the reader sent is damaged: {}", what);
}

// === Hands

void put(ByteWriter& out, const std::vector<hand::Shape>& shapes) {
  out.count(shapes.size());
  for (const hand::Shape& shape : shapes) {
    put(out, shape.mesh_L);
    out.text(shape.source);
  }
}

std::vector<hand::Shape> takeShapes(ByteReader& in) {
  std::vector<hand::Shape> shapes(in.count(kMostThings, 3 * kSize));
  for (hand::Shape& shape : shapes) {
    shape.mesh_L = takeMesh(in);
    shape.source = in.text();
  }
  return shapes;
}

void put(ByteWriter& out, const hand::Joint& joint) {
  out.text(joint.name);
  out.number(static_cast<std::uint8_t>(joint.type));
  out.text(joint.parent_link);
  out.text(joint.child_link);
  const Eigen::Matrix<double, 3, 4> X_PJ = joint.X_PJ.matrix().topRows<3>();
  out.numbers(X_PJ.data(), 12);
  out.numbers(joint.axis_J.data(), 3);
  for (const hand::JointNumber& number : hand::kJointNumbers)
    out.number(joint.*number.value);
  out.number(static_cast<std::uint8_t>(joint.mimic.has_value()));
  if (!joint.mimic) return;
  out.text(joint.mimic->source_joint);
  out.number(joint.mimic->multiplier);
  out.number(joint.mimic->offset);
}

/// Its numbers are checked by HandModel.
hand::Joint takeJoint(ByteReader& in) {
  hand::Joint joint;
  joint.name = in.text();
  joint.type = in.one(hand::JointType::kPrismatic);
  joint.parent_link = in.text();
  joint.child_link = in.text();
  Eigen::Matrix<double, 3, 4> X_PJ;
  in.numbers(X_PJ.data(), 12);
  joint.X_PJ.matrix().topRows<3>() = X_PJ;
  in.numbers(joint.axis_J.data(), 3);
  for (const hand::JointNumber& number : hand::kJointNumbers)
    joint.*number.value = in.number<double>();
  if (!in.flag()) return joint;
  hand::Mimic mimic;
  mimic.source_joint = in.text();
  mimic.multiplier = in.finite();
  mimic.offset = in.finite();
  joint.mimic = std::move(mimic);
  return joint;
}

// === Contacts

void put(ByteWriter& out, hand::Chirality side) {
  out.number(static_cast<std::uint8_t>(side));
}

hand::Chirality takeSide(ByteReader& in) {
  return in.form() < 2 ? hand::Chirality::kUnknown : in.one(hand::Chirality::kLeft);
}

bool isUnitOrZero(const Eigen::Vector3d& v) {
  return v.isZero() || std::abs(v.norm() - 1.0) < 1e-6;
}

void put(ByteWriter& out, const geometry::SurfacePoint& point) {
  out.number(point.face);
  out.numbers(point.barycentric.data(), 3);
}

geometry::SurfacePoint takeSurfacePoint(ByteReader& in) {
  geometry::SurfacePoint point;
  point.face = in.number<int>();
  in.numbers(point.barycentric.data(), 3);
  return point;
}

void put(ByteWriter& out, const contact::Patch& patch) {
  out.text(patch.name);
  put(out, patch.root);
  out.number(static_cast<std::uint8_t>(patch.direction_O.has_value()));
  if (patch.direction_O) out.numbers(patch.direction_O->data(), 3);
  put(out, patch.boundary);
  out.count(patch.interpolation_boundary.size());
  for (const geometry::SurfacePoint& point : patch.interpolation_boundary)
    put(out, point);
  out.number(patch.weight);
  out.number(static_cast<std::uint8_t>(patch.place.has_value()));
  if (!patch.place) return;
  out.text(patch.place->digit);
  out.text(patch.place->segment);
  out.number(static_cast<std::int32_t>(patch.place->segment_count));
  for (const double number : {patch.place->along, patch.place->around_rad, patch.place->across,
                              patch.place->from_tip})
    out.number(number);
}

/// All else is checked by contact::validate.
contact::Patch takePatch(ByteReader& in) {
  contact::Patch patch;
  patch.name = in.text();
  patch.root = takeSurfacePoint(in);
  if (in.flag()) patch.direction_O = takePoint(in);
  patch.boundary = takeInts(in);
  patch.interpolation_boundary.resize(
      in.count(contact::kMostPoints, sizeof(int) + 3 * sizeof(double)));
  for (geometry::SurfacePoint& point : patch.interpolation_boundary)
    point = takeSurfacePoint(in);
  patch.weight = in.finite();
  if (!in.flag()) return patch;
  hand::HandLocation& place = patch.place.emplace();
  place.digit = in.text();
  place.segment = in.text();
  place.segment_count = in.number<std::int32_t>();
  place.along = in.finite();
  place.around_rad = in.finite();
  place.across = in.finite();
  place.from_tip = in.finite();
  return patch;
}

}  // namespace

// === Lists

void put(ByteWriter& out, const std::vector<std::string>& texts) {
  out.count(texts.size());
  for (const std::string& text : texts)
    out.text(text);
}

std::vector<std::string> takeTexts(ByteReader& in) {
  std::vector<std::string> texts(in.count(kMostThings, kSize));
  for (std::string& text : texts)
    text = in.text();
  return texts;
}

void put(ByteWriter& out, const Eigen::VectorXd& values) {
  out.count(static_cast<std::size_t>(values.size()));
  out.numbers(values.data(), static_cast<std::size_t>(values.size()));
}

Eigen::VectorXd takeVector(ByteReader& in, std::size_t most) {
  const std::size_t size = in.count(most, sizeof(double));
  Eigen::VectorXd values(static_cast<Eigen::Index>(size));
  in.numbers(values.data(), size);
  requireAll(values.allFinite(), "a number not finite");
  return values;
}

void put(ByteWriter& out, const std::vector<int>& values) {
  out.count(values.size());
  out.numbers(values.data(), values.size());
}

std::vector<int> takeInts(ByteReader& in) {
  std::vector<int> values(in.count(3 * kMostFaces, sizeof(int)));
  in.numbers(values.data(), values.size());
  return values;
}

// === Meshes

void put(ByteWriter& out, const geometry::TriangleMesh& mesh) {
  out.columns(mesh.vertices());
  out.columns(mesh.faces());
}

geometry::TriangleMesh takeMesh(ByteReader& in) {
  auto vertices = in.columns<Eigen::Matrix3Xd>(kMostVertices);
  auto faces = in.columns<Eigen::Matrix3Xi>(kMostFaces);
  return {std::move(vertices), std::move(faces)};
}

void put(ByteWriter& out, const io::MeshFile& file) {
  put(out, file.mesh);
  put(out, file.file_vertex);
  put(out, file.mesh_vertex);
  put(out, file.file_face);
  put(out, std::vector<int>(file.is_turned.begin(), file.is_turned.end()));
  put(out, file.notes);
  out.columns(file.cloud_O);
}

io::MeshFile takeMeshFile(ByteReader& in) {
  io::MeshFile file;
  file.mesh = takeMesh(in);
  file.file_vertex = takeInts(in);
  file.mesh_vertex = takeInts(in);
  file.file_face = takeInts(in);
  const std::vector<int> turned = in.form() < 2 ? std::vector<int>() : takeInts(in);
  file.notes = takeTexts(in);
  file.cloud_O = in.columns<Eigen::Matrix3Xd>(kMostVertices);
  requireAll(file.mesh.faceCount() > 0, "a mesh without faces");
  requireAll(file.cloud_O.allFinite(), "a point not finite");
  const auto all_in = [](const std::vector<int>& indices, int least, std::ptrdiff_t end) {
    return std::all_of(indices.begin(), indices.end(), [&](int index) {
      return index >= least && index < end;
    });
  };
  if (file.cloud_O.cols() > 0) {
    requireAll(file.file_vertex.empty() && file.mesh_vertex.empty() && file.file_face.empty() &&
                   turned.empty(),
               "indices of a point cloud");
    return file;
  }
  requireAll(std::ssize(file.file_vertex) == file.mesh.vertexCount() &&
                 std::ssize(file.file_face) == file.mesh.faceCount(),
             "a list of indices of another length than its mesh");
  requireAll(
      (turned.empty() || std::ssize(turned) == file.mesh.faceCount()) && all_in(turned, 0, 2),
      "turned faces that are not the mesh's");
  file.is_turned.assign(turned.begin(), turned.end());
  requireAll(all_in(file.file_vertex, 0, std::ssize(file.mesh_vertex)) &&
                 all_in(file.mesh_vertex, -1, file.mesh.vertexCount()) &&
                 all_in(file.file_face, 0, std::numeric_limits<int>::max()),
             "an index out of range");
  return file;
}

// === Hands

void put(ByteWriter& out, const hand::HandModel& model) {
  out.text(model.name());
  out.count(model.links().size());
  for (const hand::Link& link : model.links()) {
    out.text(link.name);
    put(out, link.visuals);
    put(out, link.collisions);
  }
  out.count(model.joints().size());
  for (const hand::Joint& joint : model.joints())
    put(out, joint);
  put(out, model.restPose());
  out.number(static_cast<std::uint8_t>(model.isMirror()));
}

hand::HandModel takeHandModel(ByteReader& in) {
  const std::string name = in.text();
  std::vector<hand::Link> links(in.count(kMostThings, 3 * kSize));
  std::size_t shapes = 0;
  for (hand::Link& link : links) {
    link.name = in.text();
    link.visuals = takeShapes(in);
    link.collisions = takeShapes(in);
    shapes += link.visuals.size() + link.collisions.size();
    requireAll(shapes <= kMostThings, "too many shapes");
  }
  std::vector<hand::Joint> joints(in.count(kMostThings, 18 * sizeof(double)));
  for (hand::Joint& joint : joints)
    joint = takeJoint(in);
  hand::HandModel model(name, std::move(links), std::move(joints));
  requireAll(model.dofCount() <= kMostJoints, "too many joints");
  const Eigen::VectorXd rest = takeVector(in, kMostJoints);
  const bool is_zero = rest.size() == model.dofCount() && rest == model.restPose();
  if (!is_zero) model = model.withRestPose(rest);
  return model.asMirror(in.flag());
}

void put(ByteWriter& out, const std::vector<hand::ContactSite>& sites) {
  out.count(sites.size());
  for (const hand::ContactSite& site : sites) {
    out.text(site.name);
    out.text(site.link);
    out.numbers(site.p_L.data(), 3);
    out.numbers(site.n_L.data(), 3);
    out.numbers(site.direction_L.data(), 3);
  }
}

std::vector<hand::ContactSite> takeSites(ByteReader& in, const hand::HandModel& model) {
  std::vector<hand::ContactSite> sites(in.count(kMostThings, 2 * kSize + 9 * sizeof(double)));
  for (hand::ContactSite& site : sites) {
    site.name = in.text();
    site.link = in.text();
    site.p_L = takePoint(in);
    site.n_L = takePoint(in);
    site.direction_L = takePoint(in);
  }
  hand::validate(model, sites);
  return sites;
}

void put(ByteWriter& out, const std::vector<hand::NamedPose>& poses) {
  out.count(poses.size());
  for (const hand::NamedPose& pose : poses) {
    out.text(pose.name);
    put(out, pose.q);
  }
}

std::vector<hand::NamedPose> takePoses(ByteReader& in, const hand::HandModel& model) {
  std::vector<hand::NamedPose> poses(in.count(io::kMostNamedPoses, 2 * kSize));
  for (hand::NamedPose& pose : poses) {
    pose.name = in.text();
    pose.q = takeVector(in, kMostJoints);
    requireAll(pose.q.size() == model.dofCount() &&
                   (pose.q.array() >= model.lower().array()).all() &&
                   (pose.q.array() <= model.upper().array()).all(),
               "a named pose beyond the joints or their limits");
  }
  return poses;
}

// === Contacts

void put(ByteWriter& out, const std::vector<contact::PartDirection>& posture) {
  out.count(posture.size());
  for (const contact::PartDirection& part : posture) {
    out.text(part.part);
    out.numbers(part.outward_O.data(), 3);
    out.numbers(part.palmar_O.data(), 3);
  }
}

std::vector<contact::PartDirection> takePosture(ByteReader& in) {
  std::vector<contact::PartDirection> posture(
      in.count(contact::kMostParts, 6 * sizeof(double)));
  for (contact::PartDirection& part : posture) {
    part.part = in.text();
    in.numbers(part.outward_O.data(), 3);
    in.numbers(part.palmar_O.data(), 3);
    requireAll(
        isUnitOrZero(part.outward_O) && !part.outward_O.isZero() && isUnitOrZero(part.palmar_O),
        "a posture's direction without unit length");
  }
  return posture;
}

void put(ByteWriter& out, const contact::ContactSet& set) {
  out.text(set.name);
  out.text(set.object);
  put(out, set.side);
  out.count(set.patches.size());
  for (const contact::Patch& patch : set.patches)
    put(out, patch);
  put(out, set.posture);
  put(out, set.notes);
}

contact::ContactSet takeContactSet(ByteReader& in, const geometry::TriangleMesh& mesh_O) {
  contact::ContactSet set;
  set.name = in.text();
  set.object = in.text();
  set.side = takeSide(in);
  set.patches.resize(in.count(contact::kMostPatches, 4 * kSize));
  requireAll(!set.patches.empty(), "a contact set without patches");
  std::set<std::string> names;
  std::size_t points = 0;
  for (contact::Patch& patch : set.patches) {
    patch = takePatch(in);
    contact::validate(mesh_O, patch);
    points += patch.interpolation_boundary.size();
    requireAll(points <= contact::kMostPoints, "too many points");
    requireAll(names.insert(patch.name).second, "two patches of one name");
  }
  set.posture = takePosture(in);
  set.notes = takeTexts(in);
  return set;
}

void put(ByteWriter& out, const contact::ContactMap& map) {
  put(out, map.mesh_O);
  put(out, map.value);
  put(out, map.label);
  put(out, map.segment_names);
  put(out, map.segment_parts);
}

contact::ContactMap takeContactMap(ByteReader& in) {
  contact::ContactMap map;
  map.mesh_O = takeMesh(in);
  map.value = takeVector(in, kMostVertices);
  map.label = takeInts(in);
  map.segment_names = takeTexts(in);
  map.segment_parts = takeTexts(in);
  contact::validate(map);
  requireAll(map.mesh_O.faceCount() > 0, "a map without faces");
  return map;
}

// === Motions

void put(ByteWriter& out, const Pose& X) {
  const Eigen::Matrix<double, 3, 4> rows = X.matrix().topRows<3>();
  out.numbers(rows.data(), 12);
}

Pose takeRows(ByteReader& in) {
  Eigen::Matrix<double, 3, 4> rows;
  in.numbers(rows.data(), 12);
  Pose X = Pose::Identity();
  X.matrix().topRows<3>() = rows;
  return X;
}

void put(ByteWriter& out, const manipulation::Motion& motion) {
  out.text(motion.name);
  out.text(motion.object);
  put(out, motion.side);
  out.text(motion.hand);
  out.count(motion.time_s.size());
  out.numbers(motion.time_s.data(), motion.time_s.size());
  for (const Pose& X : motion.X_WO)
    put(out, X);
  out.count(motion.tracks.size());
  for (const manipulation::PatchTrack& track : motion.tracks) {
    out.text(track.name);
    out.number(static_cast<std::int32_t>(track.end));
    out.count(track.keys.size());
    for (const manipulation::PatchKey& key : track.keys) {
      out.number(static_cast<std::int32_t>(key.frame));
      put(out, key.patch);
      out.count(key.hand_points.size());
      for (const manipulation::HandPoint& point : key.hand_points) {
        out.text(point.link);
        out.numbers(point.p_L.data(), 3);
      }
    }
  }
  out.count(motion.demonstrator.size());
  for (const manipulation::DemonstratorKey& key : motion.demonstrator) {
    out.number(static_cast<std::int32_t>(key.frame));
    put(out, key.X_OD);
    put(out, key.posture);
  }
  put(out, motion.notes);
}

manipulation::Motion takeMotion(ByteReader& in, const geometry::TriangleMesh& mesh_O) {
  manipulation::Motion motion;
  motion.name = in.text();
  motion.object = in.text();
  motion.side = takeSide(in);
  motion.hand = in.text();
  motion.time_s.resize(in.count(manipulation::kMostFrames, 13 * sizeof(double)));
  in.numbers(motion.time_s.data(), motion.time_s.size());
  for (std::size_t k = 0; k < motion.time_s.size(); ++k)
    motion.X_WO.push_back(takeRows(in));
  motion.tracks.resize(in.count(manipulation::kMostKeys, 2 * kSize));
  for (manipulation::PatchTrack& track : motion.tracks) {
    track.name = in.text();
    track.end = in.number<std::int32_t>();
    track.keys.resize(in.count(manipulation::kMostKeys, 4 * kSize));
    for (manipulation::PatchKey& key : track.keys) {
      key.frame = in.number<std::int32_t>();
      requireAll(key.frame >= 0, "a key before the first frame");
      key.patch = takePatch(in);
      key.hand_points.resize(in.count(contact::kMostPoints, 4 * sizeof(double)));
      for (manipulation::HandPoint& point : key.hand_points) {
        point.link = in.text();
        point.p_L = takePoint(in);
      }
    }
  }
  if (in.form() > 2) {
    motion.demonstrator.resize(in.count(manipulation::kMostFrames, 13 * sizeof(double)));
    for (manipulation::DemonstratorKey& key : motion.demonstrator) {
      key.frame = in.number<std::int32_t>();
      key.X_OD = takeRows(in);
      key.posture = takePosture(in);
    }
  }
  motion.notes = takeTexts(in);
  manipulation::validate(mesh_O, motion);
  return motion;
}

}  // namespace handgraft::server
