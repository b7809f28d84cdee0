#include "tests/bench/grasp_problems.h"

#include <utility>

#include <fmt/format.h>

#include "core/base/environment.h"
#include "core/base/pose.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

FiledHand filedHand(const fs::path& urdf, const fs::path& cache) {
  FiledHand filed;
  filed.urdf = fs::absolute(urdf);
  filed.hand = readHand(urdf, cache);
  filed.name = filed.hand.model->name();
  return filed;
}

/// Empty where nobody says.
fs::path sharedData() {
  return environment("HANDGRAFT_SHARED_DATA");
}

}  // namespace

FiledHand builtInHand(const fs::path& models, const std::string& name, const fs::path& cache) {
  return filedHand(models / "hands" / name / (name + ".urdf"), cache);
}

ScannedGrasp builtInGrasp(const fs::path& models,
                          const std::string& object,
                          const std::string& contacts) {
  return readGrasp(contacts, models / "objects" / (object + ".obj"),
                   models / "contacts" / (contacts + ".json"), false);
}

std::vector<FiledHand> measuredHands(const fs::path& models,
                                     const fs::path& cache,
                                     const std::vector<std::string>& only) {
  std::vector<std::string> names = only;
  if (only.empty()) names = {"human20", "allegro16", "barrett8", "tendon16"};
  std::vector<FiledHand> hands;
  for (const std::string& name : names)
    hands.push_back(builtInHand(models, name, cache));
  const fs::path shared = sharedData();
  if (shared.empty() || !only.empty()) return hands;
  for (const char* urdf :
       {"allegro_right/allegro_hand_right.urdf", "barrett_bhand/bhand_model.urdf",
        "human_hand_graspit20/human_hand_graspit20.urdf",
        "mia_hand_right/mia_hand_description/urdf/mia_hand.urdf"}) {
    hands.push_back(filedHand(shared / "hands" / urdf, cache));
  }
  return hands;
}

std::vector<ScannedGrasp> measuredGrasps(const fs::path& models) {
  std::vector<ScannedGrasp> grasps;
  for (const auto& [object, contacts] :
       {std::pair{"scissors", "scissors_3"}, std::pair{"wine_glass", "wine_glass_4"},
        std::pair{"box", "box_5"}, std::pair{"lemon", "lemon_6"}}) {
    grasps.push_back(builtInGrasp(models, object, contacts));
  }
  const fs::path shared = sharedData();
  if (shared.empty()) return grasps;
  const fs::path bulb = shared / "contacts/contactpose";
  grasps.push_back(readGrasp("light bulb", bulb / "light_bulb.glb",
                             bulb / "full28_use_light_bulb_contact.ply", true));
  for (const auto& [name, file] :
       {std::pair{"mustard", "006_mustard_bottle"}, std::pair{"mug", "025_mug"},
        std::pair{"cracker box", "003_cracker_box"}}) {
    grasps.push_back(
        readGrasp(name, shared / fmt::format("objects/ycb/{}.obj", file),
                  shared / fmt::format("contacts/dexycb/{}_grasp0_contact.ply", file), true));
  }
  return grasps;
}

double uniform(std::mt19937& random, double lower, double upper) {
  return lower + (upper - lower) * static_cast<double>(random()) / 4294967296.0;
}

Eigen::Vector3d randomUnit(std::mt19937& random) {
  for (;;) {
    const double x = uniform(random, -1.0, 1.0);
    const double y = uniform(random, -1.0, 1.0);
    const Eigen::Vector3d v(x, y, uniform(random, -1.0, 1.0));
    if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
  }
}

optimize::PoseProblem moved(const optimize::PoseProblem& problem, const Pose& X_WV) {
  optimize::PoseProblem result = problem;
  for (optimize::PointPair& pair : result.pairs) {
    pair.p_W = X_WV * pair.p_W;
    pair.n_W = X_WV.linear() * pair.n_W;
  }
  return result;
}

double fitOf(const optimize::PoseProblem& problem, const optimize::Terms& terms) {
  return problem.weights.distance * terms.distance + problem.weights.normal * terms.normal;
}

}  // namespace handgraft::bench
