// The contract's table of operations.
#include "idl/operations.h"

#include <gtest/gtest.h>

#include "idl/fields.h"

namespace handgraft::idl {
namespace {

std::vector<v1::Operation> allOperations() {
  std::vector<v1::Operation> all;
  for (const std::string& name : namesOf(typeOf<v1::Operation>()))
    all.push_back(v1::enumeratorOf<v1::Operation>(name).value());
  return all;
}

TEST(Operations, EachHasALineOfTheTable) {
  for (const v1::Operation operation : allOperations()) {
    // Without one it would be taken for one that does not exist, which is operators' alone.
    EXPECT_TRUE(operation == v1::OP_UNLOAD_MODEL ||
                traitsOf(operation).privilege != Privilege::kOperate)
        << nameOf(operation);
  }
}

TEST(Operations, ThatDoNotExistAreForNobodyElseAndNoPage) {
  const OperationTraits traits = traitsOf(static_cast<v1::Operation>(12345));
  EXPECT_EQ(traits.privilege, Privilege::kOperate);
  EXPECT_EQ(traits.answered_by, AnsweredBy::kOneServer);
  EXPECT_EQ(traits.pages, Pages::kNone);
}

TEST(Operations, ThatNameASessionAreAnsweredByItsServer) {
  for (const v1::Operation operation : allOperations()) {
    v1::RequestBody body;
    typeOf<v1::RequestBody>().choose(&body, static_cast<std::uint32_t>(operation));
    const Field* member =
        chosenOf(typeOf<v1::RequestBody>(), static_cast<std::uint32_t>(operation));
    ASSERT_NE(member, nullptr) << nameOf(operation);
    const Field* id = fieldOf(*member->type, "session_id");
    if (id == nullptr) {
      EXPECT_EQ(sessionOf(body), 0u) << nameOf(operation);
      continue;
    }
    *static_cast<std::uint64_t*>(id->in(member->in(&body))) = 77;
    EXPECT_EQ(sessionOf(body), 77u) << nameOf(operation);
    EXPECT_EQ(traitsOf(operation).answered_by, AnsweredBy::kOneServer) << nameOf(operation);
  }
}

TEST(Operations, WhatPagesMayLookAtChangesNothing) {
  for (const v1::Operation operation :
       {v1::OP_OPTIMIZE, v1::OP_OPEN_SESSION, v1::OP_SET_CLOCK, v1::OP_STOP_SOLVING})
    EXPECT_EQ(traitsOf(operation).pages, Pages::kThatEdit) << nameOf(operation);
  for (const v1::Operation operation :
       {v1::OP_LOAD_MODEL, v1::OP_UNLOAD_MODEL, v1::OP_CLOSE_SESSION, v1::OP_PUT_FILE})
    EXPECT_EQ(traitsOf(operation).pages, Pages::kNone) << nameOf(operation);
}

TEST(Operations, WhatIsLookedAtTakesTheRightToLookAlone) {
  for (const v1::Operation operation : allOperations()) {
    const OperationTraits traits = traitsOf(operation);
    if (traits.pages == Pages::kThatLook) {
      EXPECT_EQ(traits.privilege, Privilege::kLook) << nameOf(operation);
    }
  }
  for (const v1::Operation operation :
       {v1::OP_MOTION_FRAMES, v1::OP_LINK_POSES, v1::OP_SESSION_SETTINGS, v1::OP_EXPORT})
    EXPECT_EQ(traitsOf(operation).privilege, Privilege::kLook) << nameOf(operation);
}

}  // namespace
}  // namespace handgraft::idl
