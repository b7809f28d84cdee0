// glTF 2.0, sections 3 (JSON) and 4 (GLB): one buffer, a view each for places and indices of a
// part.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/scene_writer.h"
#include "core/io/trajectory_writer.h"

namespace handgraft::io {

namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "GLB is little-endian");

constexpr int kFloat = 5126;
constexpr int kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kNoTarget = 0;  // of what no shader reads
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;

template <class T>
void append(std::string& bytes, const T* values, std::size_t count) {
  const std::size_t at = bytes.size();
  bytes.resize(at + count * sizeof(T));
  std::memcpy(bytes.data() + at, values, count * sizeof(T));
}

void appendChunk(std::string& file, std::uint32_t type, std::string content, char padding) {
  content.resize((content.size() + 3) / 4 * 4, padding);
  const std::uint32_t head[2] = {static_cast<std::uint32_t>(content.size()), type};
  append(file, head, 2);
  file += content;
}

json listOf(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

class GlbWriter {
 public:
  /// A pose of every part at each time, in the parts' order (`partsOf`).
  struct Movement {
    std::vector<float> time_s;
    std::vector<std::vector<Pose>> X_WP;  ///< of each time
  };

  std::string write(const PosedGrasp& grasp, const Movement& movement = {}) {
    // World: p_gltf = (x, z, -y), a quarter turn about x.
    constexpr double kHalf = 0.70710678118654752;
    json children = json::array();
    nodes_.push_back({{"name", "world"}, {"rotation", {-kHalf, 0.0, 0.0, kHalf}}});
    const std::vector<ScenePart> parts = partsOf(grasp);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].mesh_P.faceCount() == 0) continue;
      children.push_back(nodes_.size());
      addPart(parts[i]);
      if (!movement.time_s.empty()) addMovement(movement, i);
    }
    nodes_[0]["children"] = children;
    json document = {
        {"asset", {{"version", "2.0"}, {"generator", "handgraft"}}},
        {"scene", 0},
        {"scenes", {{{"name", grasp.hand + " at " + grasp.object}, {"nodes", {0}}}}},
        {"nodes", nodes_},
        {"meshes", meshes_},
        {"materials", materials_},
        {"accessors", accessors_},
        {"bufferViews", views_},
        {"buffers", {{{"byteLength", buffer_.size()}}}}};
    if (!movement.time_s.empty()) {
      document["animations"] = {
          {{"name", "motion"}, {"channels", channels_}, {"samplers", samplers_}}};
    }
    std::string chunks;
    appendChunk(chunks, kJsonChunk,
                document.dump(-1, ' ', false, json::error_handler_t::replace), ' ');
    appendChunk(chunks, kBinaryChunk, buffer_, '\0');
    std::string file = "glTF";
    const std::uint32_t head[2] = {2, static_cast<std::uint32_t>(12 + chunks.size())};
    append(file, head, 2);
    return file + chunks;
  }

 private:
  void addPart(const ScenePart& part) {
    const Eigen::Matrix3Xf vertices = part.mesh_P.vertices().cast<float>();
    const Eigen::Matrix<std::uint32_t, 3, Eigen::Dynamic> faces =
        part.mesh_P.faces().cast<std::uint32_t>();
    const json positions = {
        {"bufferView", addView(vertices.data(), vertices.size(), kArrayBuffer)},
        {"componentType", kFloat},
        {"count", vertices.cols()},
        {"type", "VEC3"},
        {"min", listOf(vertices.rowwise().minCoeff())},
        {"max", listOf(vertices.rowwise().maxCoeff())}};
    const json corners = {
        {"bufferView", addView(faces.data(), faces.size(), kElementArrayBuffer)},
        {"componentType", kUnsignedInt},
        {"count", faces.size()},
        {"type", "SCALAR"}};
    const std::size_t first = accessors_.size();
    accessors_.push_back(positions);
    accessors_.push_back(corners);

    const Eigen::Vector3d p = part.X_WP.translation();
    const Eigen::Vector4d q = quaternionOf(part.X_WP);
    nodes_.push_back({{"name", part.name},
                      {"mesh", meshes_.size()},
                      {"translation", {p.x(), p.y(), p.z()}},
                      {"rotation", {q[1], q[2], q[3], q[0]}}});
    meshes_.push_back({{"name", part.name},
                       {"primitives",
                        {{{"attributes", {{"POSITION", first}}},
                          {"indices", first + 1},
                          {"material", materialOf(part.color)}}}}});
  }

  /// Moves the last node as the part moves.
  void addMovement(const Movement& movement, std::size_t part) {
    if (!times_) {
      const auto [first, last] =
          std::minmax_element(movement.time_s.begin(), movement.time_s.end());
      times_ = accessors_.size();
      accessors_.push_back(
          {{"bufferView",
            addView(movement.time_s.data(), static_cast<Eigen::Index>(movement.time_s.size()),
                    kNoTarget)},
           {"componentType", kFloat},
           {"count", movement.time_s.size()},
           {"type", "SCALAR"},
           {"min", {*first}},
           {"max", {*last}}});
    }
    std::vector<float> places;
    std::vector<float> turns;
    Eigen::Vector4d before = Eigen::Vector4d::Zero();
    for (const std::vector<Pose>& X_WP : movement.X_WP) {
      const Eigen::Vector3f p = X_WP[part].translation().cast<float>();
      Eigen::Vector4d q = quaternionOf(X_WP[part]);
      if (q.dot(before) < 0.0) q = -q;  // the short way between two frames
      before = q;
      places.insert(places.end(), p.data(), p.data() + 3);
      for (const int i : {1, 2, 3, 0})
        turns.push_back(static_cast<float>(q[i]));
    }
    addChannel("translation", "VEC3", places, movement.time_s.size());
    addChannel("rotation", "VEC4", turns, movement.time_s.size());
  }

  void addChannel(const char* path,
                  const char* type,
                  const std::vector<float>& values,
                  std::size_t count) {
    const std::size_t view =
        addView(values.data(), static_cast<Eigen::Index>(values.size()), kNoTarget);
    channels_.push_back({{"sampler", samplers_.size()},
                         {"target", {{"node", nodes_.size() - 1}, {"path", path}}}});
    samplers_.push_back({{"input", *times_}, {"output", accessors_.size()}});
    accessors_.push_back(
        {{"bufferView", view}, {"componentType", kFloat}, {"count", count}, {"type", type}});
  }

  template <class T>
  std::size_t addView(const T* values, Eigen::Index count, int target) {
    views_.push_back({{"buffer", 0},
                      {"byteOffset", buffer_.size()},
                      {"byteLength", static_cast<std::size_t>(count) * sizeof(T)}});
    if (target != kNoTarget) views_.back()["target"] = target;
    append(buffer_, values, static_cast<std::size_t>(count));
    return views_.size() - 1;
  }

  std::size_t materialOf(const std::array<float, 3>& color) {
    const json factor = {color[0], color[1], color[2], 1.0};
    for (std::size_t i = 0; i < materials_.size(); ++i) {
      if (materials_[i]["pbrMetallicRoughness"]["baseColorFactor"] == factor) return i;
    }
    materials_.push_back(
        {{"pbrMetallicRoughness",
          {{"baseColorFactor", factor}, {"metallicFactor", 0.0}, {"roughnessFactor", 0.8}}},
         {"doubleSided", true}});
    return materials_.size() - 1;
  }

  std::string buffer_;
  json nodes_ = json::array();
  json meshes_ = json::array();
  json materials_ = json::array();
  json accessors_ = json::array();
  json views_ = json::array();
  json channels_ = json::array();
  json samplers_ = json::array();
  std::optional<std::size_t> times_;  ///< the accessor of all channels' times
};

}  // namespace

std::string glbBytes(const PosedGrasp& grasp) {
  return GlbWriter().write(grasp);
}

std::string trajectoryGlb(const HandTrajectory& trajectory) {
  const TrajectoryFrame& first = trajectory.frames.front();
  PosedGrasp grasp{trajectory.hand,     trajectory.object, trajectory.model,
                   trajectory.object_O, first.pose_W,      first.X_WO};
  GlbWriter::Movement movement;
  for (std::size_t k = 0; k < trajectory.frames.size(); ++k) {
    const TrajectoryFrame& frame = trajectory.frames[k];
    movement.time_s.push_back(static_cast<float>(frame.time_s - first.time_s));
    grasp.X_WO = frame.X_WO;
    grasp.pose = frame.pose_W;
    movement.X_WP.push_back(partPoses(grasp));
    if (k == 0) continue;
    // glTF's times must rise in single precision, too.
    movement.time_s[k] =
        std::max(movement.time_s[k],
                 std::nextafter(movement.time_s[k - 1], std::numeric_limits<float>::max()));
  }
  grasp.X_WO = first.X_WO;
  grasp.pose = first.pose_W;
  return GlbWriter().write(grasp, movement);
}

}  // namespace handgraft::io
