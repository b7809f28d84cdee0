// Edits that make no sense, clients that vanish: clear answers, a server that lives, others
// that notice nothing. Real processes.
#include <array>
#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// An edit that is refused, and what the answer names.
struct Refusal {
  std::string what;
  v1::EditBody body;
  std::vector<std::string> told;
};

template <class Edit, class Fill>
v1::EditBody bodyOf(void (v1::EditBody::*set)(const Edit&), const Fill& fill) {
  Edit edit;
  fill(edit);
  v1::EditBody body;
  (body.*set)(edit);
  return body;
}

v1::Pose poseAt(std::array<double, 3> p_m) {
  v1::Pose X;
  X.p_m(p_m);
  X.q_wxyz({1.0, 0.0, 0.0, 0.0});
  return X;
}

v1::EditBody place(const v1::Pose& X_WO) {
  v1::EditBody body;
  body.X_WO(X_WO);
  return body;
}

v1::EditBody patchWeight(const std::string& patch, double weight) {
  return bodyOf(&v1::EditBody::patch_weight, [&](v1::PatchWeightEdit& edit) {
    edit.patch(patch);
    edit.weight(weight);
  });
}

v1::EditBody root(const std::string& patch,
                  v1::PatchSide side,
                  std::int32_t face,
                  std::array<double, 3> barycentric) {
  return bodyOf(&v1::EditBody::patch_root, [&](v1::PatchRootEdit& edit) {
    edit.patch(patch);
    edit.side(side);
    edit.root().face(face);
    edit.root().barycentric(barycentric);
  });
}

v1::EditBody turn(const std::string& patch, double angle_rad) {
  return bodyOf(&v1::EditBody::patch_direction, [&](v1::PatchDirectionEdit& edit) {
    edit.patch(patch);
    edit.side(v1::SIDE_HAND);
    edit.angle_rad(angle_rad);
  });
}

v1::EditBody limit(const std::string& joint, double lower_rad, double upper_rad) {
  return bodyOf(&v1::EditBody::joint_limit, [&](v1::JointLimitEdit& edit) {
    edit.joint(joint);
    edit.lower(lower_rad);
    edit.upper(upper_rad);
  });
}

v1::EditBody prior(const std::vector<std::string>& joints, const std::vector<double>& rad) {
  return bodyOf(&v1::EditBody::prior, [&](v1::PriorEdit& edit) {
    edit.joints(joints);
    edit.joint_positions(rad);
  });
}

v1::EditBody priorPose(const v1::Pose& X_WH) {
  return bodyOf(&v1::EditBody::prior, [&](v1::PriorEdit& edit) {
    edit.X_WH({X_WH});
  });
}

v1::EditBody lambdas(double distance, double normal, double of_prior) {
  return bodyOf(&v1::EditBody::weights, [&](v1::Weights& edit) {
    edit.distance(distance);
    edit.normal(normal);
    edit.prior(of_prior);
  });
}

v1::EditBody soft(const std::string& joint, double value_rad, double weight) {
  return bodyOf(&v1::EditBody::joint_soft, [&](v1::JointSoftEdit& edit) {
    edit.joint(joint);
    edit.value(value_rad);
    edit.weight(weight);
  });
}

v1::EditBody shares(double rotation, double translation, double joints) {
  return bodyOf(&v1::EditBody::prior_shares, [&](v1::PriorShares& edit) {
    edit.root_rotation(rotation);
    edit.root_translation(translation);
    edit.joints(joints);
  });
}

v1::EditBody drag(const std::string& link,
                  std::array<double, 3> p_L,
                  std::array<double, 3> target_W,
                  const std::vector<double>& q_wxyz = {}) {
  return bodyOf(&v1::EditBody::drag, [&](v1::DragEdit& edit) {
    edit.link(link);
    edit.p_L_m(p_L);
    edit.target_W_m(target_W);
    edit.target_q_wxyz(q_wxyz);
  });
}

v1::EditBody solving(std::uint32_t starts, std::uint32_t most) {
  return bodyOf(&v1::EditBody::solving, [&](v1::SolveOptions& edit) {
    edit.starts(starts);
    edit.max_evaluations(most);
  });
}

v1::EditBody choice(std::uint32_t rank) {
  return bodyOf(&v1::EditBody::choice, [&](v1::ChoiceEdit& edit) {
    edit.rank(rank);
  });
}

