#include "core/sweep/sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/hand/skin_bending.h"
#include "core/optimize/diagnosis.h"
#include "core/optimize/solver.h"
#include "core/optimize/worker_pool.h"
#include "core/placement/solids.h"
#include "core/sweep/sweep_grasp.h"
#include "core/sweep/sweep_motion.h"

namespace handgraft::sweep {
namespace {

using optimize::PoseProblem;

/// Digits of a number whose places have the sizes of the axes, the first axis slowest.
using Combination = std::vector<std::size_t>;

std::vector<Combination> combinationsOf(const std::vector<SweepAxis>& axes) {
  std::vector<Combination> all{Combination()};
  for (const SweepAxis& axis : axes) {
    std::vector<Combination> longer;
    for (const Combination& one : all) {
      for (std::size_t i = 0; i < axis.values.size(); ++i) {
        longer.push_back(one);
        longer.back().push_back(i);
      }
    }
    all = std::move(longer);
  }
  return all;
}

enum class Which { kAll, kShape };

std::vector<hand::HandChange> changesOf(const std::vector<SweepAxis>& axes,
                                        const Combination& combination,
                                        Which which) {
  std::vector<hand::HandChange> changes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (which == Which::kShape && !hand::changesShape(axes[i].property)) continue;
    changes.push_back({axes[i].property, axes[i].target, axes[i].values[combination[i]]});
  }
  return changes;
}

std::string nameOf(const SweepAxis& axis) {
  return (axis.target.empty() ? "hand" : axis.target) + "." + hand::nameOf(axis.property);
}

void requireSound(const hand::Hand& hand,
                  const std::vector<SweepGrasp>& grasps,
                  const std::vector<SweepAxis>& axes,
                  const SweepOptions& options) {
  if (grasps.empty()) rejectInput("sweep: there is no grasp; at least one is needed");
  validate(options.solving);
  validate(options.transfer);
  std::set<std::string> names;
  double rows = static_cast<double>(grasps.size());
  for (const SweepAxis& axis : axes) {
    const std::string name = nameOf(axis);
    if (axis.values.empty()) rejectInput("sweep: {} has no values", quoted(name));
    if (!names.insert(name).second) rejectInput("sweep: {} is varied twice", quoted(name));
    for (const double value : axis.values)
      hand::validate(*hand.model, {axis.property, axis.target, value});
    rows *= static_cast<double>(axis.values.size());
  }
  if (rows > static_cast<double>(kMostSweepRows))
    rejectInput("sweep: {} grasps with these values are {:.0f} rows; at most {} are permitted",
                grasps.size(), rows, kMostSweepRows);
}

void fill(const PoseProblem& problem,
          const std::vector<session::SessionPatch>& patches,
          const optimize::SolveReport& report,
          SweepRow& row) {
  row.outcome = report.outcome;
  row.terms = report.terms;
  row.q = report.pose.q;
  const std::vector<double> facing_deg = optimize::facingAngles(problem, report);
  double sum_mm = 0.0;
  double sum_deg = 0.0;
  for (std::size_t i = 0; i < report.patches.size(); ++i) {
    const optimize::PatchFit& fit = report.patches[i];
    if (patches[static_cast<std::size_t>(fit.patch)].patch.weight == 0.0) continue;
    row.point_count += fit.point_count;
    sum_mm += fit.point_count * fit.mean_mm;
    sum_deg += fit.point_count * fit.normal_mean_deg;
    row.max_mm = std::max(row.max_mm, fit.max_mm);
    if (fit.point_count > 0 && optimize::isReached(fit.mean_mm, facing_deg[i]))
      ++row.reached_count;
  }
  for (const session::SessionPatch& item : patches)
    if (item.placement && item.patch.weight > 0.0) ++row.patch_count;
  if (row.point_count > 0) {
    row.mean_mm = sum_mm / row.point_count;
    row.normal_deg = sum_deg / row.point_count;
  }
  for (const optimize::ActiveLimit& limit : report.active_limits)
    row.joints_at_limit.push_back({problem.model->dofJoint(limit.dof).name, limit.upper});
}

/// Calls `task` for all indices, on the pool if there is one. From one thread at a time.
template <class Task>
void forEach(optimize::WorkerPool* pool, std::size_t count, const Task& task) {
  if (pool == nullptr) {
    for (std::size_t i = 0; i < count; ++i)
      task(i);
    return;
  }
  pool->run(static_cast<int>(count), [&](int /*worker*/, int index) {
    task(static_cast<std::size_t>(index));
  });
}

class Sweep {
 public:
  Sweep(const hand::Hand& hand,
        const std::vector<SweepGrasp>& grasps,
        const std::vector<SweepAxis>& axes,
        const SweepOptions& options,
        const Progress& progress)
      : hand_(hand),
        grasps_(grasps),
        axes_(axes),
        options_(options),
        progress_(progress),
        quiet_(progress, {}),
        pool_(std::max(1, options.threads)),
        combinations_(combinationsOf(axes)),
        rows_(combinations_.size() * grasps.size()) {
    if (!hand_.skin_maps) {
      // Shared by all grasps: what heat methods factor is made once.
      hand_.skin_maps = std::make_shared<const geometry::LogMapper>(
          std::shared_ptr<const geometry::TriangleMesh>(hand_.skin, &hand_.skin->mesh()));
    }
  }

