#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "client/present/render/scene.h"
#include "core/base/pose.h"
#include "idl/models.h"

/// What several pictures share.
namespace handgraft::client {

inline constexpr render::Color kHandColor{196, 203, 214};
inline constexpr render::Color kObjectColor{240, 214, 150};

/// One colour a finger, told apart also by the colour-blind (Okabe & Ito 2008): of its patches
/// the proximal one's is darker, the distal one's paler (`index_distal_2`). Names without a
/// finger take turns by `index`.
render::Color colorOf(const std::string& patch, std::size_t index);

/// `mesh` is in M.
render::SurfaceMesh surface(const v1::Mesh& mesh, const Pose& X_WM, render::Color color);

/// x y z each; what is left over is not shown.
std::vector<Eigen::Vector3f> pointsOf(const std::vector<double>& xyz);

/// A line that can be told from whatever it lies on: in its colour, between pale rims.
void addCasedLine(render::Scene& scene,
                  const Eigen::Vector3f& from_W,
                  const Eigen::Vector3f& to_W,
                  float width_px,
                  render::Color color);

/// A line with a head of two short strokes that lie at right angles to `normal_W`.
void addArrow(render::Scene& scene,
              const Eigen::Vector3f& from_W,
              const Eigen::Vector3f& to_W,
              const Eigen::Vector3f& normal_W,
              float width_px,
              render::Color color);

/// A dot in its colour on a pale one.
void addDot(render::Scene& scene,
            const Eigen::Vector3f& at_W,
            float radius_px,
            render::Color color);

struct MeshPlace {
  Eigen::Vector3f p;
  Eigen::Vector3f n;  ///< outward, unit; zero on a face without area
};

/// A point on a mesh. Errors: TransportError if it is none.
MeshPlace placeOn(const v1::Mesh& mesh, const v1::SurfacePoint& point);

}  // namespace handgraft::client
