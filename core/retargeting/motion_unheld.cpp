#include "core/retargeting/motion_unheld.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/smooth_step.h"
#include "core/contact/contact_set.h"
#include "core/manipulation/trajectory.h"
#include "core/placement/posture_finding.h"
#include "core/quality/penetration.h"

namespace handgraft::retargeting {

namespace {

using Eigen::VectorXd;
using manipulation::DemonstratorKey;
using manipulation::FrameProblems;
using manipulation::Motion;
using manipulation::MotionProblem;

// So firm that what smoothness takes off lies above 1 or 2 Hz: a hand does little there.
constexpr double kJointWeight = 10.0;    // 1/rad^2; of sliders more (kSliderScale)
constexpr double kGoalWeight = 1.0;      // of a point of the goal, as a contact's
constexpr double kBesideContacts = 0.1;  // of that, where something touches already
constexpr double kGoalReach = 0.1;       // m; of those points from the hand's base
constexpr double kEnough = 3.0;       // patches hold a hand, or half as many as ever are there
constexpr double kForgets = 0.5;      // s; after which fingers stand as they are shown
constexpr double kTurnWeight = 0.01;  // 1/rad^2, of the hand; 1 mm of a point is 0.01
constexpr double kDeepGoal = 0.002;   // m; poses to set out from lie out of the object

/// A frame that holds something, before or behind another one.
struct Nearest {
  int before = -1;  ///< -1: none
  int behind = -1;
};

/// Of each frame the nearest ones that hold in full.
std::vector<Nearest> nearestHolds(const std::vector<double>& held) {
  const auto count = static_cast<int>(held.size());
  std::vector<Nearest> nearest(held.size());
  for (int k = 0, last = -1; k < count; ++k) {
    if (held[static_cast<std::size_t>(k)] >= 1.0) last = k;
    nearest[static_cast<std::size_t>(k)].before = last;
  }
  for (int k = count - 1, next = -1; k >= 0; --k) {
    if (held[static_cast<std::size_t>(k)] >= 1.0) next = k;
    nearest[static_cast<std::size_t>(k)].behind = next;
  }
  return nearest;
}

/// How much of each frame something holds the hand, and each of its joints; in [0, 1].
struct Holds {
  /// All of it where enough patches are there: what grazes holds no hand.
  std::vector<double> hand;
  std::vector<double> touches;              ///< whether anything is there
  std::vector<std::vector<double>> joints;  ///< of each joint, of each frame
};

Holds holdsOf(const MotionProblem& problem, const manipulation::Fade& fade) {
  const auto count = problem.time_s.size();
  const auto dof_count = static_cast<std::size_t>(problem.model->dofCount());
  const std::vector<std::vector<int>> dofs = hand::dofsMoving(*problem.model);
  Holds holds{std::vector<double>(count, 0.0), std::vector<double>(count, 0.0),
              std::vector<std::vector<double>>(dof_count, std::vector<double>(count, 0.0))};
  const FrameProblems frames(problem, fade);
  std::vector<char> counts;              // of each track: it is not switched off
  std::vector<std::vector<int>> needed;  // likewise, the joints that any of its pairs needs
  for (const manipulation::PairTrack& track : problem.tracks) {
    counts.push_back(0);
    std::vector<int>& joints = needed.emplace_back();
    for (const manipulation::PairSpan& span : track.spans) {
      for (const optimize::PointPair& pair : span.pairs) {
        if (!(pair.weight > 0.0)) continue;
        counts.back() = 1;
        const std::vector<int>& moving = dofs[static_cast<std::size_t>(pair.link)];
        joints.insert(joints.end(), moving.begin(), moving.end());
      }
    }
    std::sort(joints.begin(), joints.end());
    joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
  }
  for (std::size_t k = 0; k < count; ++k) {
    for (const FrameProblems::Present& present : frames.presentAt(static_cast<int>(k))) {
      if (counts[static_cast<std::size_t>(present.track)] == 0) continue;
      holds.hand[k] += present.presence;
      holds.touches[k] = std::max(holds.touches[k], present.presence);
      for (const int dof : needed[static_cast<std::size_t>(present.track)]) {
        double& share = holds.joints[static_cast<std::size_t>(dof)][k];
        share = std::max(share, present.presence);
      }
    }
  }
  const double most = *std::max_element(holds.hand.begin(), holds.hand.end());
  const double enough = std::min(kEnough, 0.5 * most);
  for (double& share : holds.hand)
    share = most > 0.0 ? std::min(1.0, share / enough) : 0.0;
  return holds;
}

class Unheld {
 public:
  Unheld(const hand::Hand& hand,
         const Motion& motion,
         const manipulation::Fade& fade,
         const Progress& progress,
         MotionProblem& problem,
         std::vector<hand::HandPose>& poses)
      : hand_(hand),
        motion_(motion),
        progress_(progress),
        problem_(problem),
        poses_(poses),
        holds_(holdsOf(problem, fade)) {}

