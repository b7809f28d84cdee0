#include "client/editor/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/editor/quantity.h"
#include "core/base/error.h"

namespace handgraft::client::editor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Words, AreCutAtBlanksAndCommandsAtSemicolons) {
  EXPECT_THAT(commandsOf("  lock  thumb_mcp ;solve; "),
              ElementsAre(ElementsAre("lock", "thumb_mcp"), ElementsAre("solve")));
  EXPECT_THAT(commandsOf(" \t "), IsEmpty());
  EXPECT_THAT(commandsOf(""), IsEmpty());
  EXPECT_THAT(commandsOf(";;"), IsEmpty());
}

TEST(Words, HoldWhatIsQuotedTogether) {
  EXPECT_THAT(commandsOf("save \"my file;1.json\"  'a # b'"),
              ElementsAre(ElementsAre("save", "my file;1.json", "a # b")));
  EXPECT_THAT(commandsOf("save ''"), ElementsAre(ElementsAre("save", "")));
  EXPECT_THAT(commandsOf("save my' 'file"), ElementsAre(ElementsAre("save", "my file")));
}

TEST(Words, EndAtAComment) {
  EXPECT_THAT(commandsOf("undo # the last; solve"), ElementsAre(ElementsAre("undo")));
  EXPECT_THAT(commandsOf("# all of it"), IsEmpty());
  EXPECT_THAT(commandsOf("save a#b"), ElementsAre(ElementsAre("save", "a#b")));
}

TEST(Words, NameTheQuoteThatIsNotClosed) {
  try {
    commandsOf("save \"half");
    FAIL() << "an open quote was taken";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("column 6"));
  }
}

TEST(Words, OfALineThatIsBeingWrittenEndInAPrefix) {
  const Unfinished middle = unfinishedOf("solve; limit thumb_m");
  EXPECT_THAT(middle.words, ElementsAre("limit"));
  EXPECT_EQ(middle.prefix, "thumb_m");
  const Unfinished next = unfinishedOf("limit thumb_mcp ");
  EXPECT_THAT(next.words, ElementsAre("limit", "thumb_mcp"));
  EXPECT_EQ(next.prefix, "");
  const Unfinished quote = unfinishedOf("save \"my fi");
  EXPECT_THAT(quote.words, ElementsAre("save"));
  EXPECT_EQ(quote.prefix, "my fi");
  EXPECT_EQ(quote.quote, '"');
  EXPECT_TRUE(unfinishedOf("undo # ").comment);
}

TEST(Words, AreWrittenSoThatTheyAreReadAgain) {
  for (const std::string word : {"thumb", "a b", "a;b", "", "#a", "it's", "say \"so\""}) {
    EXPECT_THAT(commandsOf("x " + asWord(word)), ElementsAre(ElementsAre("x", word)));
  }
}

TEST(Quantity, ReadsUnits) {
  EXPECT_EQ(quantityOf("0.4")->value, 0.4);
  EXPECT_EQ(quantityOf("0.4")->unit, Unit::kNone);
  EXPECT_NEAR(quantityOf("+180deg")->value, 3.14159265358979, 1e-12);
  EXPECT_EQ(quantityOf("-1e-1rad")->value, -0.1);
  EXPECT_EQ(quantityOf("20mm")->value, 0.02);
  EXPECT_EQ(quantityOf("20mm")->unit, Unit::kLength);
  EXPECT_EQ(quantityOf("2cm")->value, 0.02);
  EXPECT_EQ(quantityOf("2m")->value, 2.0);
  EXPECT_NEAR(quantityOf("-0.5in")->value, -0.0127, 1e-12);
  EXPECT_EQ(quantityOf("1in")->unit, Unit::kLength);
}

TEST(Quantity, RefusesWhatIsNone) {
  for (const char* text :
       {"", "+", "-", "deg", "1 deg", "1degs", "nan", "inf", "1e999", "+-1", "1,5", "0x1"}) {
    EXPECT_FALSE(quantityOf(text)) << text;
  }
}

TEST(Quantity, CountsAreWholeAndNotNegative) {
  EXPECT_EQ(countOf("0"), 0U);
  EXPECT_EQ(countOf("18446744073709551615"), 18446744073709551615U);
  for (const char* text : {"", "-1", "1.5", "18446744073709551616", "1x", "+1"}) {
    EXPECT_FALSE(countOf(text)) << text;
  }
}

}  // namespace
}  // namespace handgraft::client::editor