v1::EditBody steps(v1::EditKind kind, std::uint32_t count) {
  v1::EditBody body = bodyOf(&v1::EditBody::steps, [&](v1::StepsEdit& edit) {
    edit.count(count);
  });
  body._d(kind);
  return body;
}

v1::EditBody named(v1::EditKind kind, const std::string& name) {
  v1::EditBody body;
  if (kind == v1::EDIT_HAND || kind == v1::EDIT_OBJECT) {
    body = bodyOf(&v1::EditBody::swapped_model, [&](v1::ModelEdit& edit) {
      edit.name(name);
    });
  } else {
    body = bodyOf(&v1::EditBody::snapshot, [&](v1::SnapshotEdit& edit) {
      edit.name(name);
    });
  }
  body._d(kind);
  return body;
}

/// Every number of every kind of edit, `bad` in its place.
std::vector<Refusal> withNumber(double bad, const std::string& shown) {
  std::vector<Refusal> list;
  const auto add = [&](const std::string& what, const v1::EditBody& body,
                       const std::string& thing) {
    list.push_back({what + " " + shown, body, {thing, shown}});
  };
  const std::string joint = "index_distal_flex";
  for (std::size_t i = 0; i < 7; ++i) {
    v1::Pose X = poseAt({0.0, 0.0, 0.0});
    if (i < 3) {
      X.p_m()[i] = bad;
    } else {
      X.q_wxyz()[i - 3] = bad;
    }
    add("object's pose", place(X), "X_WO");
    add("hand's pose", priorPose(X), "X_WH");
    add("target's rotation",
        drag("index_distal", {0, 0, 0}, {0, 0, 0.1}, {X.q_wxyz().begin(), X.q_wxyz().end()}),
        "target_q_wxyz");
    if (i < 3) list.pop_back();  // that one is as it should be
  }
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, 3> three{0.5, 0.25, 0.25};
    three[i] = bad;
    add("root on the object", root("palm", v1::SIDE_OBJECT, 0, three), "root");
    add("root on the hand", root("palm", v1::SIDE_HAND, 0, three), "root");
    add("dragged point", drag("index_distal", three, {0, 0, 0}), "drag.p_L_m");
    add("drag's target", drag("index_distal", {0, 0, 0}, three), "drag.target_W_m");
    std::array<double, 3> one{1.0, 1.0, 1.0};
    one[i] = bad;
    add("weights", lambdas(one[0], one[1], one[2]), "weight");
    add("prior shares", shares(one[0], one[1], one[2]), "share");
  }
  add("patch weight", patchWeight("palm", bad), "weight");
  add("direction", turn("palm", bad), "angle");
  add("lower limit", limit(joint, bad, 1.0), "lower");
  add("upper limit", limit(joint, 0.0, bad), "upper");
  add("prior's joint", prior({joint}, {bad}), "prior");
  add("soft value", soft(joint, bad, 1.0), "value");
  add("soft weight", soft(joint, 0.5, bad), "weight");
  return list;
}

