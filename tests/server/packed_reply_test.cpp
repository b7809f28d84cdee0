#include "server/admission/packed_reply.h"

#include <gtest/gtest.h>

namespace handgraft::server {
namespace {

v1::Reply refusal(const std::string& message) {
  v1::Reply reply;
  reply.client({1, 2, 3});
  reply.request_id(7);
  reply.server_id(8);
  reply.error(v1::ERROR_NOT_FOUND);
  reply.message(message);
  return reply;
}

TEST(PackedReply, OpensAsItWas) {
  const v1::Reply told = refusal("no hand 'glove'");
  EXPECT_EQ(PackedReply(told).open(), told);
}

TEST(PackedReply, OpensAMeshAsItWas) {
  v1::Reply told = refusal("");
  v1::ObjectDescription object;
  for (int i = 0; i < 30'000; ++i)
    object.mesh_O().vertices_m().push_back(0.25F * static_cast<float>(i));
  v1::ModelDescription description;
  description.object(object);
  told.body().model(description);
  const PackedReply packed(told);
  EXPECT_EQ(packed.open(), told);
  EXPECT_EQ(packed.open(), told);  // as often as it is repeated
}

TEST(PackedReply, IsToldFromAnother) {
  EXPECT_EQ(PackedReply(refusal("a")), PackedReply(refusal("a")));
  EXPECT_NE(PackedReply(refusal("a")), PackedReply(refusal("b")));
}

}  // namespace
}  // namespace handgraft::server
