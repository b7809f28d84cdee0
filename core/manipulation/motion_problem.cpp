#include "core/manipulation/motion_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/smooth_step.h"

namespace handgraft::manipulation {

namespace {

constexpr int kFewestAtOnce = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The span that holds at a frame, the nearest one where the track is not there.
const PairSpan& spanAt(const PairTrack& track, int frame) {
  const auto behind = std::upper_bound(track.spans.begin(), track.spans.end(), frame,
                                       [](int at, const PairSpan& span) {
                                         return at < span.begin;
                                       });
  return behind == track.spans.begin() ? *behind : *(behind - 1);
}

void requireRisingTimes(const std::vector<double>& time_s) {
  if (time_s.empty()) rejectInput("a motion of 0 frames; 1 at least is needed");
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    if (!std::isfinite(time_s[k]))
      rejectInput("frame {}: time is {} s; it must be finite", k, time_s[k]);
    if (k > 0 && !(time_s[k] > time_s[k - 1])) {
      rejectInput("frame {}: time {} s does not lie behind the frame before it, {} s", k,
                  time_s[k], time_s[k - 1]);
    }
  }
}

/// Of values that each joint of the hand has one of.
void requireOneForEachJoint(const MotionProblem& problem,
                            const char* name,
                            const Eigen::VectorXd& values) {
  if (values.size() != problem.model->dofCount())
    rejectInput("{} has {} entries; the hand has {} joints", name, values.size(),
                problem.model->dofCount());
  if (values.array().isNaN().any()) rejectInput("{} is not a number", name);
}

void requireJointLimits(const MotionProblem& problem) {
  requireOneForEachJoint(problem, "prior", problem.prior);
  requireOneForEachJoint(problem, "lower limit", problem.lower);
  requireOneForEachJoint(problem, "upper limit", problem.upper);
  requireOneForEachJoint(problem, "velocity limit", problem.velocity_limit);
  requireOneForEachJoint(problem, "acceleration limit", problem.acceleration_limit);
  for (int i = 0; i < problem.model->dofCount(); ++i) {
    if (problem.lower[i] > problem.upper[i])
      rejectInput("joint '{}': lower limit {} lies above its upper one {}",
                  problem.model->dofJoint(i).name, problem.lower[i], problem.upper[i]);
    if (!(problem.velocity_limit[i] > 0.0) || !(problem.acceleration_limit[i] > 0.0))
      rejectInput("joint '{}': limits of velocity {} and acceleration {} must lie above 0",
                  problem.model->dofJoint(i).name, problem.velocity_limit[i],
                  problem.acceleration_limit[i]);
  }
}

/// What an edit has laid onto one frame.
void requireOwnOfFrame(const MotionProblem& problem, int frame, const FrameOwn& own) {
  HANDGRAFT_REQUIRE(frame >= 0 && frame < problem.frameCount());
  HANDGRAFT_REQUIRE(own.soft_weights.size() == own.soft_values.size());
  const Eigen::VectorXd& lower = problem.lowerAt(frame);
  const Eigen::VectorXd& upper = problem.upperAt(frame);
  requireOneForEachJoint(problem, "lower limit at a frame", lower);
  requireOneForEachJoint(problem, "upper limit at a frame", upper);
  for (int i = 0; i < problem.model->dofCount(); ++i)
    if (lower[i] > upper[i])
      rejectInput("joint '{}', frame {}: lower limit {} lies above its upper one {}",
                  problem.model->dofJoint(i).name, frame, lower[i], upper[i]);
}

void requirePairsOnHand(const hand::HandModel& model, std::size_t track, const PairSpan& span) {
  for (const optimize::PointPair& pair : span.pairs) {
    if (pair.link < 0 || pair.link >= model.linkCount())
      rejectInput("track {}: a pair lies on link {}; the hand has {}", track, pair.link,
                  model.linkCount());
    if (!pair.p_L.allFinite() || !pair.p_W.allFinite() || !(pair.weight >= 0.0) ||
        !std::isfinite(pair.weight))
      rejectInput("track {}: a pair at frame {} is not finite", track, span.begin);
  }
}

void requireSpansWithin(const MotionProblem& problem, std::size_t number) {
  const PairTrack& track = problem.tracks[number];
  int before = -1;
  if (track.spans.empty()) rejectInput("track {} has no span", number);
  for (const PairSpan& span : track.spans) {
    if (span.begin <= before || span.begin >= problem.frameCount())
      rejectInput("track {}: a span begins at frame {}; permitted are {} to {}", number,
                  span.begin, before + 1, problem.frameCount() - 1);
    before = span.begin;
    requirePairsOnHand(*problem.model, number, span);
  }
  if (track.end <= before || track.end > problem.frameCount())
    rejectInput("track {} ends at frame {}; permitted are {} to {}", number, track.end,
                before + 1, problem.frameCount());
}

/// Of a track's presence at a frame, where an edit lets it fade there.
double leftByEdit(const MotionProblem& problem, int frame, int track) {
  const auto own = problem.own.find(frame);
  if (own == problem.own.end()) return 1.0;
  const auto fade = own->second.fades.find(track);
  return fade == own->second.fades.end() ? 1.0 : fade->second;
}

/// What a frame has of its own, joined to what it has of the motion.
void addOwn(const FrameOwn& own, optimize::PoseProblem& single) {
  single.pairs.insert(single.pairs.end(), own.pairs.begin(), own.pairs.end());
  // Two quadratics of a joint, the prior's and what holds it softly, are one.
  for (std::size_t i = 0; i < own.soft_weights.size(); ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    const double soft = own.soft_weights[i];
    if (!(soft > 0.0)) continue;
    const double all = single.prior_weights[6 + joint] + soft;
    single.prior.q[joint] =
        (single.prior_weights[6 + joint] * single.prior.q[joint] + soft * own.soft_values[i]) /
        all;
    single.prior_weights[6 + joint] = all;
  }
}

}  // namespace

