#include "client/editor/edit_builders.h"

#include <cmath>
#include <fstream>
#include <numbers>

#include <Eigen/Geometry>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/editor/command_table.h"
#include "client/link/surface_pick.h"
#include "core/base/error.h"

#include "tests/client/editor/small_context.h"
#include "tests/support/shared_data.h"

namespace handgraft::client::editor {
namespace {

using testing::AllOf;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;

class EditMaking : public testing::Test {
 protected:
  v1::EditBody edit(const std::string& line) {
    const Parsed parsed = parse(commandsOf(line).at(0), test::smallNames());
    return parsed.command->make(parsed.match, context);
  }

  std::string objectionTo(const std::string& line) {
    try {
      edit(line);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  test::SmallContext context;
};

TEST_F(EditMaking, PicksTheSkinsPlaceUnderASite) {
  // The site lies at (0.1, 0.2, 0.3) in S; the skin is the plane z = 0.
  const v1::EditBody body = edit("root thumb hand pick index");
  EXPECT_EQ(body.patch_root().patch(), "thumb");
  EXPECT_EQ(body.patch_root().side(), v1::SIDE_HAND);
  const Eigen::Vector3d p = positionOf(context.hand().skin_S(), body.patch_root().root());
  EXPECT_NEAR((p - Eigen::Vector3d(0.1, 0.2, 0.0)).norm(), 0.0, 1e-12);
}

TEST_F(EditMaking, TakesTheNearestPlaceOfASurface) {
  const v1::EditBody body = edit("root index object at 1.03 0.25 -1cm");
  EXPECT_EQ(body.patch_root().side(), v1::SIDE_OBJECT);
  const Eigen::Vector3d p = positionOf(context.object().mesh_O(), body.patch_root().root());
  EXPECT_NEAR((p - Eigen::Vector3d(1.0, 0.25, 0.0)).norm(), 0.0, 1e-12);
}

TEST_F(EditMaking, RefusesRootsFarFromTheSurface) {
  EXPECT_THAT(objectionTo("root index object at 9 1 0"),
              HasSubstr("root of patch 'index': 9 1 0 is 8000 mm from the object's surface; it "
                        "may be at most 50 mm"));
  EXPECT_THAT(objectionTo("root index hand at 0 0 51mm"),
              HasSubstr("is 51 mm from the hand's"));
  EXPECT_EQ(objectionTo("root index hand at 0 0 49mm"), "");
}

TEST_F(EditMaking, RefusesNegativeWeightsNamingThePatch) {
  EXPECT_THAT(objectionTo("weight thumb -1"), HasSubstr("weight of patch 'thumb': -1"));
}

TEST_F(EditMaking, TakesAFaceByItsWeights) {
  const v1::PatchRootEdit root = edit("root thumb hand face 120 0.2 0.3 0.5").patch_root();
  EXPECT_EQ(root.root().face(), 120);
  EXPECT_THAT(root.root().barycentric(), ElementsAre(0.2, 0.3, 0.5));
  EXPECT_THAT(objectionTo("root thumb hand face 1 0.2 0.3 0.6"), HasSubstr("sum to 1"));
  EXPECT_THAT(objectionTo("root thumb hand face 1 -0.5 0.5 1"), HasSubstr("negative"));
  EXPECT_THAT(objectionTo("root thumb hand face 4294967296 1 0 0"), HasSubstr("4294967296"));
}

TEST_F(EditMaking, TurnsTheHandsSideUnlessTold) {
  const v1::PatchDirectionEdit plain = edit("dir thumb -90deg").patch_direction();
  EXPECT_EQ(plain.side(), v1::SIDE_HAND);
  EXPECT_DOUBLE_EQ(plain.angle_rad(), -std::numbers::pi / 2);
  EXPECT_EQ(edit("dir thumb object 1").patch_direction().side(), v1::SIDE_OBJECT);
}

TEST_F(EditMaking, SetsWhatCounts) {
  EXPECT_TRUE(edit("enable thumb").patch_enabled().enabled());
  EXPECT_FALSE(edit("disable thumb").patch_enabled().enabled());
  EXPECT_EQ(edit("weight index 0.2").patch_weight().weight(), 0.2);
  const v1::Weights weights = edit("weights 1e4 2 3").weights();
  EXPECT_EQ(weights.distance(), 1e4);
  EXPECT_EQ(weights.normal(), 2);
  EXPECT_EQ(weights.prior(), 3);
}

TEST_F(EditMaking, KeepsTheOtherLimit) {
  const v1::JointLimitEdit upper = edit("limit bend upper 0.3").joint_limit();
  EXPECT_EQ(upper.lower(), -0.5);
  EXPECT_EQ(upper.upper(), 0.3);
  const v1::JointLimitEdit lower = edit("limit bend lower 0.1").joint_limit();
  EXPECT_EQ(lower.lower(), 0.1);
  EXPECT_EQ(lower.upper(), 0.5);
  const v1::JointLimitEdit both = edit("limit slide range 1mm 2mm").joint_limit();
  EXPECT_EQ(both.lower(), 0.001);
  EXPECT_EQ(both.upper(), 0.002);
  const v1::JointLimitEdit reset = edit("limit bend reset").joint_limit();
  EXPECT_EQ(reset.lower(), -1.0);
  EXPECT_EQ(reset.upper(), 2.0);
}

TEST_F(EditMaking, RefusesUnitsThatAJointHasNot) {
  EXPECT_THAT(objectionTo("joint slide 20deg"),
              AllOf(HasSubstr("'slide' slides"), HasSubstr("20deg")));
  EXPECT_THAT(objectionTo("joint bend 20mm"), HasSubstr("'bend' turns"));
  EXPECT_THAT(objectionTo("soft bend 20mm 1"), HasSubstr("20mm"));
  EXPECT_THAT(objectionTo("limit bend upper 20mm"), HasSubstr("20mm"));
}

TEST_F(EditMaking, HoldsJoints) {
  const v1::PriorEdit bent = edit("joint bend 0.4").prior();
  EXPECT_TRUE(bent.X_WH().empty());
  EXPECT_THAT(bent.joints(), ElementsAre("bend"));
  EXPECT_THAT(bent.joint_positions(), ElementsAre(0.4));
  EXPECT_TRUE(edit("lock bend").joint_lock().locked());
  EXPECT_FALSE(edit("unlock bend").joint_lock().locked());
  EXPECT_EQ(edit("soft slide 5mm 10").joint_soft().value(), 0.005);
  EXPECT_EQ(edit("soft slide 5mm 10").joint_soft().weight(), 10);
  EXPECT_EQ(edit("soft slide off").joint_soft().weight(), 0);
}

TEST_F(EditMaking, DragsSitesTipsAndLinks) {
  const v1::DragEdit site = edit("drag index to 0.02 0.03 0.10").drag();
  EXPECT_EQ(site.link(), "finger");
  EXPECT_THAT(site.p_L_m(), ElementsAre(0.0, 0.2, 0.3));
  EXPECT_THAT(site.target_W_m(), ElementsAre(0.02, 0.03, 0.10));
  EXPECT_TRUE(site.target_q_wxyz().empty());
  const v1::DragEdit tip = edit("drag index_tip to 0 0 0").drag();
  EXPECT_EQ(tip.link(), "finger");
  EXPECT_THAT(tip.p_L_m(), ElementsAre(0.0, 0.0, DoubleNear(0.05, 1e-8)));
  const v1::DragEdit link = edit("drag base to 0 0 0").drag();
  EXPECT_EQ(link.link(), "base");
  EXPECT_THAT(link.p_L_m(), ElementsAre(0.0, 0.0, 0.0));
}

TEST_F(EditMaking, LetsGoWhatWasDragged) {
  EXPECT_EQ(edit("drag index to 0 0 0").drag().weight(), 1.0);
  EXPECT_EQ(edit("drag index to 0 0 0 --weight 0.5").drag().weight(), 0.5);
  EXPECT_EQ(edit("release index").release().link(), "finger");
  EXPECT_EQ(edit("release base").release().link(), "base");
  EXPECT_EQ(edit("release").release().link(), "");
}

TEST_F(EditMaking, MovesThePalm) {
  const v1::DragEdit palm = edit("palm to 1cm 2cm 3cm rpy 0 0 90deg").drag();
  EXPECT_EQ(palm.link(), "base");
  EXPECT_THAT(palm.p_L_m(), ElementsAre(0.01, 0.02, 0.03));
  const double half = std::sqrt(0.5);
  EXPECT_THAT(palm.target_q_wxyz(), ElementsAre(DoubleNear(half, 1e-12), DoubleNear(0, 1e-12),
                                                DoubleNear(0, 1e-12), DoubleNear(half, 1e-12)));
  EXPECT_TRUE(edit("palm to 0 0 0").drag().target_q_wxyz().empty());
}

TEST_F(EditMaking, PlacesTheObject) {
  const v1::Pose kept = edit("place object 0 0 0.1").X_WO();
  EXPECT_THAT(kept.p_m(), ElementsAre(0.0, 0.0, 0.1));
  EXPECT_THAT(kept.q_wxyz(), ElementsAre(0.6, 0.8, 0.0, 0.0));
  // Roll first, yaw last, about fixed axes: x goes to -z by the pitch, then stays under the
  // yaw.
  const v1::Pose turned = edit("place object 0 0 0 rpy 0 90deg 30deg").X_WO();
  const auto& q = turned.q_wxyz();
  const Eigen::Vector3d x =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Vector3d::UnitX();
  EXPECT_NEAR((x - Eigen::Vector3d(0, 0, -1)).norm(), 0.0, 1e-12);
}

TEST_F(EditMaking, TakesPriors) {
  const v1::PriorEdit rest = edit("prior rest").prior();
  EXPECT_THAT(rest.joints(), ElementsAre("bend", "slide"));
  EXPECT_THAT(rest.joint_positions(), ElementsAre(0.25, 0.01));
  EXPECT_TRUE(rest.X_WH().empty());

  EXPECT_THAT(objectionTo("prior here"), HasSubstr("solve"));
  v1::PoseSolution solution;
  solution.joint_positions({0.5, 0.02});
  solution.X_WH().p_m({1, 2, 3});
  context.solve(solution);
  const v1::PriorEdit here = edit("prior here").prior();
  EXPECT_THAT(here.joint_positions(), ElementsAre(0.5, 0.02));
  EXPECT_THAT(here.X_WH().at(0).p_m(), ElementsAre(1, 2, 3));

  const std::filesystem::path file = test::scratchDirectory() / "pose.json";
  std::ofstream(file) << R"({"joints": {"bend": 0.7}})";
  const v1::PriorEdit pose = edit("prior pose " + file.string()).prior();
  EXPECT_THAT(pose.joints(), ElementsAre("bend"));
  EXPECT_THAT(pose.joint_positions(), ElementsAre(0.7));

  const v1::PriorShares shares = edit("prior shares 1 2 3").prior_shares();
  EXPECT_EQ(shares.root_rotation(), 1);
  EXPECT_EQ(shares.root_translation(), 2);
  EXPECT_EQ(shares.joints(), 3);
  EXPECT_EQ(edit("prior posture 0.5").prior_shares().posture(), 0.5);
}

TEST_F(EditMaking, ChangesOfASearchKeepTheRest) {
  const v1::SolveOptions named = edit("solver lm --seed 9").solving();
  EXPECT_EQ(named.solver(), v1::SOLVER_LM);
  EXPECT_EQ(named.starts(), 8U);
  EXPECT_EQ(named.seed(), 9U);
  EXPECT_EQ(edit("solver default").solving().solver(), v1::SOLVER_DEFAULT);
  const v1::SolveOptions paper = edit("solver paper --avoid-penetration").solving();
  EXPECT_TRUE(paper.paper());
  EXPECT_EQ(paper.solver(), v1::SOLVER_DEFAULT);
  EXPECT_EQ(paper.starts(), 0U);
  EXPECT_EQ(paper.penetration(), v1::PENETRATION_AVOIDED);
  EXPECT_EQ(edit("solver lm --normal-form sum").solving().normal_form(), v1::NORMAL_SUM);
  EXPECT_THAT(objectionTo("solver lm --avoid-penetration --touch-only"),
              HasSubstr("--touch-only"));
  EXPECT_THAT(objectionTo("solver lm --starts 4294967296"), HasSubstr("--starts"));
}

TEST_F(EditMaking, APaperSearchNamesNoSolver) {
  Match match;
  match.options["--paper"] = {};
  match.options["--starts"] = {"3", 0.0, Unit::kNone, 3};
  EXPECT_THROW(solvingWith({}, match), InvalidInput);
}

TEST_F(EditMaking, GoesBackAndForth) {
  EXPECT_EQ(edit("undo")._d(), v1::EDIT_UNDO);
  EXPECT_EQ(edit("undo").steps().count(), 1U);
  EXPECT_EQ(edit("undo 3").steps().count(), 3U);
  EXPECT_EQ(edit("redo 2")._d(), v1::EDIT_REDO);
  EXPECT_EQ(edit("snapshot before")._d(), v1::EDIT_SNAPSHOT);
  EXPECT_EQ(edit("restore before")._d(), v1::EDIT_RESTORE);
  EXPECT_EQ(edit("restore before").snapshot().name(), "before");
  EXPECT_EQ(edit("hand barrett8")._d(), v1::EDIT_HAND);
  EXPECT_EQ(edit("object box")._d(), v1::EDIT_OBJECT);
  EXPECT_EQ(edit("object box").swapped_model().name(), "box");
  EXPECT_EQ(edit("choose 2").choice().rank(), 1U);
  EXPECT_THAT(objectionTo("choose 0"), HasSubstr("from 1"));
  EXPECT_THAT(objectionTo("undo 0"), HasSubstr("undo 0: the count must be at least 1"));
  EXPECT_THAT(objectionTo("redo 0"), HasSubstr("redo 0: the count must be at least 1"));
}

TEST_F(EditMaking, CountsMinimaAsTheyAreShown) {
  v1::PoseSolution solution;
  solution.minima().resize(3);
  context.solve(solution);
  EXPECT_EQ(edit("choose 3").choice().rank(), 2U);
  EXPECT_THAT(objectionTo("choose 4"), HasSubstr("choose 4: minima count from 1 to 3"));
}

TEST_F(EditMaking, RefusesWeightsThatLeaveNoObjective) {
  EXPECT_THAT(objectionTo("weights 0 0 0"), HasSubstr("at least one"));
  EXPECT_EQ(edit("weights 0 0 1").weights().prior(), 1.0);
}

// === Places on a mesh

TEST(SurfacePick, IsNearestAmongManyPlacesOfTheMesh) {
  // A tetrahedron; points outside, inside, and over corners and edges.
  v1::Mesh mesh;
  mesh.vertices_m({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  mesh.triangles({0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3});
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(-1, -1, -1), Eigen::Vector3d(0.2, 0.2, 0.1), Eigen::Vector3d(2, 0, 0),
        Eigen::Vector3d(0.5, 0.5, -1), Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(0, 0, 0.5)}) {
    const double found = (positionOf(mesh, nearestPoint(mesh, p)) - p).norm();
    constexpr int kSteps = 40;
    for (std::int32_t face = 0; face < 4; ++face) {
      for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
          v1::SurfacePoint other;
          other.face(face);
          const double a = static_cast<double>(i) / kSteps;
          const double b = static_cast<double>(j) / kSteps;
          other.barycentric() = {a, b, 1.0 - a - b};
          EXPECT_LE(found, (positionOf(mesh, other) - p).norm() + 1e-12);
        }
      }
    }
  }
}

TEST(SurfacePick, RefusesDamagedMeshes) {
  EXPECT_THROW(nearestPoint({}, Eigen::Vector3d::Zero()), InvalidInput);
  v1::Mesh mesh;
  mesh.vertices_m({0, 0, 0});
  mesh.triangles({0, 1, 2});
  EXPECT_THROW(nearestPoint(mesh, Eigen::Vector3d::Zero()), TransportError);
  v1::SurfacePoint point;
  point.face(7);
  EXPECT_THROW(positionOf(mesh, point), TransportError);
}

}  // namespace
}  // namespace handgraft::client::editor
