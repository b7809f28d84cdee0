#include "server/reading/packed_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"
#include "core/io/srdf_file.h"
#include "server/reading/read_model.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostVertices = io::kMostVertices;
constexpr std::size_t kMostFaces = 2 * kMostVertices;

// === Hands

void put(ByteWriter& out, const std::vector<hand::Shape>& shapes) {
  out.count(shapes.size());
  for (const hand::Shape& shape : shapes) {
    put(out, shape.mesh_L);
    out.text(shape.source);
  }
}

std::vector<hand::Shape> takeShapes(ByteReader& in) {
  std::vector<hand::Shape> shapes(in.count(kMostThings, 3 * kCountSize));
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

}  // namespace

// === Lists

void put(ByteWriter& out, const std::vector<std::string>& texts) {
  out.count(texts.size());
  for (const std::string& text : texts)
    out.text(text);
}

std::vector<std::string> takeTexts(ByteReader& in) {
  std::vector<std::string> texts(in.count(kMostThings, kCountSize));
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
  in.require(values.allFinite(), "a number not finite");
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
  in.require(file.mesh.faceCount() > 0, "a mesh without faces");
  in.require(file.cloud_O.allFinite(), "a point not finite");
  const auto all_in = [](const std::vector<int>& indices, int least, std::ptrdiff_t end) {
    return std::all_of(indices.begin(), indices.end(), [&](int index) {
      return index >= least && index < end;
    });
  };
  if (file.cloud_O.cols() > 0) {
    in.require(file.file_vertex.empty() && file.mesh_vertex.empty() && file.file_face.empty() &&
                   turned.empty(),
               "indices of a point cloud");
    return file;
  }
  in.require(std::ssize(file.file_vertex) == file.mesh.vertexCount() &&
                 std::ssize(file.file_face) == file.mesh.faceCount(),
             "a list of indices of another length than its mesh");
  in.require(
      (turned.empty() || std::ssize(turned) == file.mesh.faceCount()) && all_in(turned, 0, 2),
      "turned faces that are not the mesh's");
  file.is_turned.assign(turned.begin(), turned.end());
  in.require(all_in(file.file_vertex, 0, std::ssize(file.mesh_vertex)) &&
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
  std::vector<hand::Link> links(in.count(kMostThings, 3 * kCountSize));
  std::size_t shapes = 0;
  for (hand::Link& link : links) {
    link.name = in.text();
    link.visuals = takeShapes(in);
    link.collisions = takeShapes(in);
    shapes += link.visuals.size() + link.collisions.size();
    in.require(shapes <= kMostThings, "too many shapes");
  }
  std::vector<hand::Joint> joints(in.count(kMostThings, 18 * sizeof(double)));
  for (hand::Joint& joint : joints)
    joint = takeJoint(in);
  hand::HandModel model(name, std::move(links), std::move(joints));
  in.require(model.dofCount() <= kMostJoints, "too many joints");
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
  std::vector<hand::ContactSite> sites(
      in.count(kMostThings, 2 * kCountSize + 9 * sizeof(double)));
  for (hand::ContactSite& site : sites) {
    site.name = in.text();
    site.link = in.text();
    site.p_L = in.point();
    site.n_L = in.point();
    site.direction_L = in.point();
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
  std::vector<hand::NamedPose> poses(in.count(io::kMostNamedPoses, 2 * kCountSize));
  for (hand::NamedPose& pose : poses) {
    pose.name = in.text();
    pose.q = takeVector(in, kMostJoints);
    in.require(pose.q.size() == model.dofCount() &&
                   (pose.q.array() >= model.lower().array()).all() &&
                   (pose.q.array() <= model.upper().array()).all(),
               "a named pose beyond the joints or their limits");
  }
  return poses;
}

}  // namespace handgraft::server
