#pragma once

#include <limits>
#include <string>
#include <vector>

#include "hardware/tendon/extension.h"
#include "hardware/tendon/spool.h"

namespace handgraft::tendon {

/// A joint that tendons move: between its stops, and against a spring if it has one.
struct TendonJoint {
  std::string name;
  Range range;           ///< rad, the mechanical stops
  double stiffness = 0;  ///< Nm/rad; 0: no spring
  double rest = 0;       ///< rad, where the spring is slack
};

/// Where a tendon crosses a joint.
struct Crossing {
  std::size_t joint;
  Extension extension;
};

/// One tendon and the drum that winds it; one motor each.
struct Tendon {
  std::string name;
  std::vector<Crossing> crossings;  ///< each joint once at most
  Spool spool;
  double stiffness = std::numeric_limits<double>::infinity();  ///< E A / L, N/m
  double pretension = 0;                                       ///< N, never less when commanded
  double largest_tension = 0;                                  ///< N, never more when commanded
  bool closed_loop = false;  ///< wound both ways on its drum: it pushes, too
};

/// The tendons of a hand. Joints either all have springs (elastic: a posture is where energy is
/// least) or none does (rigid: tendons alone determine it).
struct TendonHand {
  std::vector<TendonJoint> joints;
  std::vector<Tendon> tendons;

  [[nodiscard]] bool isElastic() const {
    return !joints.empty() && joints.front().stiffness > 0;
  }
};

/// What there is to object to, each naming the thing, its value and the permitted range; empty
/// if nothing. Checks: numbers finite and in range; every joint moved by a tendon, every
/// tendon crossing a joint with an arm that keeps its sign over the joint's range; springs on
/// all joints or none; elastic: one posture per excursion (springs stiffer than arms that
/// grow), tension at the closed hand below the largest; rigid: constant arms, rank as many as
/// joints, and tendons that can all be taut at once (a strictly positive null vector) unless
/// they are closed loops; excursions that the drum can pay out.
std::vector<std::string> problemsOf(const TendonHand& hand);

}  // namespace handgraft::tendon
