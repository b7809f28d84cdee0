// The small text files: contact sets on a mesh and on a point cloud, contact sites, joints of a
// hand that touched, problems. The first byte says which; what is read must be sane, and be the
// same when it is written and read again.

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/file_bytes.h"
#include "core/io/hand_joints_file.h"
#include "core/io/object_file.h"
#include "core/io/problem_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"

#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/fuzz/small_hand.h"

namespace {

namespace fs = std::filesystem;
namespace io = handgraft::io;
using handgraft::contact::ContactSet;
using handgraft::fuzz::scratchFile;

/// A ball of 162 vertices whose file lists squares, each two faces of the mesh, backwards.
const io::MeshFile& ball() {
  static const io::MeshFile ball_file = [] {
    io::MeshFile file;
    file.mesh = handgraft::geometry::makeSphere(0.03, 2);
    const int count = file.mesh.vertexCount();
    for (int v = 0; v < count; ++v) {
      file.file_vertex.push_back(count - 1 - v);
      file.mesh_vertex.push_back(count - 1 - v);
    }
    for (int f = 0; f < file.mesh.faceCount(); ++f)
      file.file_face.push_back((file.mesh.faceCount() - 1 - f) / 2);
    return file;
  }();
  return ball_file;
}

/// The same ball, of which only the points are given.
const io::MeshFile& cloud() {
  static const io::MeshFile cloud_file = [] {
    std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 162\nproperty double x\n"
        "property double y\nproperty double z\nend_header\n";
    for (const auto& p : ball().mesh.vertices().colwise())
      ply += fmt::format("{} {} {}\n", p.x(), p.y(), p.z());
    return io::readObject(scratchFile("cloud.ply", ply));
  }();
  return cloud_file;
}

const handgraft::hand::HandModel& hand() {
  static const handgraft::hand::HandModel palm_only =
      io::readUrdf(scratchFile("hand.urdf", handgraft::fuzz::kSmallHand)).model;
  return palm_only;
}

void requireSaneSet(const ContactSet& set, const io::MeshFile& object) {
  HANDGRAFT_PROMISE(!set.patches.empty());
  for (const auto& patch : set.patches) {
    validate(object.mesh, patch);
    HANDGRAFT_PROMISE(positionOf(object.mesh, patch.root).allFinite());
    for (const auto& point : patch.interpolation_boundary)
      HANDGRAFT_PROMISE(positionOf(object.mesh, point).allFinite());
  }
}

void tryContactSet(std::string_view text, const io::MeshFile& object) {
  const fs::path path = scratchFile("set.json", text);
  const ContactSet set = io::readContactSet(path, object);
  const std::string object_name = io::objectNameIn(path);
  try {
    requireSaneSet(set, object);
    HANDGRAFT_PROMISE(object_name == set.object);
    if (object.cloud_O.cols() > 0) return;  // has no spelling
    const fs::path first = scratchFile("first.json", "");
    io::writeContactSet(first, set, object);
    const ContactSet again = io::readContactSet(first, object);
    const fs::path second = scratchFile("second.json", "");
    io::writeContactSet(second, again, object);
    HANDGRAFT_PROMISE(io::readFileBytes(first) == io::readFileBytes(second));
    HANDGRAFT_PROMISE(again.name == set.name && again.object == set.object);
    HANDGRAFT_PROMISE(again.notes == set.notes);
    HANDGRAFT_PROMISE(again.patches.size() == set.patches.size());
    for (std::size_t i = 0; i < set.patches.size(); ++i) {
      const auto& a = set.patches[i];
      const auto& b = again.patches[i];
      HANDGRAFT_PROMISE(a.name == b.name && a.weight == b.weight && a.boundary == b.boundary);
      HANDGRAFT_PROMISE(a.direction_O == b.direction_O);
      HANDGRAFT_PROMISE(a.interpolation_boundary.size() == b.interpolation_boundary.size());
      for (std::size_t k = 0; k < a.interpolation_boundary.size(); ++k) {
        // A place within 1e-9 of a vertex is written as that vertex.
        HANDGRAFT_PROMISE((positionOf(object.mesh, a.interpolation_boundary[k]) -
                           positionOf(object.mesh, b.interpolation_boundary[k]))
                              .norm() <= 1e-7);
      }
    }
  } catch (const handgraft::InvalidInput& error) {
    std::fprintf(stderr, "what was read is refused: %s\n", error.what());
    std::abort();
  }
}

void trySites(std::string_view text) {
  const auto sites = io::readSites(scratchFile("sites.yaml", text), hand());
  try {
    validate(hand(), sites);
    const auto again = io::readSites(scratchFile("again.yaml", io::sitesText(sites)), hand());
    HANDGRAFT_PROMISE(again.size() == sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
      HANDGRAFT_PROMISE(again[i].name == sites[i].name && again[i].link == sites[i].link);
      const double size = std::max(1.0, sites[i].p_L.cwiseAbs().maxCoeff());
      HANDGRAFT_PROMISE((again[i].p_L - sites[i].p_L).cwiseAbs().maxCoeff() <= 1e-8 * size);
      HANDGRAFT_PROMISE((again[i].n_L - sites[i].n_L).norm() <= 1e-7);
      HANDGRAFT_PROMISE((again[i].direction_L - sites[i].direction_L).norm() <= 1e-6);
    }
  } catch (const handgraft::InvalidInput& error) {
    std::fprintf(stderr, "sites that were read are refused: %s\n", error.what());
    std::abort();
  }
}

void tryHandJoints(std::string_view text, std::optional<int> which) {
  const auto joints = io::readHandJoints(scratchFile("joints.json", text), which);
  HANDGRAFT_PROMISE(joints.p_O.allFinite());
  const auto nearest = nearestBone(joints, Eigen::Vector3d(0.01, 0.02, 0.03));
  HANDGRAFT_PROMISE(nearest.part >= 0 && nearest.part <= handgraft::contact::kPalm);
  HANDGRAFT_PROMISE(nearest.towards_wrist_O.allFinite());
}

void tryProblem(std::string_view text) {
  (void)hand();  // the URDF lies beside the file
  const auto problem = io::readProblem(scratchFile("problem.json", text));
  try {
    validate(problem);
    const std::string first = io::problemText(problem, "hand.urdf", {});
    const auto again = io::readProblem(scratchFile("again.json", first));
    HANDGRAFT_PROMISE(again.pairs.size() == problem.pairs.size());
    for (std::size_t i = 0; i < problem.pairs.size(); ++i) {
      const auto& a = problem.pairs[i];
      const auto& b = again.pairs[i];
      HANDGRAFT_PROMISE(a.link == b.link && a.p_L == b.p_L && a.n_L == b.n_L);
      HANDGRAFT_PROMISE(a.p_W == b.p_W && a.n_W == b.n_W && a.weight == b.weight);
    }
    HANDGRAFT_PROMISE(again.lower == problem.lower && again.upper == problem.upper);
    HANDGRAFT_PROMISE(again.locked == problem.locked);
    for (const auto& [a, b] :
         {std::pair(&problem.start, &again.start), std::pair(&problem.prior, &again.prior)}) {
      HANDGRAFT_PROMISE(a->q == b->q);
      HANDGRAFT_PROMISE(a->X_WH.translation() == b->X_WH.translation());
      HANDGRAFT_PROMISE(a->X_WH.linear().isApprox(b->X_WH.linear(), 1e-7));
    }
  } catch (const handgraft::InvalidInput& error) {
    std::fprintf(stderr, "a problem that was read is refused: %s\n", error.what());
    std::abort();
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size < 1) return 0;
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  try {
    switch (bytes[0] % 7) {
      case 0:
        tryContactSet(text, ball());
        break;
      case 1:
        tryContactSet(text, cloud());
        break;
      case 2:
        trySites(text);
        break;
      case 3:
        tryHandJoints(text, std::nullopt);
        break;
      case 4:
        tryHandJoints(text, bytes[0] / 7 % 3);
        break;
      default:
        tryProblem(text);
        break;
    }
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  return 0;
}
