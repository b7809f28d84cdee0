// Which finger and segment patches lie on, on the built-in library's real skins.
#include "core/session/place_matching.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "core/optimize/diagnosis.h"
#include "core/session/session.h"

#include "tests/support/shared_data.h"

namespace handgraft::session {
namespace {

std::filesystem::path libraryPath(const std::string& relative) {
  return test::sourceDirectory() / "server/models" / relative;
}

hand::Hand handOfLibrary(const std::string& name) {
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(
      io::readUrdf(libraryPath("hands/" + name + "/" + name + ".urdf")).model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(*hand.model, {}, Progress()));
  hand.sites = io::readSites(libraryPath("hands/" + name + "/sites.yaml"), *hand.model);
  return hand;
}

/// A box that five fingertips touched, as a map with labels tells it.
struct LabelledBox {
  io::MeshFile file = io::readMesh(libraryPath("objects/box.obj"));
  std::shared_ptr<const geometry::TriangleMesh> mesh =
      std::make_shared<const geometry::TriangleMesh>(file.mesh);
  contact::ContactSet contacts = io::readContactSet(libraryPath("contacts/box_5.json"), file);

  LabelledBox() {
    for (contact::Patch& patch : contacts.patches)
      patch.name += "_distal";
  }
};

/// How many of the set's patches a hand reaches.
std::ptrdiff_t reachedOf(const hand::Hand& hand,
                         const LabelledBox& box,
                         const contact::ContactSet& contacts) {
  Session session(hand, box.mesh, contacts, Pose::Identity(), {});
  const Solution solution = session.solve(SolverSettings(), {}, Progress());
  return std::ssize(solution.report.patches) -
         std::ssize(optimize::missedPatches(solution.problem, solution.report));
}

TEST(LinksOfSite, AreThoseOfItsSegmentAndTheOnesBesideIt) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto coordinates = hand::coordinatesOf(hand);
  const auto segmentsOf = [&](const std::string& site) {
    std::vector<std::string> segments;
    const std::vector<char> links = linksOfSite(hand, *coordinates, site);
    for (std::size_t link = 0; link < links.size(); ++link) {
      if (links[link] == 0) continue;
      const auto& part = coordinates->parts()[link];
      const std::string name = part.digit + "_" + part.segment;
      if (std::find(segments.begin(), segments.end(), name) == segments.end())
        segments.push_back(name);
    }
    std::sort(segments.begin(), segments.end());
    return segments;
  };
  using Segments = std::vector<std::string>;
  EXPECT_EQ(segmentsOf("index_distal"), (Segments{"index_distal", "index_middle"}));
  EXPECT_EQ(segmentsOf("index"), (Segments{"index_distal", "index_middle"}));
  EXPECT_EQ(segmentsOf("index_middle"),
            (Segments{"index_distal", "index_middle", "index_proximal"}));
  EXPECT_EQ(segmentsOf("thumb_proximal"), (Segments{"thumb_middle", "thumb_proximal"}));
}

/// Of every way to leave one finger out, none reaches more patches than the one that was taken.
TEST(DealingFingers, TakesTheWayThatReachesMost) {
  const hand::Hand hand = handOfLibrary("allegro16");
  const LabelledBox box;
  const std::vector<std::string> fingers = {"index", "middle", "ring"};
  std::ptrdiff_t most = 0;
  for (std::size_t out = 1; out < box.contacts.patches.size(); ++out) {
    contact::ContactSet others = box.contacts;
    others.patches.erase(others.patches.begin() + static_cast<std::ptrdiff_t>(out));
    for (std::size_t i = 0; i < fingers.size(); ++i)
      others.patches[i + 1].name = fingers[i] + "_distal";
    most = std::max(most, reachedOf(hand, box, others));
  }
  EXPECT_GE(reachedOf(hand, box, box.contacts), most);
}

TEST(DealingFingers, KeepsTheirOrderAndTheThumbAndTellsIt) {
  const hand::Hand hand = handOfLibrary("barrett8");
  const LabelledBox box;
  const Session session(hand, box.mesh, box.contacts, Pose::Identity(), {});
  std::vector<std::string> sites;
  std::size_t dropped = 0;
  for (const SessionPatch& patch : session.patches()) {
    if (patch.placement) {
      sites.push_back(patch.site);
    } else {
      ++dropped;
      EXPECT_NE(patch.dropped.find("hand has fewer fingers"), std::string::npos)
          << patch.dropped;
    }
  }
  EXPECT_EQ(sites, (std::vector<std::string>{"thumb_distal", "index_distal", "middle_distal"}));
  EXPECT_EQ(dropped, 2u);
  const auto isTold = [&](const std::string& part) {
    return std::any_of(session.notes().begin(), session.notes().end(),
                       [&](const std::string& note) {
                         return note.find(part) != std::string::npos;
                       });
  };
  EXPECT_TRUE(isTold("it has no ring, little"));
  EXPECT_FALSE(isTold("thumb's contacts go"));
}

}  // namespace
}  // namespace handgraft::session
