#include "core/base/content_hash.h"

#include <string>

#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(ContentHash, IsSha256) {
  // FIPS 180-4's examples, and one of several blocks.
  const auto hash_of = [](const std::string& text) {
    ContentHash hash;
    hash.add(text);
    return hash.finish();
  };
  EXPECT_EQ(hash_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(ContentHash, DoesNotCareHowBytesAreCut) {
  ContentHash whole;
  whole.add(std::string(200, 'x'));
  ContentHash parts;
  for (int i = 0; i < 200; ++i)
    parts.add("x");
  EXPECT_EQ(whole.finish(), parts.finish());
}

TEST(ContentHash, KeepsTextsApart) {
  ContentHash one;
  one.addText("ab");
  one.addText("c");
  ContentHash other;
  other.addText("a");
  other.addText("bc");
  EXPECT_NE(one.finish(), other.finish());
}

}  // namespace
}  // namespace handgraft