void validate(const MotionOptions& options) {
  const auto require = [](const char* name, double value, double most) {
    if (!(value >= 0.0) || value > most)
      rejectInput("{} is {}; permitted are 0 to {}", name, value, most);
  };
  require("smoothness", options.smoothness, 1e12);
  require("fade", options.fade.seconds, 60.0);
  require("starts", options.starts, 1e6);
  if (options.frames_at_once < kFewestAtOnce)
    rejectInput("frames at once: {} must be at least {}", options.frames_at_once,
                kFewestAtOnce);
  if (options.threads < 1 || options.threads > 256)
    rejectInput("threads: {} must lie in 1 to 256", options.threads);
}

MotionProblem makeMotionProblem(std::shared_ptr<const hand::HandModel> model,
                                std::vector<double> time_s) {
  HANDGRAFT_REQUIRE(model != nullptr);
  MotionProblem problem;
  problem.time_s = std::move(time_s);
  problem.prior = model->restPose();
  problem.lower = model->lower();
  problem.upper = model->upper();
  const int dofs = model->dofCount();
  problem.velocity_limit = Eigen::VectorXd::Constant(dofs, kInfinity);
  problem.acceleration_limit = Eigen::VectorXd::Constant(dofs, kInfinity);
  for (int i = 0; i < dofs; ++i) {
    const double limit = model->dofJoint(i).velocity_limit;
    if (limit > 0.0) problem.velocity_limit[i] = limit;
  }
  problem.model = std::move(model);
  return problem;
}

const Eigen::VectorXd& MotionProblem::lowerAt(int frame) const {
  const auto found = own.find(frame);
  return found == own.end() || found->second.lower.size() == 0 ? lower : found->second.lower;
}

const Eigen::VectorXd& MotionProblem::upperAt(int frame) const {
  const auto found = own.find(frame);
  return found == own.end() || found->second.upper.size() == 0 ? upper : found->second.upper;
}

void validate(const MotionProblem& problem) {
  HANDGRAFT_REQUIRE(problem.model != nullptr);
  requireRisingTimes(problem.time_s);
  requireJointLimits(problem);
  HANDGRAFT_REQUIRE(problem.turns.empty() || problem.turns.size() == problem.time_s.size());
  for (const auto& [frame, own] : problem.own)
    requireOwnOfFrame(problem, frame, own);
  for (std::size_t t = 0; t < problem.tracks.size(); ++t)
    requireSpansWithin(problem, t);
}

