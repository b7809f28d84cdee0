#include "tests/bench/motions/motions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "core/base/error.h"
#include "core/hand/skin_cache.h"
#include "core/io/mesh_file.h"
#include "core/io/motion_import.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/offline_solver.h"
#include "core/manipulation/transfer_points.h"
#include "core/placement/solids.h"
#include "core/quality/penetration.h"

#include "tests/bench/motions/box_pull.h"
#include "tests/bench/motions/human_motions.h"
#include "tests/bench/motions/mjcf_hand.h"
#include "tests/bench/motions/motion_edits.h"
#include "tests/bench/motions/single_frames.h"
#include "tests/bench/skin_cache.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using manipulation::MotionOptions;
using manipulation::MotionProblem;
using manipulation::Trajectory;

struct MotionsArguments {
  std::string data;
  std::string cache = defaultCache().string();
  double smoothness = MotionOptions{}.smoothness;
  double causal_smoothness = manipulation::kCausalSmoothness;
  double fade_s = manipulation::Fade{}.seconds;
  double depth_weight = 1.0;
  double margin_m = optimize::Avoidance{}.margin_m;
  int repeat = 0;
  std::string library;
  bool edits = false;
  int single = 0;
  bool offline_only = false;
  bool no_baselines = false;
  bool human = false;
  bool live = false;
  std::string hands;
  std::string pictures;
};

/// A recorded sequence laid onto the hand that it was made for.
struct Sequence {
  std::string name;
  manipulation::Motion motion;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  MotionProblem problem;
  std::vector<hand::HandPose> author;  ///< what its splines say, in O
};

struct BenchHand {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
};

BenchHand readAllegro(const MotionsArguments& arguments) {
  const fs::path data = arguments.data;
  BenchHand hand;
  hand.model = std::make_shared<const hand::HandModel>(readAllegroMjcf(
      data / "contacts/grab_sequences/hands", data / "hands/allegro_right/meshes/visual"));
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache(arguments.cache).get(*hand.model, hand::SkinOptions(), Progress()));
  return hand;
}

Sequence readSequence(const MotionsArguments& arguments,
                      const BenchHand& hand,
                      const std::string& name,
                      const std::string& object,
                      const std::string& without) {
  const fs::path folder = fs::path(arguments.data) / "contacts/grab_sequences";
  Sequence sequence;
  sequence.name = name;
  sequence.object_O = std::make_shared<const geometry::TriangleMesh>(
      io::readMesh(fs::path(arguments.data) / "objects/grab" / (object + ".obj")).mesh);
  sequence.motion =
      io::readContactSequence(folder / ("allegro_" + name + ".json"), *sequence.object_O,
                              folder / "trajectories" / (name + "_object.smexp"));
  std::erase_if(sequence.motion.tracks, [&](const manipulation::PatchTrack& track) {
    return track.name == without;
  });
  sequence.problem = manipulation::makeMotionProblem(hand.model, sequence.motion.time_s);
  sequence.problem.tracks =
      manipulation::transferPoints(sequence.motion, *sequence.object_O, *hand.model).tracks;
  auto avoidance = std::make_shared<optimize::Avoidance>(*placement::avoidanceOf(
      hand.model, hand.skin, sequence.object_O, Pose::Identity(), Progress()));
  avoidance->weight *= arguments.depth_weight;
  avoidance->margin_m = arguments.margin_m;
  sequence.problem.avoidance = std::move(avoidance);

  const io::SplineTrajectory splines =
      io::readSplineTrajectory(folder / "trajectories" / ("allegro_" + name + "_hand.smexp"));
  const int last = sequence.motion.frameCount() - 1;
  for (int k = 0; k <= last; ++k) {
    const Eigen::VectorXd x = splines.at(static_cast<double>(k) / last);
    hand::HandPose pose;
    pose.X_WH =
        inverse(sequence.motion.X_WO[static_cast<std::size_t>(k)]) * io::poseFromSpline(x);
    // Thumb, index, middle, ring, as the bodies stand in the file.
    pose.q = x.tail(16);
    sequence.author.push_back(pose);
  }
  return sequence;
}

/// The part of a motion in which something touches.
std::pair<std::size_t, std::size_t> touchingFrames(const MotionProblem& problem) {
  std::size_t begin = problem.time_s.size();
  std::size_t end = 0;
  for (const manipulation::PairTrack& track : problem.tracks) {
    begin = std::min(begin, static_cast<std::size_t>(track.begin()));
    end = std::max(end, static_cast<std::size_t>(track.end));
  }
  return {begin, end};
}

