#include "tests/bench/motions/single_frames.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "core/hand/kinematics.h"
#include "core/manipulation/trajectory.h"
#include "core/optimize/solver.h"
#include "core/placement/solids.h"

namespace handgraft::bench {

namespace {

using manipulation::MotionProblem;

/// How a frame is solved.
struct Way {
  const char* name;
  std::function<void(optimize::PoseProblem&)> change;
  int rounds = 0;  ///< of weights by 1 / distance: towards the least mean distance
  int starts = optimize::kDefaultStarts;
};

std::vector<double> residuals(const optimize::PoseProblem& problem,
                              const hand::HandPose& pose) {
  const hand::LinkPoses X_OL = hand::forwardKinematics(*problem.model, pose);
  std::vector<double> result;
  for (const optimize::PointPair& pair : problem.pairs)
    result.push_back((X_OL[static_cast<std::size_t>(pair.link)] * pair.p_L - pair.p_W).norm());
  return result;
}

}  // namespace

void printSingleFrames(const MotionProblem& problem,
                       const std::vector<hand::HandPose>& starts,
                       const std::shared_ptr<const hand::Skin>& skin,
                       const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                       std::size_t stride) {
  const auto inside = [](double margin_m, double firmness = 1.0) {
    return [margin_m, firmness](optimize::PoseProblem& single) {
      auto avoidance = std::make_shared<optimize::Avoidance>(*single.avoidance);
      avoidance->margin_m = margin_m;
      avoidance->weight *= firmness;
      single.avoidance = std::move(avoidance);
    };
  };
  const std::vector<Way> ways = {
      {"positions alone",
       [](optimize::PoseProblem& single) {
         single.avoidance = nullptr;
         single.weights.prior = 0.0;
       }},
      {"and the prior",
       [](optimize::PoseProblem& single) {
         single.avoidance = nullptr;
       }},
      {"and out of the object", [](optimize::PoseProblem&) {}},
      {"up to 1.5 mm inside", inside(-0.0015)},
      {"up to 1.8 mm inside", inside(-0.0018)},
      {"out, least mean distance", [](optimize::PoseProblem&) {}, 6},
      {"1.5 mm inside, least mean distance", inside(-0.0015), 6},
      {"1.8 mm inside, least mean distance", inside(-0.0018), 6},
      // A bound: what no single frame can do within 2 mm, no motion can.
      {"1.9 mm inside, firmly, least mean distance", inside(-0.0019, 16.0), 12, 256},
  };
  const manipulation::FrameProblems frames(problem, {0.0, true});
  std::printf(
      "| each frame alone | mean mm | deepest mm | in itself mm |\n|---|---|---|---|\n");
  for (const Way& way : ways) {
    double sum = 0.0;
    double count = 0.0;
    double deepest = 0.0;
    double self = 0.0;
    for (std::size_t k = 0; k < starts.size(); k += stride) {
      if (frames.presentAt(static_cast<int>(k)).empty()) continue;
      optimize::PoseProblem single = frames.at(static_cast<int>(k), starts[k]);
      way.change(single);
      const std::vector<optimize::PointPair> pairs = single.pairs;
      optimize::SolveOptions searching;
      searching.starts = way.starts;
      const optimize::SolveReport report = optimize::solve(single, searching, Progress());
      hand::HandPose pose = report.pose;
      double least = std::numeric_limits<double>::infinity();
      for (const optimize::Minimum& minimum : report.minima) {
        if (way.rounds == 0) break;
        hand::HandPose found = minimum.pose;
        for (int round = 0; round < way.rounds; ++round) {
          const std::vector<double> now = residuals(single, found);
          for (std::size_t i = 0; i < pairs.size(); ++i)
            single.pairs[i].weight = pairs[i].weight * 0.01 / std::max(now[i], 0.001);
          single.start = found;
          optimize::SolveOptions solving;
          solving.starts = 1;
          found = optimize::solve(single, solving, Progress()).pose;
        }
        const std::vector<double> now = residuals(single, found);
        const double mean = std::accumulate(now.begin(), now.end(), 0.0);
        if (mean >= least) continue;
        least = mean;
        pose = found;
      }
      for (const double distance : residuals(single, pose)) {
        sum += 1e3 * distance;
        count += 1.0;
      }
      const quality::Penetration penetration = placement::penetrationOf(
          problem.model, skin, object_O, Pose::Identity(), pose, {}, Progress());
      deepest = std::max(deepest, penetration.max_depth_m);
      self = std::max(self, penetration.self_depth_m);
    }
    std::printf("| %s | %.2f | %.2f | %.2f |\n", way.name, sum / count, 1e3 * deepest,
                1e3 * self);
    std::fflush(stdout);
  }
}

}  // namespace handgraft::bench