  SweepResult run() {
    solveBases();
    // === Combinations by the shape that they give the hand
    std::map<Combination, std::vector<std::size_t>> by_shape;
    for (std::size_t c = 0; c < combinations_.size(); ++c) {
      Combination shape;
      for (std::size_t a = 0; a < axes_.size(); ++a)
        if (hand::changesShape(axes_[a].property)) shape.push_back(combinations_[c][a]);
      by_shape[shape].push_back(c);
    }
    std::vector<std::vector<std::size_t>> shapes;
    shapes.reserve(by_shape.size());
    for (auto& [shape, combinations] : by_shape)
      shapes.push_back(std::move(combinations));
    if (shapes.size() == 1) {
      sweepShape(shapes.front(), &pool_);
    } else {
      // A shape a task: as many bent skins live at a time as there are threads.
      bending_.emplace(hand_.model, hand_.skin);
      forEach(&pool_, shapes.size(), [&](std::size_t i) {
        sweepShape(shapes[i], nullptr);
      });
    }
    SweepResult result;
    result.rows = std::move(rows_);
    for (std::size_t i = 0; i < grasps_.size(); ++i)
      result.notes.push_back(grasps_[i].motion ? motions_[i].notes() : bases_[i].notes);
    return result;
  }

 private:
  void solveBases() {
    bases_.resize(grasps_.size());
    motions_.resize(grasps_.size());
    const auto solve_one = [&](std::size_t i) {
      const int threads = grasps_.size() == 1 ? options_.threads : 1;
      if (grasps_[i].motion)
        motions_[i] = solveMotionBase(hand_, grasps_[i], options_, threads, quiet_);
      else
        bases_[i] = solveBase(hand_, grasps_[i], options_, threads, quiet_);
      tell("solving the grasps on the hand as it is", grasps_.size());
    };
    forEach(grasps_.size() == 1 ? nullptr : &pool_, grasps_.size(), solve_one);
    told_ = 0;
  }

  /// All rows of the combinations, which have one shape.
  void sweepShape(const std::vector<std::size_t>& combinations, optimize::WorkerPool* pool) {
    const std::vector<hand::HandChange> changes =
        changesOf(axes_, combinations_[combinations.front()], Which::kShape);
    std::optional<transfer::Surfaces> bent;
    std::shared_ptr<const hand::HandSolid> solid;
    if (!changes.empty()) {
      const hand::HandVariant variant =
          hand::makeVariant(*hand_.model, hand_.model->name(), changes);
      if (variant.shape_changed) {
        bent = bentSurfaces(variant);
        solid = std::make_shared<const hand::HandSolid>(variant.model, *bent->skin, progress_);
      }
    }
    if (solid == nullptr) solid = placement::solidOf(hand_.model, hand_.skin, quiet_);
    std::vector<TransferredGrasp> laid(grasps_.size());
    std::vector<LaidSweepMotion> laid_motions(grasps_.size());
    forEach(pool, grasps_.size(), [&](std::size_t i) {
      const transfer::Surfaces* onto = bent ? &*bent : nullptr;
      if (grasps_[i].motion)
        laid_motions[i] = layMotion(motions_[i], hand_, *grasps_[i].object_O, onto,
                                    options_.transfer, quiet_);
      else
        laid[i] = layGrasp(bases_[i], *hand_.skin, onto, options_.transfer, quiet_);
    });
    forEach(pool, combinations.size() * grasps_.size(), [&](std::size_t i) {
      const std::size_t combination = combinations[i / grasps_.size()];
      const std::size_t grasp = i % grasps_.size();
      rows_[combination * grasps_.size() + grasp] = solveRow(
          combination, grasp, laid[grasp], laid_motions[grasp], bent ? &*bent : nullptr, solid);
      tell("sweeping", rows_.size());
    });
  }

