#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"
#include "core/hand/named_pose.h"
#include "core/io/mesh_file.h"
#include "server/reading/byte_stream.h"

/// Hands, meshes and lists as bytes and back. What comes back keeps the promises of its
/// type, whatever the bytes were. Errors: InvalidInput.
namespace handgraft::server {

void put(ByteWriter& out, const std::vector<std::string>& texts);
void put(ByteWriter& out, const Eigen::VectorXd& values);
void put(ByteWriter& out, const std::vector<int>& values);
void put(ByteWriter& out, const geometry::TriangleMesh& mesh);
void put(ByteWriter& out, const hand::HandModel& model);
void put(ByteWriter& out, const std::vector<hand::ContactSite>& sites);
void put(ByteWriter& out, const std::vector<hand::NamedPose>& poses);
void put(ByteWriter& out, const io::MeshFile& file);

std::vector<std::string> takeTexts(ByteReader& in);
Eigen::VectorXd takeVector(ByteReader& in, std::size_t most);
std::vector<int> takeInts(ByteReader& in);
geometry::TriangleMesh takeMesh(ByteReader& in);
hand::HandModel takeHandModel(ByteReader& in);
std::vector<hand::ContactSite> takeSites(ByteReader& in, const hand::HandModel& model);
std::vector<hand::NamedPose> takePoses(ByteReader& in, const hand::HandModel& model);
io::MeshFile takeMeshFile(ByteReader& in);

/// Most links, shapes, joints, notes or texts of one list: what files of the permitted sizes
/// can hold, and little enough that a claim of so many takes no memory to speak of.
inline constexpr std::size_t kMostThings = 200'000;
inline constexpr std::size_t kCountSize = sizeof(std::uint64_t);

}  // namespace handgraft::server
