#pragma once

#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/optimize/pose_problem.h"

namespace handgraft::test {

/// A hand of every kind of joint: two fingers, a mimic, a slider, a continuous joint, a fixed
/// tip.
std::shared_ptr<const hand::HandModel> syntheticHand();

/// A hand of one link: the root alone.
std::shared_ptr<const hand::HandModel> rigidHand();

/// A pose within the limits (+-pi where there are none), any rotation, up to 0.5 m away.
hand::HandPose randomPose(const hand::HandModel& model, std::mt19937& random);

/// `pose` moved along degree of freedom `dof` by `step` (root's rotation, translation, joints),
/// the rotation on the manifold.
hand::HandPose moved(hand::HandPose pose, int dof, double step);

Eigen::Vector3d randomUnit(std::mt19937& random);

/// A problem with `count` random pairs over all links, weights of every kind, and a random
/// prior.
optimize::PoseProblem randomProblem(std::shared_ptr<const hand::HandModel> model,
                                    int count,
                                    std::mt19937& random);

/// A problem that `goal` solves: points and opposed normals where they are at that pose.
optimize::PoseProblem reachableProblem(std::shared_ptr<const hand::HandModel> model,
                                       const hand::HandPose& goal,
                                       int pairs_per_link,
                                       std::mt19937& random);

/// Real hands beside the clone, those with mimic joints too.
std::vector<std::string> realHands();

}  // namespace handgraft::test
