#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {

/// Where a hand touched an object: a value per vertex, optionally the touching segment.
struct ContactMap {
  geometry::TriangleMesh mesh_O;
  /// Intensity or probability per vertex, V entries, finite; 0 is no contact.
  Eigen::VectorXd value;
  /// Index into `segment_names` per vertex, -1 none; empty if the map has no labels.
  std::vector<int> label;
  /// Names of the hand's segments as the file gives them ("link_ff_dd_z"); may be empty
  /// although labels are not: then segments are anonymous.
  std::vector<std::string> segment_names;
  /// What the patch of each segment is called, where somebody knows better than its name:
  /// `thumb`, `index_distal`, `palm`, `f1`; "" for a segment that is to be left out. Empty:
  /// what its name says.
  std::vector<std::string> segment_parts{};
};

/// The finger a segment's name stands for (hand/part_words.h): `thumb index middle ring little
/// palm`, or "" when the name says nothing.
std::string fingerOfSegment(const std::string& segment_name);

/// The part of the hand that a label stands for, "" if nobody knows: `index_proximal`, or
/// `index` where its name tells no segment.
std::string partOfLabel(const ContactMap& map, int label);

/// Sizes, finite values, labels in range. InvalidInput names the vertex and its value.
void validate(const ContactMap& map);

}  // namespace handgraft::contact
