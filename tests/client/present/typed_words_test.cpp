#include "client/present/typed_words.h"

#include <functional>

#include <gtest/gtest.h>

#include "client/present/failure.h"
#include "idl/check.h"
#include "idl/cyclone/requester.h"
#include "idl/service.h"

namespace handgraft::client {
namespace {

/// What people read of a message that the server refuses.
template <class Message>
std::string toldOf(const Message& message) {
  try {
    idl::check(message);
  } catch (const idl::InvalidField& wrong) {
    return failureOf(idl::cyclone::Refused(v1::ERROR_INVALID_INPUT, wrong.what())).message;
  }
  return "nothing is wrong";
}

std::string toldOfSession(const std::function<void(v1::OpenSessionRequest&)>& change) {
  v1::OpenSessionRequest open;
  open.weights().resize(1);
  open.transfer().resize(1);
  change(open);
  v1::Request request;
  request.body().open_session(open);
  return toldOf(request);
}

template <class OneEdit>
std::string toldOfEdit(void (v1::EditBody::*as)(const OneEdit&), const OneEdit& one) {
  v1::Edit edit;
  (edit.body().*as)(one);
  return toldOf(edit);
}

TEST(TypedWords, OptionsStandForFieldsOfRequests) {
  EXPECT_EQ(toldOfSession([](auto& open) {
              open.transfer()[0].interior_rings(20);
            }),
            "--interior: 20 is outside 0 to 16");
  EXPECT_EQ(toldOfSession([](auto& open) {
              open.weights()[0].normal(-1.0);
            }),
            "--weights, normal: -1 is outside 0 to 1000000000000");
  v1::OptimizeRequest optimize;
  optimize.options().resize(1);
  optimize.options()[0].starts(20000);
  v1::Request request;
  request.body().optimize(optimize);
  EXPECT_EQ(toldOf(request), "--starts: 20000 is outside 0 to 10000");
}

TEST(TypedWords, WordsOfThePromptStandForFieldsOfEdits) {
  v1::Weights weights;
  weights.distance(-1.0);
  EXPECT_EQ(toldOfEdit<v1::Weights>(&v1::EditBody::weights, weights),
            "weights, distance: -1 is outside 0 to 1000000000000");
  v1::PriorShares shares;
  shares.posture(-4.0);
  EXPECT_EQ(toldOfEdit<v1::PriorShares>(&v1::EditBody::prior_shares, shares),
            "prior posture: -4 is outside 0 to 1000000000000");
  v1::SolveOptions solving;
  solving.max_evaluations(1000000);
  EXPECT_EQ(toldOfEdit<v1::SolveOptions>(&v1::EditBody::solving, solving),
            "--max-evaluations: 1000000 is outside 0 to 100000");
  v1::PatchWeightEdit weight;
  weight.weight(-2.0);
  EXPECT_EQ(toldOfEdit<v1::PatchWeightEdit>(&v1::EditBody::patch_weight, weight),
            "weight: -2 is outside 0 to 1000000000000");
  v1::JointSoftEdit soft;
  soft.weight(-2.0);
  EXPECT_EQ(toldOfEdit<v1::JointSoftEdit>(&v1::EditBody::joint_soft, soft),
            "soft, the last number: -2 is outside 0 to 1000000000000");
  v1::DragEdit drag;
  drag.weight(-2.0);
  EXPECT_EQ(toldOfEdit<v1::DragEdit>(&v1::EditBody::drag, drag),
            "--weight: -2 is outside 0 to 1000000000000");
}

TEST(TypedWords, EverythingElseStaysAsItIs) {
  for (const char* complaint :
       {"joint 'thumb': 2 rad is above its limit", "body.take_back.index: 300 is outside",
        "body.edits.restarts: 3 is outside", "a note of body.steps.count: 7", ""})
    EXPECT_EQ(asTyped(complaint), complaint);
}

}  // namespace
}  // namespace handgraft::client