void printRow(const Sequence& sequence,
              const BenchHand& hand,
              const char* way,
              const std::vector<hand::HandPose>& poses,
              double ms_median,
              double ms_p99) {
  const auto [begin, end] = touchingFrames(sequence.problem);
  const manipulation::FrameFit fit =
      manipulation::meanFit(manipulation::fitFrames(sequence.problem, poses));
  const manipulation::Smoothness all = manipulation::measureSmoothness(sequence.problem, poses);
  MotionProblem touching = sequence.problem;
  touching.time_s.assign(sequence.problem.time_s.begin() + static_cast<std::ptrdiff_t>(begin),
                         sequence.problem.time_s.begin() + static_cast<std::ptrdiff_t>(end));
  const manipulation::Smoothness touched = manipulation::measureSmoothness(
      touching, {poses.begin() + static_cast<std::ptrdiff_t>(begin),
                 poses.begin() + static_cast<std::ptrdiff_t>(end)});
  double depth = 0.0;
  double self = 0.0;
  int beyond = 0;
  int outside = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const quality::Penetration penetration = placement::penetrationOf(
        hand.model, hand.skin, sequence.object_O, Pose::Identity(), poses[k], {}, Progress());
    depth = std::max(depth, penetration.max_depth_m);
    self = std::max(self, penetration.self_depth_m);
    beyond += penetration.max_depth_m > 2e-3 ? 1 : 0;
    outside += (poses[k].q.array() < sequence.problem.lower.array() - 1e-9).any() ||
                       (poses[k].q.array() > sequence.problem.upper.array() + 1e-9).any()
                   ? 1
                   : 0;
  }
  std::printf(
      "| %s | %s | %.2f | %.2f | %d | %.2f | %.0f | %.0f | %.4f | %.2f | %d | %.3f | %.3f |\n",
      sequence.name.c_str(), way, fit.mean_mm, 1e3 * depth, beyond, 1e3 * self, all.rms_jerk,
      touched.rms_jerk, all.max_step, all.max_velocity, outside, ms_median, ms_p99);
  std::fflush(stdout);
}

void runSequence(const MotionsArguments& arguments,
                 const BenchHand& hand,
                 const Sequence& sequence) {
  const double frames = sequence.problem.frameCount();
  if (!arguments.offline_only)
    printRow(sequence, hand, "author's splines", sequence.author, 0.0, 0.0);

  std::vector<hand::HandPose> starts = sequence.author;
  for (hand::HandPose& start : starts)
    start.q = start.q.cwiseMax(sequence.problem.lower).cwiseMin(sequence.problem.upper);

  if (arguments.single > 0) {
    printSingleFrames(sequence.problem, starts, hand.skin, sequence.object_O,
                      static_cast<std::size_t>(arguments.single));
    return;
  }

  // === The best possible pose of some frames alone
  for (const bool avoids : {false, true}) {
    if (arguments.offline_only) break;
    MotionProblem problem = sequence.problem;
    if (!avoids) problem.avoidance = nullptr;
    const manipulation::FrameProblems single(problem, {0.0, true});
    std::vector<hand::HandPose> poses = sequence.author;
    const auto [begin, end] = touchingFrames(problem);
    std::size_t step = avoids ? 16 : 8;
    for (std::size_t k = begin; k < end; k += step)
      poses[k] = manipulation::solveSingle(problem, single, static_cast<int>(k), starts[k], {},
                                           Progress())
                     .pose;
    double sum = 0.0;
    int points = 0;
    const auto fits = manipulation::fitFrames(problem, poses);
    for (std::size_t k = begin; k < end; k += step) {
      sum += fits[k].mean_mm * fits[k].points;
      points += fits[k].points;
    }
    std::printf("every %zuth frame alone, %s: %.2f mm\n", step,
                avoids ? "out of the object" : "touch only", sum / points);
  }

  // === Causal
  if (!arguments.offline_only) {
    MotionOptions options;
    options.smoothness = arguments.causal_smoothness;
    options.fade.seconds = arguments.fade_s;
    options.fade.looks_ahead = false;
    const manipulation::FrameProblems single(sequence.problem, options.fade);
    manipulation::CausalSolver solver(sequence.problem, options);
    const int begin = manipulation::fullestBegin(sequence.problem, single);
    solver.begin(manipulation::solveSingle(sequence.problem, single, begin, starts[0], options,
                                           Progress())
                     .pose);
    std::vector<hand::HandPose> poses;
    std::vector<double> times;
    std::vector<double> evaluations;
    for (int k = 0; k < sequence.problem.frameCount(); ++k) {
      const double before = threadMilliseconds();
      const auto step = solver.follow(sequence.problem.time_s[static_cast<std::size_t>(k)],
                                      single.at(k, starts[0]));
      times.push_back(threadMilliseconds() - before);
      evaluations.push_back(step.evaluations);
      poses.push_back(step.pose);
    }
    printRow(sequence, hand, "causal", poses, quantile(times, 0.5), quantile(times, 0.99));
    std::printf("causal: evaluations %.0f (p50) %.0f (p99), ms %.3f most\n",
                quantile(evaluations, 0.5), quantile(evaluations, 0.99), quantile(times, 1.0));
  }

  // === Offline
  MotionOptions options;
  options.smoothness = arguments.smoothness;
  options.fade.seconds = arguments.fade_s;
  const double before = threadMilliseconds();
  const Trajectory trajectory =
      manipulation::solveOffline(sequence.problem, options, Progress());
  const double ms = (threadMilliseconds() - before) / frames;
  printRow(sequence, hand, "offline", trajectory.poses, ms, ms);
  std::printf("offline: %.1f evaluations a frame\n", trajectory.evaluations / frames);
  options.threads = 2;
  const Trajectory again = manipulation::solveOffline(sequence.problem, options, Progress());
  const bool same =
      std::equal(trajectory.poses.begin(), trajectory.poses.end(), again.poses.begin(),
                 [](const hand::HandPose& a, const hand::HandPose& b) {
                   return a.q == b.q && a.X_WH.matrix() == b.X_WH.matrix();
                 });
  std::printf("offline: %s bytes again, on two threads\n", same ? "the same" : "OTHER");
}