  void lay() {
    const std::vector<Nearest> nearest = nearestHolds(holds_.hand);
    if (nearest.front().before < 0 && nearest.front().behind < 0) return;
    layRoots(nearest);
    lookAlike();
    layJoints();
    setOut(nearest);
  }

 private:
  [[nodiscard]] double timeOf(int frame) const {
    return problem_.time_s[static_cast<std::size_t>(frame)];
  }

  /// Of the way from one hold to the next, without a bend at its ends.
  [[nodiscard]] double shareAt(int frame, const Nearest& of) const {
    return smoothStep((timeOf(frame) - timeOf(of.before)) /
                      (timeOf(of.behind) - timeOf(of.before)));
  }

  /// Where the hand goes in frames without contact; in others as it is.
  void layRoots(const std::vector<Nearest>& nearest) {
    for (const hand::HandPose& pose : poses_)
      roots_.push_back(pose.X_WH);
    for (std::size_t k = 0; k < roots_.size(); ++k) {
      const double share = 1.0 - holds_.hand[k];
      if (share <= 0.0) continue;
      const auto frame = static_cast<int>(k);
      const Pose X_OD = demonstratorPoseAt(motion_, frame);
      const auto along = [&](int from) {
        return hand::HandPose{X_OD * inverse(demonstratorPoseAt(motion_, from)) *
                                  poses_[static_cast<std::size_t>(from)].X_WH,
                              {}};
      };
      const Nearest& of = nearest[k];
      roots_[k] =
          (of.before < 0   ? along(of.behind)
           : of.behind < 0 ? along(of.before)
                           : manipulation::poseBetween(along(of.before), along(of.behind),
                                                       shareAt(frame, of)))
              .X_WH;
      const double weight =
          kGoalWeight * share * (1.0 - (1.0 - kBesideContacts) * holds_.touches[k]);
      for (const Eigen::Vector3d& p_H :
           {Eigen::Vector3d(Eigen::Vector3d::Zero()), Eigen::Vector3d(kGoalReach, 0.0, 0.0),
            Eigen::Vector3d(0.0, kGoalReach, 0.0), Eigen::Vector3d(0.0, 0.0, kGoalReach)}) {
        optimize::PointPair pair;
        pair.p_L = p_H;
        pair.p_W = roots_[k] * p_H;
        pair.has_normals = false;
        pair.weight = weight;
        problem_.own[frame].pairs.push_back(pair);
      }
    }
  }

  /// The joints that look most like the posture, at the demonstrator's keys.
  void lookAlike() {
    VectorXd last = poses_.front().q;
    for (const DemonstratorKey& key : motion_.demonstrator) {
      progress_.checkpoint();
      last = placement::jointsLike(hand_, key.posture,
                                   roots_[static_cast<std::size_t>(key.frame)].linear(), last);
      looks_.push_back(last);
    }
  }

  /// The same in between.
  [[nodiscard]] double looksAt(int frame, Eigen::Index joint) const {
    const auto& keys = motion_.demonstrator;
    const auto behind =
        static_cast<std::size_t>(std::upper_bound(keys.begin(), keys.end(), frame,
                                                  [](int wanted, const DemonstratorKey& key) {
                                                    return wanted < key.frame;
                                                  }) -
                                 keys.begin());
    if (behind == 0) return looks_.front()[joint];
    if (behind == keys.size()) return looks_.back()[joint];
    const double from = timeOf(keys[behind - 1].frame);
    return std::lerp(looks_[behind - 1][joint], looks_[behind][joint],
                     (timeOf(frame) - from) / (timeOf(keys[behind].frame) - from));
  }

  void layJoints() {
    const auto dofs = static_cast<std::size_t>(problem_.model->dofCount());
    for (std::size_t j = 0; j < dofs; ++j) {
      const auto joint = static_cast<Eigen::Index>(j);
      const std::vector<double>& held = holds_.joints[j];
      const std::vector<Nearest> nearest = nearestHolds(held);
      for (std::size_t k = 0; k < held.size(); ++k) {
        if (held[k] >= 1.0) continue;
        const auto frame = static_cast<int>(k);
        const double looks = looksAt(frame, joint);
        // What holds the object looks otherwise on this hand: by so much less, the longer ago.
        const auto along = [&](int from) {
          const double differs =
              poses_[static_cast<std::size_t>(from)].q[joint] - looksAt(from, joint);
          const double ago = std::abs(timeOf(frame) - timeOf(from)) / kForgets;
          return looks + (1.0 - smoothStep(ago)) * differs;
        };
        const Nearest& of = nearest[k];
        const double goal =
            of.before < 0 && of.behind < 0 ? looks
            : of.before < 0                ? along(of.behind)
            : of.behind < 0                ? along(of.before)
                            : std::lerp(along(of.before), along(of.behind), shareAt(frame, of));
        soften(frame, j,
               std::clamp(goal, problem_.lowerAt(frame)[joint], problem_.upperAt(frame)[joint]),
               1.0 - held[k]);
      }
    }
  }

