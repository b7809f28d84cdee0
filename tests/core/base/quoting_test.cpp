#include "core/base/quoting.h"

#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(Quoting, ACellIsQuotedOnlyWhereItHasToBe) {
  EXPECT_EQ(csvCell("index mcp"), "index mcp");
  EXPECT_EQ(csvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(csvCell("2\" jaw"), "\"2\"\" jaw\"");
  EXPECT_EQ(csvCell("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(csvCell(""), "");
}

TEST(Quoting, XmlHasNoMarkupOfANameAndNoControlCharacters) {
  EXPECT_EQ(xmlText("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
  EXPECT_EQ(xmlText(std::string("a\x01\tb")), "a  b");
  EXPECT_EQ(xmlText("Zeigefinger-Ä"), "Zeigefinger-Ä") << "what is no ASCII stays";
}

}  // namespace
}  // namespace handgraft
