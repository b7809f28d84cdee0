#pragma once

#include <string>
#include <vector>

#include "core/hand/skin.h"

namespace handgraft::hand {

/// One thing tried while a skin was made, in order.
struct SkinStep {
  std::string action;  ///< "span sheets", "wrap", "shut tunnels", "even out triangles"
  double alpha_m = 0.0;
  double offset_m = 0.0;
  double edge_m = 0.0;  ///< 0 where the step has none
  double time_s = 0.0;
  int vertices = 0;
  int pieces = 0;               ///< of 3 % of the area or more
  int genus = 0;                ///< of all these pieces together
  double covering_share = 0.0;  ///< of the area, within epsilon of a link or sheet; wraps alone
  int sheets = 0;               ///< that shut tunnels
  double sheets_area_m2 = 0.0;  ///< one side
  int crossing_faces = 0;       ///< faces that pierce others
  std::string verdict;          ///< "kept", "spanned", or why not
};

/// How a skin was made and how good it is.
struct SkinReport {
  std::vector<SkinStep> steps;  ///< none if the skin comes from a cache
  double time_s = 0.0;
  bool from_cache = false;

  // From here on by `measure`.
  // === What the mesh is; a valid one has one piece, genus 0 and no crossing face
  int vertices = 0;
  int faces = 0;
  int pieces = 0;
  int genus = 0;
  bool is_closed = false;  ///< every edge has two faces that agree on its direction
  int crossing_faces = 0;
  double shortest_edge_m = 0.0;
  double mean_edge_m = 0.0;
  double longest_edge_m = 0.0;
  double smallest_angle_rad = 0.0;

  // === How it fits the links
  double mean_clearance_m = 0.0;  ///< of the vertices to the nearest link
  double max_clearance_m = 0.0;
  double projected_share = 0.0;  ///< of the vertices that have a place on a link

  /// What a user should know, as sentences; empty for a skin without a flaw.
  std::vector<std::string> notes;

  [[nodiscard]] bool isValid() const {
    return is_closed && pieces == 1 && genus == 0 && crossing_faces == 0;
  }
};

/// Fills all fields that can be measured on the skin itself; adds no step or note.
/// Cost: some 0.3 s.
void measure(const Skin& skin, SkinReport& report);

/// The report as lines for people: a line a step, then what came out. No final newline.
std::string describe(const SkinReport& report);

}  // namespace handgraft::hand
