// A contact map and how it is to be cut: 8 bytes of options, 2 that say what follows and onto
// what; then a PLY with values, labels or colours, or the numbers of a small textured mesh with
// the PNG that is painted onto it.

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <zlib.h>

#include "core/base/error.h"
#include "core/io/color_map.h"
#include "core/io/contact_file.h"

#include "tests/fuzz/byte_reader.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_file.h"

namespace {

namespace fs = std::filesystem;
namespace io = handgraft::io;
namespace contact = handgraft::contact;
using handgraft::fuzz::ByteReader;
using handgraft::fuzz::scratchFile;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// Beyond this, one input takes seconds under the sanitizers.
constexpr int kMostVertices = 2000;

template <std::size_t N>
double anyOf(ByteReader& bytes, const double (&values)[N]) {
  const auto choice = bytes.take<std::uint8_t>();
  return values[choice % N];
}

// === Options, good and bad

contact::SegmentationOptions takeOptions(ByteReader& bytes) {
  contact::SegmentationOptions options;
  const auto flags = bytes.take<std::uint8_t>();
  options.threshold =
      anyOf(bytes, {0.4, 0.4, 0.0, 0.5, 0.25, 1.0, -1.0, 1e300, -1e300, kNan, kInfinity});
  options.low_share = anyOf(bytes, {1.0, 1.0, 0.5, 0.9, 1e-300, 0.0, -1.0, 2.0, kNan});
  options.minimum_area_m2 = anyOf(bytes, {2e-5, 0.0, 1e-6, 1e-300, -1.0, kNan, kInfinity});
  options.smoothing_steps =
      static_cast<int>(anyOf(bytes, {0.0, 0.0, 1.0, 3.0, 20.0, -1.0, 1001.0}));
  options.interpolation_count =
      static_cast<int>(anyOf(bytes, {25.0, 25.0, 3.0, 4.0, 1000.0, 2.0, 0.0, -1.0, 10001.0}));
  options.outline_share = anyOf(bytes, {0.75, 0.75, 0.0, 0.5, 0.999, 1e-300, 1.0, -0.1, kNan});
  if ((flags & 1U) != 0) options.rule = contact::ThresholdRule::kOtsu;
  const auto joints = bytes.take<std::uint8_t>();
  if ((flags & 2U) != 0) {
    contact::HandJoints hand;
    for (int i = 0; i < hand.p_O.size(); ++i)
      hand.p_O.data()[i] = std::sin((i + 1.0) * (joints % 32 + 1.0)) * 0.05;
    if (joints / 32 == 5) hand.p_O.setConstant(0.1);
    if (joints / 32 == 6) hand.p_O *= 1e300;
    if (joints / 32 == 7) hand.p_O(joints % 3, joints % 21) = kNan;
    options.joints_O = hand;
  }
  return options;
}

/// What segmentation.h permits, said once more.
bool isPermitted(const contact::SegmentationOptions& options) {
  return std::isfinite(options.threshold) && options.low_share > 0.0 &&
         options.low_share <= 1.0 && options.outline_share >= 0.0 &&
         options.outline_share < 1.0 && options.minimum_area_m2 >= 0.0 &&
         options.smoothing_steps >= 0 && options.smoothing_steps <= 1000 &&
         options.interpolation_count >= 3 && options.interpolation_count <= 10'000 &&
         (!options.joints_O || options.joints_O->p_O.allFinite());
}

// === Files

io::ContactMapSource sourceOf(unsigned kind) {
  io::ContactMapSource source;
  if (kind == 1) source.value_property = "quality";
  if (kind == 2) source.label_property = "segment";
  if (kind >= 3) {
    const std::vector<std::string> scales = io::colorMapNames();
    source.color_scale = scales[(kind - 3) % scales.size()];
  }
  return source;
}

constexpr std::size_t kTexturedVertices = 9;
constexpr std::size_t kTexturedFaces = 8;
constexpr std::size_t kBufferBytes = kTexturedVertices * (12 + 8) + kTexturedFaces * 3 * 2;

/// Nine vertices and eight faces, all their numbers from the input: places, texture
/// coordinates, then indices.
fs::path texturedMesh(std::string_view numbers) {
  std::string buffer(numbers);
  buffer.resize(kBufferBytes, '\0');
  scratchFile("mesh.bin", buffer);
  return scratchFile(
      "mesh.gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2}]}],)"
      R"("buffers":[{"uri":"mesh.bin","byteLength":228}],"bufferViews":[)"
      R"({"buffer":0,"byteOffset":0,"byteLength":108},)"
      R"({"buffer":0,"byteOffset":108,"byteLength":72},)"
      R"({"buffer":0,"byteOffset":180,"byteLength":48}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":9,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5126,"count":9,"type":"VEC2"},)"
      R"({"bufferView":2,"componentType":5123,"count":24,"type":"SCALAR"}]})");
}

