#include "core/contact/touching_side.h"

#include <string>

#include <gtest/gtest.h>

#include "core/geometry/triangle_mesh.h"

namespace handgraft::contact {
namespace {

using hand::Chirality;

/// A ball touched by fingers one beside the other along `across`, the palm facing -x and
/// fingers to +z.
ContactSet rowOfTouches(const geometry::TriangleMesh& ball_O,
                        const std::vector<std::string>& names,
                        const Eigen::Vector3d& across) {
  ContactSet set;
  set.posture.push_back({"palm", Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitX()});
  double at = -0.5;
  for (const std::string& name : names) {
    Patch patch;
    patch.name = name;
    const Eigen::Vector3d wanted = (Eigen::Vector3d::UnitX() + at * across).normalized();
    int nearest = 0;
    for (int v = 0; v < ball_O.vertexCount(); ++v)
      if (ball_O.vertex(v).dot(wanted) > ball_O.vertex(nearest).dot(wanted)) nearest = v;
    patch.root = geometry::surfacePointAtVertex(ball_O, nearest);
    set.patches.push_back(patch);
    at += 0.3;
  }
  return set;
}

TEST(TouchingSide, IsThatOfTheHandWhoseFingersFollowEachOtherSo) {
  const geometry::TriangleMesh ball_O = geometry::makeSphere(0.03, 4);
  // A right hand that faces -x, fingers up, has its little finger towards +y.
  const std::vector<std::string> names{"index_distal", "middle_distal", "ring",
                                       "little_middle"};
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  EXPECT_EQ(touchingSide(rowOfTouches(ball_O, names, y), ball_O), Chirality::kRight);
  EXPECT_EQ(touchingSide(rowOfTouches(ball_O, names, -y), ball_O), Chirality::kLeft);
}

TEST(TouchingSide, IsToldByDirectionsWhereNobodyKnowsThePalm) {
  const geometry::TriangleMesh ball_O = geometry::makeSphere(0.03, 4);
  for (const double side : {1.0, -1.0}) {
    ContactSet set = rowOfTouches(ball_O, {"index_distal", "middle_distal", "ring_distal"},
                                  side * Eigen::Vector3d::UnitY());
    set.posture.clear();
    for (Patch& patch : set.patches) {
      const Eigen::Vector3d n_O = normalOf(ball_O, patch.root);
      const Eigen::Vector3d down_O = -Eigen::Vector3d::UnitZ();
      patch.direction_O = (down_O - down_O.dot(n_O) * n_O).normalized();
    }
    EXPECT_EQ(touchingSide(set, ball_O), side > 0.0 ? Chirality::kRight : Chirality::kLeft);
    // Fingers that lead to all sides stood around it.
    set.patches[0].direction_O = -*set.patches[0].direction_O;
    EXPECT_EQ(touchingSide(set, ball_O), Chirality::kUnknown);
  }
}

TEST(TouchingSide, IsUnknownWhereNothingTells) {
  const geometry::TriangleMesh ball_O = geometry::makeSphere(0.03, 4);
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  ContactSet set = rowOfTouches(ball_O, {"index", "ring"}, y);
  set.posture.clear();
  EXPECT_EQ(touchingSide(set, ball_O), Chirality::kUnknown) << "no palm, no directions";
  EXPECT_EQ(touchingSide(rowOfTouches(ball_O, {"thumb", "ring"}, y), ball_O),
            Chirality::kUnknown)
      << "one finger";
  EXPECT_EQ(
      touchingSide(rowOfTouches(ball_O, {"index", "ring"}, Eigen::Vector3d::UnitZ()), ball_O),
      Chirality::kUnknown)
      << "one above the other";
}

}  // namespace
}  // namespace handgraft::contact
