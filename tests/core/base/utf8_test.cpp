#include "core/base/utf8.h"

#include <gtest/gtest.h>

namespace handgraft {
namespace {

TEST(Utf8, ValidTextIsShownAsItIs) {
  for (const char* text : {"thumb", "Größe", "杯子", "🍋", "e\u0301"})
    EXPECT_EQ(onOneLine(text), text);
}

TEST(Utf8, ControlCharactersAreNotShown) {
  EXPECT_EQ(onOneLine("a\nb\x1b[2Jc\x7f"), "a?b?[2Jc?");
  EXPECT_EQ(onOneLine("a\u009b2Jb"), "a?2Jb") << "one byte of Latin-1, and terminals obey it";
  EXPECT_EQ(onOneLine("a\u202eb\u2028c"), "a?b?c");
}

TEST(Utf8, BytesThatAreNoCharacterAreNotShown) {
  EXPECT_EQ(onOneLine("Gr\xf6\xdf"
                      "e"),
            "Gr??e")
      << "Latin-1";
  EXPECT_EQ(onOneLine("a\xc0\x8a"), "a??") << "a line break written too long";
  EXPECT_EQ(onOneLine("\xed\xa0\x80"), "???") << "half of a pair";
  EXPECT_EQ(onOneLine("\xf4\x90\x80\x80"), "????") << "above U+10FFFF";
  EXPECT_EQ(onOneLine("\xe6\x9d"), "??") << "cut";
  EXPECT_EQ(onOneLine("\xff"), "?");
  EXPECT_EQ(onOneLine("\uFFFD"), "\uFFFD") << "a character of its own";
}

TEST(Utf8, IsCutBetweenCharacters) {
  EXPECT_EQ(onOneLine("杯子", 2), "杯子");
  EXPECT_EQ(onOneLine("杯子架", 2), "杯子...");
  EXPECT_EQ(onOneLine("", 0), "");
}

TEST(Utf8, ColumnsAreThoseOfATerminal) {
  EXPECT_EQ(columnsOf(""), 0u);
  EXPECT_EQ(columnsOf("thumb"), 5u);
  EXPECT_EQ(columnsOf("Größe"), 5u);
  EXPECT_EQ(columnsOf("杯子"), 4u);
  EXPECT_EQ(columnsOf("e\u0301"), 1u);
}

TEST(Utf8, AMarkAtTheBeginningIsNoText) {
  EXPECT_EQ(withoutByteOrderMark("\xEF\xBB\xBFtime_s"), "time_s");
  EXPECT_EQ(withoutByteOrderMark("time_s\xEF\xBB\xBF"), "time_s\xEF\xBB\xBF");
  EXPECT_EQ(withoutByteOrderMark("\xEF\xBB"), "\xEF\xBB");
  EXPECT_EQ(withoutByteOrderMark(""), "");
}

}  // namespace
}  // namespace handgraft
