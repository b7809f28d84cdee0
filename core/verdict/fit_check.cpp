#include "core/verdict/fit_check.h"

#include <algorithm>
#include <utility>

#include "core/geometry/tangent.h"
#include "core/optimize/diagnosis.h"
#include "core/placement/solids.h"

namespace handgraft::verdict {

namespace {

/// A found root slides a little with every solve; the body behind it stays the same.
constexpr double kSameRoot = 0.002;  // m

/// What the clearance at one patch rests on.
struct RoomKey {
  geometry::SurfacePoint root_O;
  std::optional<Eigen::Vector3d> direction_O;
  Eigen::Vector3d root_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_S = Eigen::Vector3d::Zero();

  [[nodiscard]] bool holdsFor(const RoomKey& other) const {
    constexpr double kSameDirection = 0.985;  // 10 degrees; a turn may be off by 30
    const bool same_way =
        direction_O.has_value() == other.direction_O.has_value() &&
        (!direction_O || direction_O->dot(*other.direction_O) > kSameDirection) &&
        direction_S.dot(other.direction_S) > kSameDirection;
    return same_way && root_O.face == other.root_O.face &&
           root_O.barycentric == other.root_O.barycentric &&
           (root_S - other.root_S).norm() <= kSameRoot;
  }
};

struct Clearance {
  RoomKey key;
  double missing_m = 0.0;
};

bool reachesAll(const optimize::SolveReport& answer) {
  return std::all_of(answer.patches.begin(), answer.patches.end(), [](const auto& fit) {
    return fit.mean_mm <= optimize::DiagnosisOptions().reached_mm;
  });
}

/// All that spans rest on, in numbers.
std::vector<double> spanKey(const optimize::PoseProblem& problem, const Pose& X_WO) {
  std::vector<double> key;
  const auto add = [&key](const auto& values) {
    key.insert(key.end(), values.data(), values.data() + values.size());
  };
  add(problem.lower);
  add(problem.upper);
  bool root_is_locked = false;
  for (std::size_t dof = 0; dof < problem.locked.size(); ++dof) {
    key.push_back(problem.locked[dof] ? 1.0 : 0.0);
    root_is_locked = root_is_locked || (dof < 6 && problem.locked[dof]);
    if (dof >= 6 && problem.locked[dof]) key.push_back(problem.start.q[dof - 6]);
  }
  if (root_is_locked) add(X_WO.matrix());
  for (const optimize::PointPair& pair : problem.pairs) {
    key.push_back(pair.patch);
    key.push_back(pair.link);
    key.push_back(pair.weight > 0.0 ? 1.0 : 0.0);
    add(pair.p_L);
  }
  return key;
}

}  // namespace

bool FitFindings::tooLarge() const {
  return !clearances.empty() || std::any_of(spans.begin(), spans.end(), [](const auto& span) {
    return span.lack() < 0.0;
  });
}

bool FitFindings::tooSmall() const {
  return std::any_of(spans.begin(), spans.end(), [](const auto& span) {
    return span.lack() > 0.0;
  });
}

struct FitCheck::Memory {
  std::shared_ptr<const hand::Skin> skin;
  const geometry::TriangleMesh* object = nullptr;
  std::shared_ptr<const geometry::SurfaceLocator> object_O;
  std::vector<std::optional<Clearance>> clearances;  ///< per patch of the session
  std::vector<double> span_key;
  std::vector<geometry::SurfacePoint> roots_O;  ///< outlines follow them
  FitFindings findings;

  void follow(const session::Session& session) {
    if (object == &session.object() && skin == session.hand().skin) return;
    *this = Memory();
    skin = session.hand().skin;
    object = &session.object();
    object_O = placement::locatorOf(session.sharedObject());
  }

  [[nodiscard]] double missingAt(const session::SessionPatch& item) const {
    const quality::ContactPlace place = placeOf(item);
    if (quality::isOpen(*object_O, place)) return 0.0;
    return quality::missingClearance(*object_O, quality::bodyBehind(*skin, *item.placement),
                                     place);
  }

  [[nodiscard]] quality::ContactPlace placeOf(const session::SessionPatch& item) const {
    quality::ContactPlace place;
    place.p_O = positionOf(*object, item.patch.root);
    place.n_O = normalOf(*object, item.patch.root);
    if (!item.direction_is_open && item.patch.direction_O)
      place.direction_O = tangentAt(*object, item.patch.root, *item.patch.direction_O);
    return place;
  }

  void checkClearances(const session::Session& session) {
    const std::vector<session::SessionPatch>& patches = session.patches();
    clearances.resize(patches.size());
    findings.clearances.clear();
    for (std::size_t i = 0; i < patches.size(); ++i) {
      const session::SessionPatch& item = patches[i];
      if (!item.placement || item.patch.weight == 0.0) continue;
      RoomKey key{item.patch.root, placeOf(item).direction_O,
                  positionOf(skin->mesh(), item.placement->root_S),
                  item.placement->direction_S};
      if (!clearances[i] || !clearances[i]->key.holdsFor(key)) {
        const double missing_m = missingAt(item);
        clearances[i] = Clearance{std::move(key), missing_m};
      }
      if (clearances[i]->missing_m >= quality::kToldMissing)
        findings.clearances.push_back({static_cast<int>(i), clearances[i]->missing_m});
    }
  }

  void forgetSpans() {
    findings.spans.clear();
    span_key.clear();
  }

  void checkSpans(const session::Session& session, const optimize::PoseProblem& problem) {
    std::vector<double> key = spanKey(problem, session.objectPose());
    std::vector<geometry::SurfacePoint> roots;
    for (const session::SessionPatch& item : session.patches())
      roots.push_back(item.patch.root);
    const auto is_same = [](const auto& a, const auto& b) {
      return a.face == b.face && a.barycentric == b.barycentric;
    };
    if (key == span_key &&
        std::equal(roots.begin(), roots.end(), roots_O.begin(), roots_O.end(), is_same))
      return;
    findings.spans = optimize::findSpanMisfits(problem);
    // A root that nobody chose slides to where it fits.
    std::erase_if(findings.spans, [&](const optimize::SpanMisfit& span) {
      const std::vector<session::SessionPatch>& patches = session.patches();
      return patches.at(static_cast<std::size_t>(span.patch_a)).root_is_open ||
             patches.at(static_cast<std::size_t>(span.patch_b)).root_is_open;
    });
    span_key = std::move(key);
    roots_O = std::move(roots);
  }
};

FitCheck::FitCheck() : memory_(std::make_unique<Memory>()) {}

FitCheck::~FitCheck() = default;
FitCheck::FitCheck(FitCheck&&) noexcept = default;
FitCheck& FitCheck::operator=(FitCheck&&) noexcept = default;

const FitFindings& FitCheck::of(const session::Session& session,
                                const optimize::PoseProblem& problem,
                                const optimize::SolveReport* answer) {
  memory_->follow(session);
  memory_->checkClearances(session);
  if (answer != nullptr && reachesAll(*answer)) {
    memory_->forgetSpans();
  } else {
    memory_->checkSpans(session, problem);
  }
  return memory_->findings;
}

}  // namespace handgraft::verdict