/// The motion n times there and back.
MotionProblem repeated(const MotionProblem& problem, int times) {
  MotionProblem longer = problem;
  longer.time_s.clear();
  longer.tracks.clear();
  const int frames = problem.frameCount();
  const double step = problem.time_s[1] - problem.time_s[0];
  for (int r = 0; r < times; ++r) {
    for (int k = 0; k < frames; ++k)
      longer.time_s.push_back(step * (r * frames + k));
    for (manipulation::PairTrack track : problem.tracks) {
      const bool back = r % 2 == 1;
      std::vector<manipulation::PairSpan> spans;
      if (back) {
        for (std::size_t i = track.spans.size(); i-- > 0;) {
          const int end = i + 1 < track.spans.size() ? track.spans[i + 1].begin : track.end;
          spans.push_back({r * frames + frames - end, track.spans[i].pairs});
        }
        track.end = r * frames + frames - track.begin();
      } else {
        for (manipulation::PairSpan span : track.spans) {
          span.begin += r * frames;
          spans.push_back(std::move(span));
        }
        track.end += r * frames;
      }
      track.spans = std::move(spans);
      longer.tracks.push_back(std::move(track));
    }
  }
  return longer;
}

void runGrowth(const Sequence& sequence, const MotionOptions& options, int most) {
  std::vector<double> logs_n;
  std::vector<double> logs_t;
  for (int times = 1; times <= most; times *= 2) {
    const MotionProblem longer = repeated(sequence.problem, times);
    const double before = threadMilliseconds();
    const Trajectory trajectory = manipulation::solveOffline(longer, options, Progress());
    const double ms = threadMilliseconds() - before;
    std::printf("growth: %d frames, %.3f ms a frame, %.1f evaluations a frame\n",
                longer.frameCount(), ms / longer.frameCount(),
                static_cast<double>(trajectory.evaluations) / longer.frameCount());
    std::fflush(stdout);
    logs_n.push_back(std::log(longer.frameCount()));
    logs_t.push_back(std::log(ms));
  }
  double mean_n = 0.0;
  double mean_t = 0.0;
  for (std::size_t i = 0; i < logs_n.size(); ++i) {
    mean_n += logs_n[i] / static_cast<double>(logs_n.size());
    mean_t += logs_t[i] / static_cast<double>(logs_n.size());
  }
  double above = 0.0;
  double below = 0.0;
  for (std::size_t i = 0; i < logs_n.size(); ++i) {
    above += (logs_n[i] - mean_n) * (logs_t[i] - mean_t);
    below += (logs_n[i] - mean_n) * (logs_n[i] - mean_n);
  }
  if (below > 0.0) std::printf("growth: time ~ frames^%.3f\n", above / below);
}