double presenceAt(const MotionProblem& problem,
                  const PairTrack& track,
                  int frame,
                  const Fade& fade) {
  const bool there = frame >= track.begin() && frame < track.end;
  if (!(fade.seconds > 0.0)) return there ? 1.0 : 0.0;
  const auto time_of = [&](int k) {
    return problem.time_s[static_cast<std::size_t>(k)];
  };
  // A change lies half way between two frames.
  const auto change_before = [&](int k) {
    return 0.5 * (time_of(k - 1) + time_of(k));
  };
  const double now = time_of(frame);
  const double lead = fade.looks_ahead ? 0.5 * fade.seconds : 0.0;
  double presence = 1.0;
  if (track.begin() > 0) {
    presence = std::min(presence,
                        smoothStep((now - change_before(track.begin()) + lead) / fade.seconds));
  }
  if (track.end < problem.frameCount()) {
    presence = std::min(
        presence, smoothStep(1.0 - (now - change_before(track.end) + lead) / fade.seconds));
  }
  return presence;
}

FrameProblems::FrameProblems(const MotionProblem& problem, const Fade& fade)
    : problem_(problem), present_(problem.time_s.size()) {
  for (std::size_t t = 0; t < problem.tracks.size(); ++t) {
    const PairTrack& track = problem.tracks[t];
    const auto note = [&](int frame) {
      double presence = presenceAt(problem, track, frame, fade);
      if (presence <= 0.0) return false;
      presence *= leftByEdit(problem, frame, static_cast<int>(t));
      if (presence <= 0.0) return true;
      present_[static_cast<std::size_t>(frame)].push_back({static_cast<int>(t), presence});
      return true;
    };
    // Outwards from where it is, until it has faded.
    for (int frame = track.begin() - 1; frame >= 0 && note(frame);)
      --frame;
    for (int frame = track.begin(); frame < track.end; ++frame)
      note(frame);
    for (int frame = track.end; frame < problem.frameCount() && note(frame);)
      ++frame;
  }
}

optimize::PoseProblem FrameProblems::at(int frame, const hand::HandPose& start) const {
  optimize::PoseProblem single;
  single.model = problem_.model;
  single.weights = problem_.weights;
  single.normal_form = problem_.normal_form;
  single.start = start;
  single.prior = {start.X_WH, problem_.prior};
  single.lower = problem_.lowerAt(frame);
  single.upper = problem_.upperAt(frame);
  single.prior_weights = Eigen::VectorXd::Ones(single.dofCount());
  single.prior_weights.head<6>().setZero();
  if (!problem_.turns.empty() && problem_.weights.prior > 0.0) {
    const FrameTurn& turn = problem_.turns[static_cast<std::size_t>(frame)];
    single.prior.X_WH.linear() = turn.R_OH;
    single.prior_weights.head<3>().setConstant(turn.weight / problem_.weights.prior);
  }
  single.avoidance = problem_.avoidance;
  const auto found = problem_.own.find(frame);
  const FrameOwn* own = found == problem_.own.end() ? nullptr : &found->second;
  for (const Present& present : presentAt(frame)) {
    double share = present.presence;
    if (own != nullptr)
      if (const auto edited = own->shares.find(present.track); edited != own->shares.end())
        share *= edited->second;
    const PairTrack& track = problem_.tracks[static_cast<std::size_t>(present.track)];
    for (const optimize::PointPair& pair : spanAt(track, frame).pairs) {
      single.pairs.push_back(pair);
      single.pairs.back().weight *= share;
    }
  }
  if (own != nullptr) addOwn(*own, single);
  return single;
}

std::vector<int> contactChanges(const MotionProblem& problem, double seconds) {
  std::vector<int> frames;
  for (const PairTrack& track : problem.tracks) {
    frames.push_back(track.begin());
    frames.push_back(std::min(track.end, problem.frameCount() - 1));
  }
  std::sort(frames.begin(), frames.end());
  std::vector<int> kept;
  for (const int frame : frames) {
    if (!kept.empty() && problem.time_s[static_cast<std::size_t>(frame)] -
                                 problem.time_s[static_cast<std::size_t>(kept.back())] <
                             seconds)
      continue;
    kept.push_back(frame);
  }
  return kept;
}

}  // namespace handgraft::manipulation