  transfer::Surfaces bentSurfaces(const hand::HandVariant& variant) {
    if (!bending_) bending_.emplace(hand_.model, hand_.skin);
    transfer::Surfaces surfaces;
    surfaces.skin = bending_->bent(variant);
    surfaces.skin_S = std::make_shared<const geometry::LogMapper>(
        std::shared_ptr<const geometry::TriangleMesh>(surfaces.skin, &surfaces.skin->mesh()));
    return surfaces;
  }

  /// `bent`, if any, and `solid`: the hand's, of this shape.
  SweepRow solveRow(std::size_t combination,
                    std::size_t grasp,
                    const TransferredGrasp& laid,
                    const LaidSweepMotion& laid_motion,
                    const transfer::Surfaces* bent,
                    const std::shared_ptr<const hand::HandSolid>& solid) {
    progress_.checkpoint();
    SweepRow row;
    row.grasp = static_cast<int>(grasp);
    for (std::size_t a = 0; a < axes_.size(); ++a)
      row.values.push_back(axes_[a].values[combinations_[combination][a]]);
    const bool is_motion = grasps_[grasp].motion != nullptr;
    row.error = is_motion ? laid_motion.error : laid.error;
    if (!row.error.empty()) return row;
    try {
      const hand::HandVariant variant = hand::makeVariant(
          *hand_.model, hand_.model->name(),
          changesOf(axes_, combinations_[combination], Which::kAll),
          is_motion ? hand::VariantSurfaces::kLeftOut : hand::VariantSurfaces::kStretched);
      const auto solids = std::make_shared<optimize::Avoidance>();
      solids->hand = solid;
      solids->object_O = placement::solidOf(grasps_[grasp].object_O, quiet_);
      const auto begin = std::chrono::steady_clock::now();
      if (is_motion)
        solveMotionRow(motions_[grasp], laid_motion, variant, solids, quiet_, row);
      else
        solveGrasp(grasp, laid, variant, bent, solids, row);
      const std::chrono::duration<double, std::milli> spent =
          std::chrono::steady_clock::now() - begin;
      row.solve_ms = spent.count();
    } catch (const InvalidInput& error) {
      row.error = error.what();
    }
    return row;
  }

  /// The better of what a session finds that is opened on the variant, and of the places and
  /// directions that the grasp has on the hand as it is.
  void solveGrasp(std::size_t grasp,
                  const TransferredGrasp& laid,
                  const hand::HandVariant& variant,
                  const transfer::Surfaces* bent,
                  const std::shared_ptr<const optimize::Avoidance>& solids,
                  SweepRow& row) {
    hand::Hand hand = hand_;
    hand.model = std::make_shared<const hand::HandModel>(variant.model);
    hand.sites = hand::sitesOfVariant(variant, hand_.sites);
    if (bent != nullptr) {
      hand.skin = bent->skin;
      hand.skin_maps = bent->skin_S;
    }
    placement::shareSolid(hand.model, solids->hand);
    const session::Solution anew = solveAnew(hand, grasps_[grasp], options_, 1, quiet_);
    std::optional<session::Solution> kept;
    if (!laid.pairs.empty())
      kept = solveKept(bases_[grasp], laid, variant, solids, options_, quiet_);
    const session::Solution& best = kept ? betterOf(anew, *kept) : anew;
    fill(best.problem, best.patches, best.report, row);
    row.depths =
        quality::measureDepths(*best.problem.model, *solids->hand, *solids->object_O,
                               best.report.pose, quiet_, session::contactSides(best.patches));
  }

  /// One more of `count` is done.
  void tell(const char* stage, std::size_t count) {
    const std::lock_guard lock(mutex_);
    progress_.report(stage, static_cast<double>(++told_) / static_cast<double>(count));
  }

  hand::Hand hand_;
  const std::vector<SweepGrasp>& grasps_;
  const std::vector<SweepAxis>& axes_;
  const SweepOptions& options_;
  const Progress& progress_;
  const Progress quiet_;  ///< several threads work: the stages of each would be noise
  optimize::WorkerPool pool_;
  std::vector<Combination> combinations_;
  std::vector<SweepRow> rows_;
  std::vector<SweepBase> bases_;
  std::vector<SweepMotionBase> motions_;
  std::optional<hand::SkinBending> bending_;
  std::mutex mutex_;
  std::size_t told_ = 0;
};

}  // namespace

SweepResult sweep(const hand::Hand& hand,
                  const std::vector<SweepGrasp>& grasps,
                  const std::vector<SweepAxis>& axes,
                  const SweepOptions& options,
                  const Progress& progress) {
  HANDGRAFT_REQUIRE(hand.model != nullptr && hand.skin != nullptr);
  requireSound(hand, grasps, axes, options);
  return Sweep(hand, grasps, axes, options, progress).run();
}

}  // namespace handgraft::sweep
