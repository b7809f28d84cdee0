#pragma once

#include <random>
#include <string>

#include "core/session/session.h"

namespace handgraft::test {

/// Edits of every kind that fit a session as it stands, and some that do not.
class RandomEdits {
 public:
  explicit RandomEdits(unsigned seed) : random_(seed) {}

  session::Edit next(const session::Session& session) {
    using namespace session;  // NOLINT(google-build-using-namespace): a list of its types
    const Document& document = session.document();
    const hand::HandModel& model = *session.hand().model;
    const DocumentPatch& patch = document.patches[below(document.patches.size())];
    const auto dof = below(document.joints.size());
    const DocumentJoint& joint = document.joints[dof];
    const std::string name = model.dofJoint(static_cast<int>(dof)).name;
    const double inside = joint.lower + uniform(0, 1) * (joint.upper - joint.lower);
    const Side side = below(2) == 0 ? Side::kHand : Side::kObject;
    switch (below(27)) {
      case 0:
        return ObjectPoseEdit{near(document.X_WO, 0.01)};
      case 1:
        return PatchWeightEdit{patch.name, uniform(0.1, 2)};
      case 2:
        return PatchEnabledEdit{patch.name, below(3) != 0};
      case 3:
      case 4: {
        const geometry::TriangleMesh& mesh =
            side == Side::kHand ? session.hand().skin->mesh() : session.object();
        const geometry::SurfacePoint at = side == Side::kObject ? patch.root_O
                                          : patch.placement     ? patch.placement->root_S
                                                                : geometry::SurfacePoint{0, {}};
        // A neighbour, so that patches stay where fingers are.
        const int vertex = mesh.face(at.face)[static_cast<Eigen::Index>(below(3))];
        return PatchRootEdit{patch.name, side, surfacePointAtVertex(mesh, vertex)};
      }
      case 5:
      case 6:
        return PatchDirectionEdit{patch.name, side, uniform(-1, 1)};
      case 7:
        return JointLimitEdit{name, joint.lower, std::max(inside, joint.lower + 0.01)};
      case 8:
        return JointLimitEdit{name, model.lower()[static_cast<Eigen::Index>(dof)],
                              model.upper()[static_cast<Eigen::Index>(dof)]};
      case 9:
        return JointLockEdit{name, below(3) == 0};
      case 10:
        return JointSoftEdit{name, inside, below(2) == 0 ? 0.0 : uniform(1, 100)};
      case 11:
        return PriorEdit{std::nullopt, {name}, {inside}};
      case 12:
        return PriorEdit{near(document.start.X_WH, 0.005), {}, {}};
      case 13:
        return WeightsEdit{{uniform(5e3, 2e4), uniform(0.5, 2), 1e-3}};
      case 14:
        return PriorSharesEdit{{uniform(0, 2), uniform(0, 2), uniform(0, 2), uniform(0, 90)}};
      case 15: {
        SolverSettings solving;
        solving.seed = static_cast<unsigned>(below(100));
        solving.starts = 1 + static_cast<int>(below(4));
        return SolverSettingsEdit{solving};
      }
      case 16:
      case 17: {
        const auto link = below(static_cast<std::size_t>(model.linkCount()));
        const Pose X_WL = forwardKinematics(model, document.start)[link];
        DragEdit drag{model.links()[link].name, {0, 0, 0.01}, {}, std::nullopt};
        drag.target_W = near(X_WL, 0.01) * drag.p_L;
        if (below(4) == 0) drag.target_R_WL = near(X_WL, 0.01).linear();
        if (below(4) == 0) drag.weight = uniform(0, 2);
        return drag;
      }
      case 25:
        return ReleaseEdit{document.held.empty() || below(4) == 0 ? std::string()
                                                                  : document.held[0].link};
      case 18:
        return ChoiceEdit{static_cast<int>(below(4)), std::nullopt};
      case 19: {
        const char* names[] = {"hand", "bent", "found", "none"};
        return HandEdit{names[below(4)]};
      }
      case 20: {
        const char* names[] = {"object", "shaved", "speck", "none"};
        return ObjectEdit{names[below(4)]};
      }
      case 21:
        return UndoEdit{1 + static_cast<int>(below(3))};
      case 22:
        return RedoEdit{1 + static_cast<int>(below(3))};
      case 23:
        return SnapshotEdit{std::string(1, static_cast<char>('a' + below(3)))};
      case 24:
        return RestoreEdit{std::string(1, static_cast<char>('a' + below(4)))};
      default:
        return PatchWeightEdit{patch.name, -1.0};
    }
  }

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(random_() - random_.min()) /
                     static_cast<double>(random_.max() - random_.min());
  }

  std::size_t below(std::size_t count) { return random_() % count; }

 private:
  Pose near(const Pose& X, double way_m) {
    Pose moved = X;
    const auto some = [&] {
      return Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    };
    moved.translation() += way_m * some();
    moved.linear() = rotationFromVector(20.0 * way_m * some()) * X.linear();
    return moved;
  }

  std::mt19937 random_;
};

}  // namespace handgraft::test
