#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/signed_distance.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

/// Places all over a link's surface, from which the samples of its solid are chosen.
namespace handgraft::hand {

/// What of a link's own surface is farther from its part of the skin lies beneath other links.
inline constexpr double kHidden = 0.0015;  // m

/// A face of the skin, as its link has it, or a place of the link's own surface: its middle
/// (`p_S` in the skin's frame, `p_L` in the link's), the outward normal of an own one.
struct Facet {
  int link = -1;
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_L = Eigen::Vector3d::Zero();
  double area_m2 = 0.0;
  double offset = 0.0;  ///< of the skin above the link
  bool is_sharp = false;
};

/// The skin's faces that belong to a link.
std::vector<Facet> facetsOf(const Skin& skin, const LinkPoses& X_SL);

/// Moves facets onto their links' own surfaces, where those are beneath the skin.
void projectOntoLinks(const Skin& skin, const LinkPoses& X_SL, std::vector<Facet>& facets);

/// What of a solid link's own surface lies beneath other links, where the skin does not show
/// it.
void addHidden(const geometry::SignedDistance& own,
               const geometry::SignedDistance& part,
               int link,
               const Pose& X_SL,
               std::vector<Facet>& facets);

/// Where a link's own surface is sharp outwards, corners before edges: what stands out between
/// samples a few millimetres apart, and from a grid and a skin, which round it. Of what other
/// links hide, where the link is `is_solid`.
void addSharp(const geometry::SignedDistance& own,
              const geometry::SignedDistance& part,
              bool is_solid,
              double beneath,
              int link,
              const Pose& X_SL,
              std::vector<Facet>& facets);

}  // namespace handgraft::hand
