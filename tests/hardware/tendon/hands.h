#pragma once

#include <random>
#include <string>

#include "hardware/tendon/tendon_hand.h"

namespace handgraft::tendon::test {

/// One flexor over three joints with springs: the worked example of adaptive synergies.
inline TendonHand workedFinger() {
  TendonHand hand;
  hand.joints = {{"mcp", {-0.5, 1.6}, 0.3, 0},
                 {"pip", {-0.5, 1.9}, 0.2, 0},
                 {"dip", {-0.5, 1.4}, 0.15, 0}};
  Tendon flexor;
  flexor.name = "flexor";
  flexor.crossings = {{0, Extension::constantArm(0.009)},
                      {1, Extension::constantArm(0.007)},
                      {2, Extension::constantArm(0.005)}};
  flexor.spool.radius_m = 0.006;
  flexor.largest_tension = 100;
  hand.tendons = {flexor};
  return hand;
}

/// Two fingers on a tendon each, and one tendon that crosses both: all kinds of arms, shared
/// joints, stretch and pretension.
inline TendonHand coupledHand() {
  TendonHand hand;
  hand.joints = {{"a", {0, 1.5}, 0.15, -0.1},
                 {"b", {0, 1.6}, 0.1, 0},
                 {"c", {0, 1.4}, 0.1, 0.05},
                 {"d", {0, 1.5}, 0.1, 0}};
  Tendon first, second, both;
  first.name = "first";
  first.crossings = {{0, Extension::channel(0.008, 0.009, 0.006)},
                     {1, Extension::constantArm(0.006)}};
  second.name = "second";
  second.crossings = {{2, Extension::quadratic(0.006, 0.001)},
                      {3, Extension::constantArm(0.007)}};
  both.name = "both";
  both.crossings = {{1, Extension::constantArm(0.006)}, {3, Extension::constantArm(0.005)}};
  hand.tendons = {first, second, both};
  for (Tendon& tendon : hand.tendons) {
    tendon.spool = {0.008, 0.0004};
    tendon.stiffness = 20000;
    tendon.pretension = 1;
    tendon.largest_tension = 34;
  }
  return hand;
}

/// Two joints without springs, three tendons that pull against each other.
inline TendonHand antagonists() {
  TendonHand hand;
  hand.joints = {{"a", {-1, 1}, 0, 0}, {"b", {-1, 1}, 0, 0}};
  const double arms[3][2] = {{0.01, 0.008}, {-0.01, 0.004}, {-0.002, -0.01}};
  for (int i = 0; i < 3; ++i) {
    Tendon tendon;
    tendon.name = "tendon_" + std::to_string(i);
    tendon.crossings = {{0, Extension::constantArm(arms[i][0])},
                        {1, Extension::constantArm(arms[i][1])}};
    hand.tendons.push_back(tendon);
  }
  return hand;
}

inline std::vector<double> randomPose(const TendonHand& hand, std::mt19937& random) {
  std::vector<double> q;
  for (const TendonJoint& joint : hand.joints)
    q.push_back(
        std::uniform_real_distribution<double>(joint.range.lower, joint.range.upper)(random));
  return q;
}

inline std::vector<double> excursionsOf(const TendonHand& hand, const std::vector<double>& q) {
  std::vector<double> e;
  for (const Tendon& tendon : hand.tendons) {
    e.push_back(0);
    for (const Crossing& crossing : tendon.crossings)
      e.back() += crossing.extension.at(q[crossing.joint]).e;
  }
  return e;
}

}  // namespace handgraft::tendon::test
