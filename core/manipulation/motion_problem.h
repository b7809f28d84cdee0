#pragma once

#include <map>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/manipulation/motion_options.h"
#include "core/optimize/pose_problem.h"

namespace handgraft::manipulation {

/// Pairs that hold from a frame on, until the next span of the same track.
struct PairSpan {
  int begin = 0;
  /// Object side in O; `patch` is the track's number. Weights are those of full presence.
  std::vector<optimize::PointPair> pairs;
};

/// One track as a hand sees it.
struct PairTrack {
  int end = 0;
  std::vector<PairSpan> spans;  ///< by rising begin

  [[nodiscard]] int begin() const { return spans.front().begin; }
};

/// What one frame has of its own, where it was edited: all of it holds there alone.
struct FrameOwn {
  Eigen::VectorXd lower;  ///< of the joints; empty: as throughout, likewise the upper
  Eigen::VectorXd upper;
  std::map<int, double> shares;  ///< by track: its pairs weigh that many times as much
  std::map<int, double> fades;   ///< by track, in [0, 1]: so much of its presence is left
  std::vector<optimize::PointPair> pairs;  ///< of no track (`patch` is -1): places held
  std::vector<double> soft_values;         ///< of each joint, where `soft_weights` is above 0
  std::vector<double> soft_weights;        ///< beside the prior's; empty: none is held softly
};

/// How the hand prefers to be turned.
struct FrameTurn {
  Eigen::Matrix3d R_OH = Eigen::Matrix3d::Identity();
  double weight = 0.0;  ///< 1/rad^2, of what differs from that
};

/// A motion laid onto a hand: all that solving needs.
///
/// Poses are those of the hand in the object's frame, X_OH: contacts stand still there while
/// the object moves, so what is smooth is the hand's way over the object, and an object that
/// jumps takes the hand along.
struct MotionProblem {
  std::shared_ptr<const hand::HandModel> model;
  std::vector<double> time_s;  ///< rising
  std::vector<PairTrack> tracks;
  optimize::Weights weights;
  optimize::NormalForm normal_form = optimize::NormalForm::kCosine;
  Eigen::VectorXd prior;  ///< joints that the hand stays close to
  Eigen::VectorXd lower;
  Eigen::VectorXd upper;
  Eigen::VectorXd velocity_limit;  ///< rad/s, m/s of each joint; infinite where there is none
  Eigen::VectorXd acceleration_limit;  ///< likewise
  std::map<int, FrameOwn> own;         ///< by frame
  /// How the hand is turned where contacts leave that open, of each frame; empty: anyhow.
  std::vector<FrameTurn> turns;
  /// Solids of hand and object; missing: penetration costs nothing.
  std::shared_ptr<const optimize::Avoidance> avoidance;

  [[nodiscard]] int frameCount() const { return static_cast<int>(time_s.size()); }

  /// Of the joints at a frame.
  [[nodiscard]] const Eigen::VectorXd& lowerAt(int frame) const;
  [[nodiscard]] const Eigen::VectorXd& upperAt(int frame) const;
};

/// A problem of a hand without contacts yet: limits from the model, the prior at rest.
MotionProblem makeMotionProblem(std::shared_ptr<const hand::HandModel> model,
                                std::vector<double> time_s);

/// Sizes, finiteness, times that rise, spans within the frames. InvalidInput names the fault.
void validate(const MotionProblem& problem);

/// How much of a track is there at a frame, in [0, 1]: it comes and goes over `fade.seconds`,
/// about the times at which it appears and vanishes or, where nothing ahead may be known, from
/// them on. What is there when the motion begins or ends does not fade there.
double presenceAt(const MotionProblem& problem,
                  const PairTrack& track,
                  int frame,
                  const Fade& fade);

/// The single frames of a motion.
class FrameProblems {
 public:
  /// Keeps a reference. Cost: O(frames + the tracks' lengths).
  FrameProblems(const MotionProblem& problem, const Fade& fade);

  /// A track that is there, if only in part.
  struct Present {
    int track = 0;
    double presence = 1.0;
  };

  [[nodiscard]] const std::vector<Present>& presentAt(int frame) const {
    return present_.at(static_cast<std::size_t>(frame));
  }

  /// Eq. 2 of one frame in O: limits and prior of the motion, the pairs that are there, weighed
  /// by their presence. The root has no prior but for how it is turned. Cost: O(pairs).
  [[nodiscard]] optimize::PoseProblem at(int frame, const hand::HandPose& start) const;

 private:
  const MotionProblem& problem_;
  std::vector<std::vector<Present>> present_;
};

/// Frames at which a track appears or vanishes, those within `seconds` of the last one left
/// out; the first frame that has contacts is the first. Empty without contacts.
std::vector<int> contactChanges(const MotionProblem& problem, double seconds);

}  // namespace handgraft::manipulation