static_assert(kBufferBytes == 228);

/// The same picture with right checksums: without, libpng would refuse nearly every input.
std::string withChecksums(std::string_view png) {
  constexpr std::size_t kSignature = 8;
  std::string bytes(png);
  std::size_t at = kSignature;
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i]));
  };
  while (at + 12 <= bytes.size()) {
    const std::size_t length =
        byte(at) << 24U | byte(at + 1) << 16U | byte(at + 2) << 8U | byte(at + 3);
    if (length > bytes.size() - at - 12) break;
    const auto* type = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
    const uLong sum = crc32(0, type, static_cast<uInt>(length + 4));
    for (std::size_t i = 0; i < 4; ++i)
      bytes[at + 8 + length + i] = static_cast<char>(sum >> (24U - 8U * i) & 0xFFU);
    at += length + 12;
  }
  return bytes;
}

contact::ContactMap readMap(ByteReader& bytes) {
  constexpr unsigned kKinds = 12;
  const unsigned kind = bytes.take<std::uint8_t>() % kKinds;
  io::ContactMapSource source = sourceOf(kind);
  if (kind < 8) return io::readContactMap(scratchFile("map.ply", bytes.takeText()), source);
  const fs::path mesh = texturedMesh(bytes.takeText(kBufferBytes));
  source.picture = scratchFile("picture.png", withChecksums(bytes.takeText()));
  return io::readContactMap(mesh, source);
}

// === Objects

/// The ball that the seeds' maps lie on, in other triangles.
const io::MeshFile& ball() {
  static const io::MeshFile ball_file = [] {
    io::MeshFile file;
    file.mesh = handgraft::geometry::makeSphere(0.03, 2);
    return file;
  }();
  return ball_file;
}

/// Its points, without their faces: for maps of points, which are laid onto its surface.
const io::MeshFile& pointsOfBall() {
  static const io::MeshFile points_file = [] {
    io::MeshFile file;
    file.mesh = ball().mesh;
    file.cloud_O = file.mesh.vertices();
    return file;
  }();
  return points_file;
}

void requireSaneSet(const contact::ContactSet& set,
                    const handgraft::geometry::TriangleMesh& mesh,
                    const contact::SegmentationOptions& options) {
  HANDGRAFT_PROMISE(!set.patches.empty());
  for (const contact::Patch& patch : set.patches) {
    try {
      validate(mesh, patch);
    } catch (const handgraft::InvalidInput& error) {
      std::fprintf(stderr, "a patch is not valid: %s\n", error.what());
      std::abort();
    }
    HANDGRAFT_PROMISE(positionOf(mesh, patch.root).allFinite());
    for (const auto& point : patch.interpolation_boundary)
      HANDGRAFT_PROMISE(positionOf(mesh, point).allFinite());
    HANDGRAFT_PROMISE(std::ssize(patch.interpolation_boundary) <= options.interpolation_count);
    HANDGRAFT_PROMISE(options.joints_O || !patch.direction_O);
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteReader bytes(data, size);
  const contact::SegmentationOptions options = takeOptions(bytes);
  const bool onto_ball = bytes.take<std::uint8_t>() % 2 == 0;
  try {
    const contact::ContactMap map = readMap(bytes);
    validate(map);
    const bool is_cloud = map.mesh_O.faceCount() == 0;
    if (map.mesh_O.vertexCount() > kMostVertices) return 0;
    io::MeshFile own;
    own.mesh = map.mesh_O;
    const io::MeshFile& object = is_cloud ? pointsOfBall() : onto_ball ? ball() : own;
    const contact::ContactSet set = io::contactsFromMap(map, object, options);
    HANDGRAFT_PROMISE(isPermitted(options));
    requireSaneSet(set, object.mesh, options);
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  return 0;
}