  void soften(int frame, std::size_t joint, double value, double share) {
    if (!(problem_.weights.prior > 0.0)) return;  // nothing is preferred to anything
    manipulation::FrameOwn& own = problem_.own[frame];
    const auto dofs = static_cast<std::size_t>(problem_.model->dofCount());
    own.soft_weights.resize(dofs, 0.0);
    own.soft_values.resize(dofs, 0.0);
    if (own.soft_weights[joint] > 0.0) return;
    own.soft_values[joint] = value;
    const bool slides =
        problem_.model->dofJoint(static_cast<int>(joint)).type == hand::JointType::kPrismatic;
    own.soft_weights[joint] = share * kJointWeight *
                              (slides ? manipulation::kSliderScale : 1.0) /
                              problem_.weights.prior;
  }

  [[nodiscard]] bool isOut(const hand::HandPose& pose) const {
    if (problem_.avoidance == nullptr) return true;
    return quality::measureDepth(*problem_.model, *problem_.avoidance->hand,
                                 *problem_.avoidance->object_O, pose, progress_) <= kDeepGoal;
  }

  /// Frames that nothing holds set out from their goals; where that lies in the object, from
  /// where the one nearer to what holds does.
  void setOut(const std::vector<Nearest>& nearest) {
    const auto set_out = [&](int frame, int nearer) {
      progress_.checkpoint();
      hand::HandPose goal{roots_[static_cast<std::size_t>(frame)],
                          poses_[static_cast<std::size_t>(frame)].q};
      const manipulation::FrameOwn& own = problem_.own[frame];
      for (std::size_t j = 0; j < own.soft_weights.size(); ++j)
        if (own.soft_weights[j] > 0.0)
          goal.q[static_cast<Eigen::Index>(j)] = own.soft_values[j];
      poses_[static_cast<std::size_t>(frame)] =
          isOut(goal) ? goal : poses_[static_cast<std::size_t>(nearer)];
    };
    const auto is_nearer_before = [&](int k) {
      const Nearest& of = nearest[static_cast<std::size_t>(k)];
      return of.behind < 0 || (of.before >= 0 && k - of.before <= of.behind - k);
    };
    const int count = problem_.frameCount();
    for (int k = 0; k < count; ++k)
      if (holds_.hand[static_cast<std::size_t>(k)] < 1.0 && is_nearer_before(k))
        set_out(k, k - 1);
    for (int k = count - 1; k >= 0; --k)
      if (holds_.hand[static_cast<std::size_t>(k)] < 1.0 && !is_nearer_before(k))
        set_out(k, k + 1);
  }

  const hand::Hand& hand_;
  const Motion& motion_;
  const Progress& progress_;
  MotionProblem& problem_;
  std::vector<hand::HandPose>& poses_;
  Holds holds_;
  std::vector<Pose> roots_;      ///< of each frame
  std::vector<VectorXd> looks_;  ///< of each of the demonstrator's keys
};

}  // namespace

void turnAlike(const hand::Hand& hand, const Motion& motion, MotionProblem& problem) {
  if (motion.demonstrator.empty() || !(problem.weights.prior > 0.0)) return;
  // Of the fullest frame, whose grasp is like the demonstrator's if any is.
  std::vector<int> counts(motion.time_s.size(), 0);
  for (const manipulation::PatchTrack& track : motion.tracks)
    for (int k = track.begin(); k < track.end; ++k)
      ++counts[static_cast<std::size_t>(k)];
  const auto fullest =
      static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  const DemonstratorKey& then = demonstratorNear(motion, fullest);
  contact::ContactSet shown;
  shown.posture = then.posture;
  const placement::Posture posture = placement::postureFor(hand, shown);
  if (!posture.R_OH) return;
  const Eigen::Matrix3d R_DH = then.X_OD.linear().transpose() * *posture.R_OH;
  problem.turns.clear();
  for (int k = 0; k < motion.frameCount(); ++k)
    problem.turns.push_back({demonstratorPoseAt(motion, k).linear() * R_DH, kTurnWeight});
}

bool layUnheld(const hand::Hand& hand,
               const Motion& motion,
               const manipulation::Fade& fade,
               const Progress& progress,
               MotionProblem& problem,
               std::vector<hand::HandPose>& poses_O) {
  if (motion.demonstrator.empty()) return false;
  Unheld(hand, motion, fade, progress, problem, poses_O).lay();
  return true;
}

}  // namespace handgraft::retargeting