std::vector<Refusal> withUnknownNames() {
  const std::string x = "no_such_thing";
  return {
      {"weight of a patch", patchWeight(x, 1.0), {x, "patch", "palm"}},
      {"root of a patch", root(x, v1::SIDE_HAND, 0, {1, 0, 0}), {x, "patch", "palm"}},
      {"direction of a patch", turn(x, 0.1), {x, "patch", "palm"}},
      {"limit of a joint", limit(x, 0.0, 1.0), {x, "joint", "index_distal_flex"}},
      {"soft joint", soft(x, 0.0, 1.0), {x, "joint", "index_distal_flex"}},
      {"prior of a joint", prior({x}, {0.0}), {x, "joint", "index_distal_flex"}},
      {"drag of a link", drag(x, {0, 0, 0}, {0, 0, 0}), {x, "link", "index_distal"}},
      {"hand", named(v1::EDIT_HAND, x), {x, "hand"}},
      {"object", named(v1::EDIT_OBJECT, x), {x, "object"}},
      {"snapshot", named(v1::EDIT_RESTORE, x), {x, "snapshot"}},
      {"a name that is none", named(v1::EDIT_SNAPSHOT, "a b\nc"), {"snapshot", "letters"}},
      {"a name without end", patchWeight(std::string(100'000, 'x'), 1.0), {"100000", "256"}},
      {"lock of a joint",
       bodyOf(&v1::EditBody::joint_lock,
              [&](v1::JointLockEdit& edit) {
                edit.joint(x);
              }),
       {x, "joint", "index_distal_flex"}},
      {"switch of a patch",
       bodyOf(&v1::EditBody::patch_enabled,
              [&](v1::PatchEnabledEdit& edit) {
                edit.patch(x);
              }),
       {x, "patch", "palm"}},
  };
}

std::vector<Refusal> beyondTheirRange() {
  constexpr std::int32_t kFar = std::numeric_limits<std::int32_t>::max();
  const std::string far = std::to_string(kFar);
  const std::string joint = "index_distal_flex";
  return {
      {"face -1", root("palm", v1::SIDE_HAND, -1, {1, 0, 0}), {"root", "-1", "faces"}},
      {"far face", root("palm", v1::SIDE_HAND, kFar, {1, 0, 0}), {"root", far, "faces"}},
      {"far face of the object",
       root("palm", v1::SIDE_OBJECT, kFar, {1, 0, 0}),
       {"root", far, "faces"}},
      {"place off its face", root("palm", v1::SIDE_HAND, 0, {2, -1, 0}), {"root", "-1", "sum"}},
      {"minimum 8", choice(8), {"rank", "8", "0 to 7"}},
      {"last minimum", choice(4'294'967'295U), {"rank", "4294967295", "0 to 7"}},
      {"undo of too many", steps(v1::EDIT_UNDO, 1000), {"undo"}},
      {"undo of far too many", steps(v1::EDIT_UNDO, 4'000'000'000U), {"count", "4000000000"}},
      {"redo of nothing", steps(v1::EDIT_REDO, 1), {"redo"}},
      {"starts", solving(10'001, 0), {"starts", "10001", "10000"}},
      {"evaluations", solving(0, 100'001), {"max_evaluations", "100001", "100000"}},
      {"heavy patch", patchWeight("palm", 1e300), {"weight", "1e+300", "1000000"}},
      {"negative weight", patchWeight("palm", -0.5), {"weight", "-0.5", "0"}},
      {"far turn", turn("palm", 1e9), {"palm", "1000000000", "1000"}},
      {"limits the wrong way round", limit(joint, 1.0, 0.5), {joint, "1", "0.5"}},
      {"far limit", limit(joint, -1e9, 1.0), {joint, "-1000000000", "1000"}},
      {"joint beyond its limit", prior({joint}, {99.0}), {joint, "99"}},
      {"a joint twice", prior({joint, joint}, {0.5, 0.5}), {joint, "twice"}},
      {"two joints, one angle", prior({joint, "thumb_distal_flex"}, {0.5}), {"2", "1"}},
      {"soft beyond the limit", soft(joint, 99.0, 1.0), {joint, "99"}},
      {"object far away", place(poseAt({0, 0, 1e6})), {"object", "1000000", "1000"}},
      {"hand far away", priorPose(poseAt({0, 0, 1e6})), {"hand", "1000000", "1000"}},
      {"target far away",
       drag("index_distal", {0, 0, 0}, {0, 0, 1e6}),
       {"drag", "1e+06", "10 m"}},
      {"point far away", drag("index_distal", {0, 1e300, 0}, {0, 0, 0}), {"drag", "10 m"}},
      {"no quaternion",
       drag("index_distal", {0, 0, 0}, {0, 0, 0}, {0, 0, 0, 0}),
       {"target_q_wxyz", "norm 0"}},
      {"half a quaternion",
       drag("index_distal", {0, 0, 0}, {0, 0, 0}, {1, 0}),
       {"target_q_wxyz", "2 numbers"}},
  };
}

class RoughEdits : public testing::Test {
 protected:
  RoughEdits() { calm.optimize(); }

  void expectRefused(const std::vector<Refusal>& refusals) {
    const unsigned long long before = session.edit(patchWeight("palm", 1.0)).revision();
    for (const Refusal& refusal : refusals) {
      SCOPED_TRACE(refusal.what);
      const v1::EditReply reply = session.edit(refusal.body);
      EXPECT_TRUE(reply.error() == v1::ERROR_INVALID_INPUT ||
                  reply.error() == v1::ERROR_NOT_FOUND)
          << reply.error() << ": " << reply.message();
      for (const std::string& told : refusal.told)
        EXPECT_THAT(reply.message(), HasSubstr(told));
      EXPECT_THAT(reply.message(), Not(HasSubstr("\n")));
      EXPECT_LT(reply.message().size(), 2000u);
    }
    EXPECT_EQ(session.edit(patchWeight("palm", 1.0)).revision(), before + 1)
        << "an edit that was refused counted";
  }

  /// Nobody touched it: its first edit is the first, and is solved.
  void expectCalm() {
    EXPECT_TRUE(service.server().running());
    const v1::EditReply reply = calm.edit(patchWeight("palm", 2.0));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    EXPECT_EQ(reply.revision(), 1u);
    EXPECT_TRUE(calm.solution([](const v1::PoseSolution& one) {
      return one.is_final() && one.revision() == 1;
    }));
  }

  Service service;
  LiveSession calm{service, "barrett8", "lemon", "lemon_6"};
  LiveSession session{service, "barrett8", "lemon", "lemon_6"};
};

TEST_F(RoughEdits, OfNumbersThatAreNoneNameTheThing) {
  expectRefused(withNumber(kNan, "nan"));
  expectRefused(withNumber(kInfinity, "inf"));
  expectRefused(withNumber(-kInfinity, "-inf"));
  expectCalm();
}

TEST_F(RoughEdits, OfThingsThatAreNotThereNameThoseThatAre) {
  session.optimize();
  expectRefused(withUnknownNames());
  expectCalm();
}

TEST_F(RoughEdits, BeyondTheirRangeNameIt) {
  session.optimize();
  expectRefused(beyondTheirRange());
  expectCalm();
}

TEST_F(RoughEdits, WhoseEnumeratorsDoNotExistAreNotSent) {
  // Cyclone's writers refuse what the contract does not hold; what other vendors let through
  // the server refuses (tests/server).
  EXPECT_ANY_THROW(session.edit(root("palm", static_cast<v1::PatchSide>(7), 0, {1, 0, 0})));
  EXPECT_ANY_THROW(session.edit(named(static_cast<v1::EditKind>(99), "x")));
  expectCalm();
}

TEST_F(RoughEdits, DragOutOfReachIsAnAnswer) {
  session.optimize();
  // Five metres off, and turned: no finger gets there, and the palm moves little.
  const v1::EditReply reply =
      session.edit(drag("index_distal", {0, 0, 0.01}, {5.0, 0, 0}, {0, 1, 0, 0}));
  EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const auto solution = session.solution([&](const v1::PoseSolution& one) {
    return one.is_final() && one.revision() == reply.revision();
  });
  ASSERT_TRUE(solution.has_value());
  for (const double q : solution->joint_positions())
    EXPECT_LT(std::abs(q), 10.0);
  expectCalm();
}

TEST_F(RoughEdits, OfASessionThatIsClosedAreToldSo) {
  session.close();
  for (int i = 0; i < 3; ++i) {
    const v1::EditReply reply = session.edit(patchWeight("palm", 1.0));
    EXPECT_EQ(reply.error(), v1::ERROR_NOT_FOUND);
    EXPECT_THAT(reply.message(), HasSubstr(fmt::format("session {}", session.id())));
  }
  expectCalm();
}

TEST_F(RoughEdits, AClientThatIsKilledAmongThemLeavesAWholeSession) {
  session.optimize();
  const std::filesystem::path script = scratchDirectory() / "endless.hg";
  std::ofstream file(script);
  for (int i = 0; i < 20'000; ++i)
    file << "weight palm " << 1.0 + 1e-4 * i << "\n";
  file.close();
  const auto client = service.start(
      "handgraft", {"edit", std::to_string(session.id()), "--script", script.string()});
  const auto midway = session.state([](const v1::SessionState& state) {
    return state.revision() >= 20;
  });
  ASSERT_TRUE(midway.has_value()) << client->out() << client->err();
  client->send(SIGKILL);

  // Whoever comes next goes on from a whole edit, one revision later.
  const v1::EditReply next = session.edit(patchWeight("thumb", 2.0));
  EXPECT_EQ(next.error(), v1::ERROR_NONE) << next.message();
  EXPECT_GE(next.revision(), midway->revision() + 1);
  EXPECT_LT(next.revision(), 20'000u) << "the client was not killed in the middle";
  EXPECT_TRUE(session.solution([&](const v1::PoseSolution& one) {
    return one.is_final() && one.revision() >= next.revision();
  }));
  expectCalm();
}

}  // namespace
}  // namespace handgraft::test
