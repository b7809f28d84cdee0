#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/surface_point.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/link_surfaces.h"
#include "core/hand/skin_links.h"

namespace handgraft::hand {

class KeptFiles;
struct SkinReport;

struct SkinOptions {
  /// Alpha ball radius and offset, in metres: the wrap bridges gaps narrower than about twice
  /// alpha and stands off by offset; at most 600 alphas across a hand. The first rung of a
  /// ladder that is climbed until the skin is one piece. 5e-4 to 0.05 m and 5e-5 to 0.01 m.
  double alpha_m = 0.003;
  double offset_m = 0.0008;
  /// Edge length that the skin is remeshed to, 5e-4 to 0.05 m.
  double edge_m = 0.0025;
  /// A skin point farther than this from every link is on no link (paper: epsilon).
  double epsilon_m = 0.004;
  SurfaceSource source = SurfaceSource::kVisuals;
};

/// A place on a link's own surface.
struct LinkPoint {
  int link = -1;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  /// Outward unit normal in the link's frame.
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  double distance_m = 0.0;  ///< between the skin point and the link's surface
};

/// One closed surface around the whole hand at a reference pose, and the way back to the links.
///
/// Frames: S is the hand's root frame with the joints at `q_reference`.
/// Each face of the skin belongs to one link, decided at that pose (skin_links.h).
/// Cost of `project`: O(log F). Const, safe from several threads.
class Skin {
 public:
  /// Takes a mesh already in S; builds the locators of the links' surfaces.
  Skin(const HandModel& model,
       geometry::TriangleMesh mesh_S,
       Eigen::VectorXd q_reference,
       double epsilon_m,
       SurfaceSource source = SurfaceSource::kVisuals);

  /// As above, but the link of each face of the mesh is known: that decision is what costs.
  Skin(const HandModel& model,
       geometry::TriangleMesh mesh_S,
       Eigen::VectorXd q_reference,
       double epsilon_m,
       SurfaceSource source,
       std::vector<int> face_links);

  [[nodiscard]] const geometry::TriangleMesh& mesh() const { return mesh_S_; }

  [[nodiscard]] const geometry::SurfaceLocator& locator() const { return *locator_; }

  [[nodiscard]] const Eigen::VectorXd& qReference() const { return q_reference_; }

  [[nodiscard]] double epsilon() const { return epsilon_m_; }

  /// Which of the links' shapes it was laid around.
  [[nodiscard]] SurfaceSource source() const { return source_; }

  /// The link that each face of the mesh belongs to; -1 where none is within epsilon.
  [[nodiscard]] const std::vector<int>& faceLinks() const { return face_links_; }

  /// The links' surfaces at the reference pose.
  [[nodiscard]] const LinkLocators& links() const { return *links_; }

  /// The nearest place on the surface of the link that the skin at `p_S` belongs to, or nothing
  /// beyond epsilon. On a border between links the better of them; where the skin is of no
  /// link, any.
  /// Frames: `p_S` in S; `n_S` the skin's outward normal there, which decides between the sides
  /// of thin or badly oriented link surfaces.
  [[nodiscard]] std::optional<LinkPoint> project(const Eigen::Vector3d& p_S,
                                                 const Eigen::Vector3d& n_S) const;
  /// Of a place on the skin itself, which is not searched for then.
  [[nodiscard]] std::optional<LinkPoint> project(const geometry::SurfacePoint& place_S) const;

  /// The way from W to where each link has its part of the skin: X_SL * X_LW, a pose a link.
  /// Every link carries its part along; a place in W is so taken to the skin as it is in S.
  [[nodiscard]] LinkPoses fromWorld(const HandModel& model, const HandPose& pose) const;

  /// Where a link's own point (in L) lies on the skin.
  [[nodiscard]] geometry::SurfacePoint skinPointOf(int link, const Eigen::Vector3d& p_L) const;
  /// A direction of link L turned into S, at the reference pose, and back.
  [[nodiscard]] Eigen::Vector3d directionInSkin(int link, const Eigen::Vector3d& d_L) const;
  [[nodiscard]] Eigen::Vector3d directionInLink(int link, const Eigen::Vector3d& d_S) const;

  /// Where what takes long to make of it may be kept; null: nowhere.
  [[nodiscard]] const KeptFiles* keptIn() const { return files_.get(); }

  void keepIn(std::shared_ptr<const KeptFiles> files) { files_ = std::move(files); }

 private:
  /// The place of the links that a point next to face `face` belongs to.
  [[nodiscard]] std::optional<LinkLocators::Hit> hitFrom(int face,
                                                         const Eigen::Vector3d& p_S,
                                                         const Eigen::Vector3d& n_S) const;
  [[nodiscard]] std::optional<LinkPoint> projectFrom(int face,
                                                     const Eigen::Vector3d& p_S,
                                                     const Eigen::Vector3d& n_S) const;

  geometry::TriangleMesh mesh_S_;
  Eigen::VectorXd q_reference_;
  double epsilon_m_;
  SurfaceSource source_;
  std::vector<Pose> X_SL_;
  std::unique_ptr<geometry::SurfaceLocator> locator_;
  std::unique_ptr<LinkLocators> links_;
  std::vector<int> face_links_;
  std::shared_ptr<const KeptFiles> files_;
};

/// The joints at which the hand is wrapped: the zero pose, moved by at most 0.35 rad where
/// links would stand closer than 10 mm. Within the limits; deterministic. Cost: some 20 ms.
Eigen::VectorXd skinReferencePose(const HandModel& model);

/// Wraps the union of the links' surfaces at the reference pose: closed, 2-manifold, oriented,
/// of one piece, of genus 0, without self-intersection, its triangles evened out.
///
/// Through-holes of a frame are shut by thin sheets, which belong to no link where they are
/// farther than epsilon from all. A hand whose links cannot be joined gets a skin of several
/// such pieces. `report`, if given, says so and what was tried; `measure` (skin_report.h) adds
/// how good the skin is.
///
/// Errors: InvalidInput if no link has a surface, the hand is not 0.01 to 2 m across, or an
/// option is out of range. Cancelled on wish. Deterministic. Cost: 1-6 s for a hand of 100k
/// triangles. Source: Portaneri et al. 2022, "Alpha wrapping with an offset".
Skin buildSkin(const HandModel& model,
               const SkinOptions& options,
               const Progress& progress,
               SkinReport* report = nullptr);

}  // namespace handgraft::hand
