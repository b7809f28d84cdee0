#include "core/retargeting/motion_slides.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/manipulation/offline_solver.h"
#include "core/manipulation/thinned_motion.h"
#include "core/placement/place_slider.h"
#include "core/placement/solids.h"
#include "core/retargeting/motion_layer.h"
#include "core/retargeting/motion_places.h"
#include "core/retargeting/motion_times.h"
#include "core/retargeting/motion_unheld.h"

namespace handgraft::retargeting {

namespace {

using manipulation::MotionProblem;
using manipulation::ThinnedMotion;

constexpr int kSlides = 10;
constexpr int kFewer = 4;
constexpr double kEvery = 0.05;  // s

/// Eq. 2 of all frames. A point that is lost no longer counts: as if it were kLost_m off.
double costOf(const MotionProblem& problem,
              const manipulation::Fade& fade,
              const manipulation::Trajectory& trajectory) {
  double cost = 0.0;
  const manipulation::FrameProblems frames(problem, fade);
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) {
    cost += trajectory.objective[k];
    for (const optimize::PointPair& pair :
         frames.at(static_cast<int>(k), trajectory.poses[k]).pairs)
      cost -= problem.weights.distance * pair.weight * placement::kLost * placement::kLost;
  }
  return cost;
}

/// In the thinned motion's frames, the nearest ones.
std::vector<manipulation::FramePose> knownIn(const ThinnedMotion& thin,
                                             std::vector<manipulation::FramePose> known) {
  for (manipulation::FramePose& one : known) {
    const auto nearest =
        std::min_element(thin.frames.begin(), thin.frames.end(), [&](int a, int b) {
          return std::abs(a - one.frame) < std::abs(b - one.frame);
        });
    one.frame = static_cast<int>(nearest - thin.frames.begin());
  }
  return known;
}

/// The thinned motion on its way: laid, solved, slid, and the best of it.
class Sliding {
 public:
  Sliding(const MotionScene& scene, ThinnedMotion& thin, const Progress& progress)
      : scene_(scene),
        options_(scene.solving.options),
        thin_(thin),
        progress_(progress),
        places_(scene.document, scene.hand, *scene.object_O, thin.motion),
        layer_(scene.document, scene.hand, *scene.object_O, thin.motion),
        problem_(
            motionProblemOf(scene.document, scene.hand, thin.motion.time_s, scene.solving)) {
    if (scene.document.solving.avoids()) {
      problem_.avoidance = placement::avoidanceOf(scene.hand.model, scene.hand.skin,
                                                  scene.object_O, Pose::Identity(), progress);
    }
    turnAlike(scene.hand, thin.motion, problem_);
    charts_.uses_drafts = true;
    lay();
    holdThroughout(scene.document, options_.fade, problem_);
  }

  void begin(const std::vector<manipulation::FramePose>& known) {
    // Grasps that sessions found lead on; of its own few starts do.
    manipulation::MotionOptions few = options_;
    if (!known.empty()) few.starts = std::max(1, few.starts / kFewer);
    trajectory_ = solveOffline(problem_, few, progress_, {}, knownIn(thin_, known));
    keepIfBest();
  }

  /// Patches to where the hand shows them, and a few steps of the hand after them. A step of
  /// all patches at once may first make things worse.
  void slide(int most) {
    for (int i = 0; i < most && places_.slide(trajectory_.poses, thin_.motion); ++i) {
      lay();
      stepOn(problem_, options_, progress_, trajectory_);
      keepIfBest();
    }
  }

  void goBack() {
    thin_.motion = best_.motion;
    trajectory_ = best_.trajectory;
    lay();
  }

  [[nodiscard]] const std::vector<hand::HandPose>& poses() const { return trajectory_.poses; }

  /// Of each key, exact from now on.
  manipulation::MotionCharts takeCharts() {
    charts_.uses_drafts = false;
    return std::move(charts_);
  }

 private:
  struct Best {
    double cost = std::numeric_limits<double>::infinity();
    manipulation::Motion motion;
    manipulation::Trajectory trajectory;
  };

  void lay() {
    problem_.tracks = weighed(scene_.document, scene_.grasp, thin_.motion,
                              layer_.lay(thin_.motion, progress_, {}, &charts_));
  }

  void keepIfBest() {
    const double cost = costOf(problem_, options_.fade, trajectory_);
    if (cost < best_.cost) best_ = {cost, thin_.motion, trajectory_};
  }

  const MotionScene& scene_;
  const manipulation::MotionOptions& options_;
  ThinnedMotion& thin_;
  const Progress& progress_;
  MotionPlaces places_;
  MotionLayer layer_;
  manipulation::MotionCharts charts_;
  MotionProblem problem_;
  manipulation::Trajectory trajectory_;
  Best best_;
};

}  // namespace

SlidPatches slidePatches(const MotionScene& scene,
                         const std::vector<manipulation::FramePose>& known,
                         const Progress& progress,
                         manipulation::Motion& motion) {
  ThinnedMotion thin =
      manipulation::thinned(motion, manipulation::strideOf(motion.time_s, kEvery));
  Sliding sliding(scene, thin, progress);
  sliding.begin(known);
  sliding.slide(kSlides);
  sliding.goBack();
  takePlacements(thin, motion);
  SlidPatches slid{posesBetween(thin, sliding.poses(), motion), std::nullopt};
  if (thin.hasAllKeys(motion)) slid.charts = sliding.takeCharts();
  return slid;
}

}  // namespace handgraft::retargeting
