#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "client/present/render/image.h"

namespace handgraft::client::render {

/// A surface, in one colour unless told otherwise. Triangles are counter-clockwise from
/// outside; both sides are lit.
struct SurfaceMesh {
  std::vector<Eigen::Vector3f> vertices_W;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Color color{200, 200, 200};
  /// One a vertex, blended across triangles; empty: `color` everywhere.
  std::vector<Color> vertex_colors{};
};

/// A coloured area printed on the surfaces of a layer: the inside of a closed loop, extruded
/// along its mean normal by `reach_m` to both sides. Loops of fewer than three points print
/// nothing.
struct Decal {
  std::vector<Eigen::Vector3f> loop_W;
  float reach_m = 0.008F;
  Color color;
};

/// Meshes that are seen through together: of each, only the nearest surface shows.
struct Layer {
  double opacity = 1.0;
  std::vector<SurfaceMesh> meshes;
  std::vector<Decal> decals;
};

/// Straight line, as thick on the screen wherever it lies; opaque.
struct Segment {
  Eigen::Vector3f from_W;
  Eigen::Vector3f to_W;
  float width_px = 1.5F;
  Color color;
  float rim_px = 0.0F;  ///< of a pale rim on either side, which lies under all lines and discs
};

/// Disc that faces the viewer; opaque.
struct Marker {
  Eigen::Vector3f center_W;
  float radius_px = 3.0F;
  Color color;
  float rim_px = 0.0F;  ///< as a segment's
};

/// A word beside a place; no surface before it hides it.
struct Label {
  Eigen::Vector3f at_W;
  std::string text;
  Color color;
  /// Outward normal of the surface that the place lies on: seen from behind, the word is left
  /// out. Zero: never.
  Eigen::Vector3f facing_W = Eigen::Vector3f::Zero();
};

/// What a picture shows. Frame W, metres.
struct Scene {
  std::vector<Layer> layers;
  std::vector<Segment> segments;
  std::vector<Marker> markers;
  std::vector<Label> labels{};
  /// How far segments and markers are drawn towards the viewer, so that what lies on a surface
  /// is not eaten by it.
  float lift_m = 0.0012F;
  /// A camera shows what lies in this box, and of the rest what happens to be in sight; an
  /// empty one: everything.
  Eigen::AlignedBox3f framed_W{};

  /// Frames a mesh and what is so near it: a grasp, not the forearm behind it; and all of
  /// `whole`. Everything, if less than a fifth of some layer would be seen: the hand is not
  /// there, then.
  void frameAbout(const SurfaceMesh& mesh,
                  float reach_m,
                  const std::vector<const SurfaceMesh*>& whole = {});

  /// Every point that a camera should show.
  [[nodiscard]] std::vector<Eigen::Vector3f> points() const;
};

/// Throws InvalidInput if a triangle names a vertex that its mesh has not, or a mesh has
/// colours for some of its vertices. NaN vertices are fine: their triangles are not drawn.
void validate(const Scene& scene);

}  // namespace handgraft::client::render
