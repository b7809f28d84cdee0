#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// A third of the area of each vertex's faces, V entries, m^2: how much a value per vertex
/// counts, so that answers do not depend on where the mesh is dense.
Eigen::VectorXd vertexAreas(const geometry::TriangleMesh& mesh);

/// The value that splits a distribution into two classes as far apart as possible: the maximum
/// of w0 w1 (m0 - m1)^2 over all splits, exactly, without a histogram. Lies halfway between the
/// two values that it parts.
///
/// Shapes: one weight, 0 or more, per value. Errors: InvalidInput if fewer than two different
/// values have weight. Cost: O(n log n). Source: Otsu 1979, "A Threshold Selection Method from
/// Gray-Level Histograms".
double otsuThreshold(const Eigen::VectorXd& values, const Eigen::VectorXd& weights);

/// Vertices of `candidates` above `low` that hang together, through edges between such
/// vertices, with one above `high`. With low == high that is all above it.
/// Shapes: one flag per vertex, in and out. Cost: O(V).
std::vector<char> aboveWithHysteresis(const geometry::TriangleMesh& mesh,
                                      const Eigen::VectorXd& value,
                                      const std::vector<char>& candidates,
                                      double low,
                                      double high);

/// Evens out noise: in each step every vertex takes the mean of its faces' means, weighted by
/// their areas. Keeps the integral over the surface and the range of values; a step reaches one
/// edge far. Vertices without a face keep their value. Errors: InvalidInput if `steps` < 0 or >
/// kMostSmoothingSteps. Cost: O(steps F).
Eigen::VectorXd smoothed(const geometry::TriangleMesh& mesh,
                         const Eigen::VectorXd& value,
                         int steps);

inline constexpr int kMostSmoothingSteps = 1000;

}  // namespace handgraft::contact
