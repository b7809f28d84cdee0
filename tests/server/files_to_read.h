#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/error.h"
#include "server/reading/read_model.h"

#include "tests/server/small_grasp.h"
#include "tests/support/shared_data.h"

/// Small files, and requests to read them.
namespace handgraft::server::files {

inline std::filesystem::path written(const std::string& name, const std::string& text) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// A PLY of a ball with contact near its top, `points_alone` or with faces; lengths times
/// `scale`.
inline std::string ballPly(double radius,
                           double scale,
                           bool points_alone = false,
                           double top = 0.5) {
  const geometry::TriangleMesh ball = geometry::makeSphere(radius, 3);
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nproperty double contact\n",
      ball.vertexCount());
  if (!points_alone)
    text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                        ball.faceCount());
  text += "end_header\n";
  for (int v = 0; v < ball.vertexCount(); ++v) {
    const Eigen::Vector3d p = ball.vertex(v);
    text += fmt::format("{} {} {} {}\n", scale * p.x(), scale * p.y(), scale * p.z(),
                        p.z() > top * radius ? 1.0 : 0.0);
  }
  for (int f = 0; f < ball.faceCount() && !points_alone; ++f)
    text += fmt::format("3 {} {} {}\n", ball.face(f)[0], ball.face(f)[1], ball.face(f)[2]);
  return text;
}

inline ReadRequest requestFor(ReadKind kind, const std::filesystem::path& path) {
  ReadRequest request;
  request.kind = kind;
  request.name = path.stem().string();
  request.main_uri = path.filename().string();
  request.files[request.main_uri] = path;
  return request;
}

inline ReadRequest clampRequest() {
  ReadRequest request = requestFor(ReadKind::kHand, written("clamp.urdf", test::clamp_urdf));
  request.files["sites.yaml"] = written("sites.yaml", test::clamp_sites);
  request.files["clamp.srdf"] = written("clamp.srdf", R"(<robot name="clamp">
    <group_state name="open" group="g"><joint name="hinge" value="-0.4"/></group_state>
    <group_state name="shut" group="g"><joint name="hinge" value="1.1"/></group_state>
    </robot>)");
  return request;
}

inline io::MeshFile objectOf(const ReadRequest& request) {
  return std::get<io::MeshFile>(readModel(request, Progress()));
}

/// Contacts in `map`, on the object in `object`.
inline ReadRequest mapRequest(const std::filesystem::path& map, const ReadRequest& object) {
  ReadRequest request = requestFor(ReadKind::kContacts, map);
  request.contacts.object = std::make_shared<const io::MeshFile>(objectOf(object));
  request.contacts.object_units = object.units;
  return request;
}

inline ReadContacts contactsOf(const ReadRequest& request) {
  return std::get<ReadContacts>(readModel(request, Progress()));
}

inline std::string faultOf(const ReadRequest& request) {
  try {
    (void)readModel(request, Progress());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace handgraft::server::files
