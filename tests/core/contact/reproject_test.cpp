#include "core/contact/reproject.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"

namespace handgraft::contact {
namespace {

using geometry::positionOf;
using geometry::TriangleMesh;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// One square patch in the middle of a plate.
ContactSet squareSet(const TriangleMesh& plate) {
  Patch patch;
  patch.name = "thumb";
  patch.root = geometry::surfacePointAtVertex(plate, 12);
  patch.boundary = {6, 7, 8, 13, 18, 17, 16, 11};
  patch.interpolation_boundary = sampleLoop(plate, patch.boundary);
  ContactSet set;
  set.patches.push_back(patch);
  return set;
}

TEST(Carry, PutsEveryPointInItsPlaceOnAnotherMeshOfTheSurface) {
  const TriangleMesh fine = test::makePlate(4, 4, 0.01);
  const TriangleMesh coarse = test::makePlate(1, 1, 0.2);
  const ContactSet before = squareSet(fine);
  const ContactSet after = reproject(before, fine, coarse);
  ASSERT_EQ(after.patches.size(), 1u);
  const Patch& patch = after.patches[0];
  EXPECT_NO_THROW(validate(coarse, patch));
  EXPECT_TRUE(patch.boundary.empty());
  for (std::size_t i = 0; i < patch.interpolation_boundary.size(); ++i) {
    EXPECT_LT((positionOf(coarse, patch.interpolation_boundary[i]) -
               positionOf(fine, before.patches[0].interpolation_boundary[i]))
                  .norm(),
              1e-12);
  }
}

TEST(Carry, ChoosesTheSideOfAThinWallThatFacesTheSameWay) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.01);
  Eigen::Affine3d up(Eigen::Translation3d(0, 0, -0.0008));  // nearer to the wall's lower side
  const TriangleMesh wall = geometry::transformed(geometry::makeBox({0.1, 0.1, 0.001}), up);
  const ContactSet after = reproject(squareSet(plate), plate, wall);
  for (const auto& point : after.patches.at(0).interpolation_boundary) {
    EXPECT_GT(geometry::normalOf(wall, point).z(), 0.0);
    EXPECT_NEAR(positionOf(wall, point).z(), -0.0003, 1e-9);
  }
}

TEST(Carry, NotesASurfaceThatLiesSomeMillimetresOff) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.01);
  const auto notesAt = [&](double height) {
    const TriangleMesh off =
        geometry::transformed(plate, Eigen::Affine3d(Eigen::Translation3d(0, 0, height)));
    return reproject(squareSet(plate), plate, off).notes;
  };
  EXPECT_THAT(notesAt(0.0019), ::testing::IsEmpty());
  EXPECT_THAT(notesAt(0.004),
              ElementsAre(HasSubstr("contacts lie 4.0 mm off the object's surface")));
}

// Moved along a bar, every side lies on it still, and the contacts with it: the ends tell.
TEST(OtherShape, IsToldByTheMapsWholeMesh) {
  const TriangleMesh bar = geometry::makeBox({0.03, 0.03, 0.2});
  const auto moved = [&](double along) {
    return geometry::transformed(
        bar, Eigen::Affine3d(Eigen::Translation3d(along * Eigen::Vector3d::UnitZ())));
  };
  EXPECT_FALSE(noteOnOtherShape(moved(0.003), bar));
  EXPECT_THAT(noteOnOtherShape(moved(0.008), bar).value_or(""),
              HasSubstr("more than 4 mm off the object's surface"));
  EXPECT_TRUE(noteOnOtherShape(geometry::makeBox({0.03, 0.05, 0.2}), bar));
  // Thinned out, it is the same one.
  EXPECT_FALSE(noteOnOtherShape(geometry::makeSphere(0.04, 2), geometry::makeSphere(0.04, 4)));
}

TEST(Carry, RefusesAnotherObject) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.01);
  const TriangleMesh elsewhere =
      geometry::transformed(plate, Eigen::Affine3d(Eigen::Translation3d(0, 0, 0.02)));
  EXPECT_THAT(
      [&] {
        reproject(squareSet(plate), plate, elsewhere);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("1 of 1 patches")));
}

// Seen from 1e20 m, all faces are equally near.
TEST(Carry, TakesWhatLiesFarAwayForAnotherObject) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.01);
  for (const double far_m : {1e3, 1e20}) {
    // So large that its corners do not fall into one place there.
    const TriangleMesh elsewhere = geometry::transformed(
        plate, Eigen::Translation3d(0, 0, far_m) * Eigen::Scaling(1e-3 * far_m));
    EXPECT_THAT(
        [&] {
          reproject(squareSet(elsewhere), elsewhere, plate);
        },
        ThrowsMessage<InvalidInput>(HasSubstr("1 of 1 patches")));
  }
}

TEST(Carry, DropsThePatchThatHasNoPlaceWithANote) {
  const TriangleMesh plate = test::makePlate(4, 4, 0.01);
  ContactSet set = squareSet(plate);
  Patch corner = set.patches[0];
  corner.name = "little";
  corner.root = geometry::surfacePointAtVertex(plate, 24);
  corner.interpolation_boundary.assign(5, corner.root);
  set.patches.push_back(corner);
  const TriangleMesh small = test::makePlate(1, 1, 0.025);
  const ContactSet after = reproject(set, plate, small);
  EXPECT_EQ(after.patches.size(), 1u);
  EXPECT_THAT(after.notes, ElementsAre(HasSubstr("'little' dropped")));
}

}  // namespace
}  // namespace handgraft::contact
