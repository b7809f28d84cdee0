#pragma once

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "core/optimize/pose_problem.h"

#include "tests/bench/chain_pair.h"

namespace handgraft::bench {

/// A hand by the file that problem files name.
struct FiledHand {
  std::string name;
  std::filesystem::path urdf;  ///< absolute
  hand::Hand hand;
};

/// The hands of server/models, and four that others made where $HANDGRAFT_SHARED_DATA is set;
/// of the library's, those named in `only` alone, and no others, unless that is empty. `models`
/// is the folder of the library. Errors: as readHand.
std::vector<FiledHand> measuredHands(const std::filesystem::path& models,
                                     const std::filesystem::path& cache,
                                     const std::vector<std::string>& only);

/// Contacts likewise: four sets of the library, four scans.
std::vector<ScannedGrasp> measuredGrasps(const std::filesystem::path& models);

/// One of the library's sets, by its name and its object's.
ScannedGrasp builtInGrasp(const std::filesystem::path& models,
                          const std::string& object,
                          const std::string& contacts);

/// One of the library's hands.
FiledHand builtInHand(const std::filesystem::path& models,
                      const std::string& name,
                      const std::filesystem::path& cache);

/// In [lower, upper); the same on every machine.
double uniform(std::mt19937& random, double lower, double upper);
Eigen::Vector3d randomUnit(std::mt19937& random);

/// The problem with its object moved by X_WV: X_WO becomes X_WV X_WO. Start and prior stay.
optimize::PoseProblem moved(const optimize::PoseProblem& problem, const Pose& X_WV);

/// Distance and normals alone: the prior of the root knows where the object went.
double fitOf(const optimize::PoseProblem& problem, const optimize::Terms& terms);

}  // namespace handgraft::bench
