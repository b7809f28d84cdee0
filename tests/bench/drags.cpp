#include "tests/bench/drags.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/environment.h"
#include "core/geometry/signed_distance.h"
#include "core/hand/kinematics.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/grasp_problems.h"
#include "tests/bench/skin_cache.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using session::Session;

constexpr double kTurn = 0.25;        // rad, of a finger's joints either way
constexpr double kLeast = 0.003;      // m; of a drag
constexpr double kClearance = 0.003;  // m; of the pad's place from the object: it is pulled off
constexpr double kHeld = 0.002;       // m; off its target at most
constexpr int kTriesForATarget = 200;

struct Arguments {
  std::string models = "server/models";
  std::string cache = defaultCache().string();
  int count = 100;
  unsigned seed = 0;
};

struct Drag {
  double way_m = 0.0;
  double off_m = 0.0;        ///< once solved
  double off_later_m = 0.0;  ///< after the edits that follow
  double lost_mm = 0.0;      ///< by the other digits' patches, on average
};

double middleOf(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// As a server answers an edit.
optimize::SolveReport answered(Session& session, int starts) {
  session::SolverSettings solving = session.document().solving;
  session::SolveRun run;
  if (starts > 0) {
    solving.starts = starts;
    run.places_stay = true;
  }
  session::Solution solution = session.solve(solving, run, Progress());
  optimize::SolveReport report = solution.report;
  session.commit(std::move(solution));
  return report;
}

class Dragging {
 public:
  Dragging(const hand::Hand& hand, const ScannedGrasp& grasp, std::mt19937& random)
      : session_(hand, grasp.object_O, grasp.contacts, Pose::Identity(), {}),
        distance_(*grasp.object_O),
        random_(random) {
    start_ = answered(session_, 0);
  }

  /// One drag of a digit's site, three edits of other things, and all of it undone.
  std::optional<Drag> drag() {
    const hand::HandModel& model = *session_.hand().model;
    std::vector<const hand::ContactSite*> tips;
    for (const hand::ContactSite& site : session_.hand().sites)
      if (site.name != "palm") tips.push_back(&site);
    const hand::ContactSite& tip = *tips[random_() % tips.size()];
    const Vector3d before_W = placeOf(tip, session_.document().start);
    const auto target_W = target(tip, before_W);
    if (!target_W) return std::nullopt;

    const unsigned long long begun = session_.revision();
    Drag drag;
    drag.way_m = (*target_W - before_W).norm();
    session_.apply(session::DragEdit{tip.link, tip.p_L, *target_W});
    const optimize::SolveReport dragged = answered(session_, session::kStartsAfterEdit);
    drag.off_m = (placeOf(tip, dragged.pose) - *target_W).norm();
    drag.lost_mm = lostBy(dragged, tip.link);

    const session::SessionPatch& other = otherPatch(tip.link);
    session_.apply(session::PatchWeightEdit{other.patch.name, 2.0});
    answered(session_, session::kStartsAfterEdit);
    const hand::Joint& joint = model.dofJoint(0);
    session_.apply(session::JointLockEdit{joint.name, true});
    answered(session_, session::kStartsAfterEdit);
    Pose X_WO = session_.objectPose();
    X_WO.translation() += 0.002 * randomUnit(random_);
    session_.apply(session::ObjectPoseEdit{X_WO});
    const optimize::SolveReport last = answered(session_, session::kStartsAfterEdit);
    drag.off_later_m = (placeOf(tip, last.pose) - *target_W).norm();

    session_.apply(session::UndoEdit{static_cast<int>(session_.revision() - begun)});
    return drag;
  }

 private:
  [[nodiscard]] Vector3d placeOf(const hand::ContactSite& site,
                                 const hand::HandPose& pose) const {
    const hand::HandModel& model = *session_.hand().model;
    const auto link = static_cast<std::size_t>(model.linkIndex(site.link));
    return forwardKinematics(model, pose)[link] * site.p_L;
  }

  /// A place that the finger reaches by its own joints, off the object.
  std::optional<Vector3d> target(const hand::ContactSite& tip, const Vector3d& before_W) {
    const hand::HandModel& model = *session_.hand().model;
    for (int i = 0; i < kTriesForATarget; ++i) {
      hand::HandPose pose = session_.document().start;
      for (int dof = 0; dof < model.dofCount(); ++dof) {
        const double turn = uniform(random_, -kTurn, kTurn);
        if (!movesPalm(dof)) pose.q[dof] += turn;
      }
      pose.q = pose.q.cwiseMax(model.lower()).cwiseMin(model.upper());
      const Vector3d p_W = placeOf(tip, pose);
      if ((p_W - before_W).norm() < kLeast) continue;
      if (distance_.at(p_W).distance < kClearance) continue;
      return p_W;
    }
    return std::nullopt;
  }

  /// A wrist does: who turns it takes all other fingers along.
  [[nodiscard]] bool movesPalm(int dof) const {
    const hand::HandModel& model = *session_.hand().model;
    for (const hand::ContactSite& site : session_.hand().sites) {
      if (site.name != "palm") continue;
      for (int link = model.linkIndex(site.link); link > 0;) {
        const auto& node = model.nodes()[static_cast<std::size_t>(link - 1)];
        if (node.dof == dof) return true;
        link = node.parent_link;
      }
    }
    return false;
  }

  [[nodiscard]] bool isOf(const session::SessionPatch& patch, const std::string& link) const {
    for (const hand::ContactSite& site : session_.hand().sites)
      if (site.link == link) return patch.site.starts_with(site.name);
    return false;
  }

  [[nodiscard]] const session::SessionPatch& otherPatch(const std::string& link) const {
    const session::SessionPatch* found = &session_.patches().front();
    for (const session::SessionPatch& patch : session_.patches())
      if (patch.placement && !isOf(patch, link)) found = &patch;
    return *found;
  }

  double lostBy(const optimize::SolveReport& report, const std::string& link) const {
    double sum = 0.0;
    int count = 0;
    for (const optimize::PatchFit& fit : report.patches) {
      if (isOf(session_.patches()[static_cast<std::size_t>(fit.patch)], link)) continue;
      for (const optimize::PatchFit& was : start_.patches) {
        if (was.patch != fit.patch) continue;
        sum += fit.mean_mm - was.mean_mm;
        ++count;
      }
    }
    return count > 0 ? sum / count : 0.0;
  }

  Session session_;
  geometry::SignedDistance distance_;
  std::mt19937& random_;
  optimize::SolveReport start_;
};

std::vector<std::pair<hand::Hand, ScannedGrasp>> casesOf(const Arguments& arguments) {
  std::vector<std::pair<hand::Hand, ScannedGrasp>> cases;
  const fs::path data = environment("HANDGRAFT_SHARED_DATA");
  if (data.empty()) {
    const ScannedGrasp box = builtInGrasp(arguments.models, "box", "box_5");
    for (const char* name : {"human20", "tendon16", "allegro16"})
      cases.emplace_back(builtInHand(arguments.models, name, arguments.cache).hand, box);
    return cases;
  }
  const ScannedGrasp bottle =
      readGrasp("mustard", data / "objects/ycb/006_mustard_bottle.obj",
                data / "contacts/dexycb/006_mustard_bottle_grasp0_contact.ply", false);
  for (const char* urdf : {"allegro_right/allegro_hand_right.urdf",
                           "human_hand_graspit20/human_hand_graspit20.urdf",
                           "shadow_right/shadow_hand_right.urdf"})
    cases.emplace_back(readHand(data / "hands" / urdf, arguments.cache), bottle);
  return cases;
}

void run(const Arguments& arguments) {
  fmt::print(
      "| hand | drags | way mm | off mm: median, worst | more than 2 mm off | after three "
      "edits: "
      "median, worst | more than 2 mm off | others lose mm: median |\n"
      "|---|---|---|---|---|---|---|---|\n");
  std::mt19937 random(arguments.seed);
  for (const auto& [hand, grasp] : casesOf(arguments)) {
    Dragging dragging(hand, grasp, random);
    std::vector<double> way;
    std::vector<double> off;
    std::vector<double> later;
    std::vector<double> lost;
    for (int i = 0; i < arguments.count; ++i) {
      const auto drag = dragging.drag();
      if (!drag) continue;
      way.push_back(drag->way_m);
      off.push_back(drag->off_m);
      later.push_back(drag->off_later_m);
      lost.push_back(drag->lost_mm);
    }
    const auto beyond = [](const std::vector<double>& values) {
      return std::count_if(values.begin(), values.end(), [](double value) {
        return value > kHeld;
      });
    };
    const auto most = [](const std::vector<double>& values) {
      return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
    };
    fmt::print("| {} | {} | {:.1f} | {:.2f}, {:.1f} | {} | {:.2f}, {:.1f} | {} | {:.2f} |\n",
               hand.model->name(), way.size(), 1e3 * middleOf(way), 1e3 * middleOf(off),
               1e3 * most(off), beyond(off), 1e3 * middleOf(later), 1e3 * most(later),
               beyond(later), middleOf(lost));
  }
}

}  // namespace

void addDragsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "drags", "Fingertips dragged at random: how far off they end, and what others lose");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("--models", arguments->models, "Folder of the built-in library")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "Folder that keeps the skins")
      ->capture_default_str();
  command->add_option("--count", arguments->count, "Drags of each hand")->capture_default_str();
  command->add_option("--seed", arguments->seed, "Of what is random")->capture_default_str();
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