void runMotions(const MotionsArguments& arguments) {
  if (arguments.human) {
    if (arguments.data.empty()) rejectInput("--human: needs the folder of recordings");
    runHumanMotions(arguments.data, arguments.library, arguments.cache,
                    arguments.live           ? HumanWays::kLive
                    : arguments.no_baselines ? HumanWays::kContacts
                                             : HumanWays::kAll,
                    arguments.hands, arguments.pictures);
    return;
  }
  if (!arguments.library.empty()) {
    MotionOptions options;
    options.smoothness = arguments.smoothness;
    options.fade.seconds = arguments.fade_s;
    runBoxPull(arguments.library, arguments.cache, options);
    if (arguments.edits) runMotionEdits(arguments.library, arguments.cache);
  }
  if (arguments.data.empty()) return;
  const BenchHand hand = readAllegro(arguments);
  std::printf(
      "| sequence | way | mean mm | deepest mm | frames past 2 mm | in itself mm | jerk | jerk "
      "touching | largest step rad | velocity | frames outside limits | ms p50 | ms p99 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");

  struct Recorded {
    const char* name;
    const char* object;
    const char* without;  ///< a link whose points lie on the wrong side in the file
  };

  const Recorded recorded[] = {{"apple_pass_1", "apple", ""},
                               {"waterbottle_pour_1", "waterbottle", "allegro_wrist"}};
  for (const Recorded& one : recorded) {
    const Sequence sequence = readSequence(arguments, hand, one.name, one.object, one.without);
    runSequence(arguments, hand, sequence);
    if (arguments.repeat > 0 && &one == &recorded[0]) {
      MotionOptions options;
      options.smoothness = arguments.smoothness;
      options.fade.seconds = arguments.fade_s;
      runGrowth(sequence, options, arguments.repeat);
    }
  }
}

}  // namespace

void addMotionsCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("motions", "Recorded contact sequences followed by a hand");
  const auto arguments = std::make_shared<MotionsArguments>();
  command->add_option("data", arguments->data, "Folder of contacts, hands and objects");
  command->add_option("--library", arguments->library,
                      "The built-in models: a box is pulled off a shelf");
  command->add_option("--cache", arguments->cache, "Folder that keeps the skins")
      ->capture_default_str();
  command->add_option("--smoothness", arguments->smoothness, "Offline")->capture_default_str();
  command->add_option("--causal-smoothness", arguments->causal_smoothness, "Causal")
      ->capture_default_str();
  command->add_option("--fade", arguments->fade_s, "s")->capture_default_str();
  command->add_option("--depth-weight", arguments->depth_weight, "Times the default")
      ->capture_default_str();
  command
      ->add_option("--margin", arguments->margin_m,
                   "m that the hand stays off the object; negative: may go inside")
      ->capture_default_str();
  command->add_flag("--edits", arguments->edits,
                    "Edit a motion of 1,000 frames of the library, too");
  CLI::Option* human = command->add_flag(
      "--human", arguments->human,
      "The human's own contact areas, beside fingertip kinematics and DexPilot, and no more");
  command
      ->add_flag("--no-baselines", arguments->no_baselines,
                 "With --human: contacts alone, without fingertips and DexPilot")
      ->needs(human);
  command
      ->add_flag("--live", arguments->live, "With --human: frame by frame as they come alone")
      ->needs(human);
  command
      ->add_option("--hands", arguments->hands,
                   "With --human: by every hand of this folder instead")
      ->needs(human);
  command
      ->add_option(
          "--pictures", arguments->pictures,
          "With --live: folder for pictures of the recorded grasps, one a hand and grasp")
      ->needs(human);
  command->add_flag("--offline", arguments->offline_only, "All frames at once alone");
  command->add_option(
      "--single", arguments->single,
      "Every so-manyth frame alone, with one term after the other, and no more");
  command->add_option("--growth", arguments->repeat,
                      "Repeat the first one up to so many times");
  command->callback([arguments] {
    runMotions(*arguments);
  });
}

}  // namespace handgraft::bench
