#include "core/base/error.h"

#include <gtest/gtest.h>

namespace kinegraph {
namespace {

TEST(Printable, LettersOfUtf8Stay) {
  for (const std::string text :
       {"", "camera 1", "Kamera ü", "カメラ", "😀 \u00a0\uffff"}) {
    EXPECT_EQ(Printable(text), text);
  }
}

// Terminals obey control characters, U+009B among them.
TEST(Printable, ControlCharactersAreReplaced) {
  EXPECT_EQ(Printable("a\nb\x1b[31m\x7f"), "a?b?[31m?");
  EXPECT_EQ(Printable("\xc2\x9b"), "?");
  EXPECT_EQ(Printable(std::string("a\0b", 3)), "a?b");
}

TEST(Printable, WhatIsNoUtf8IsReplaced) {
  EXPECT_EQ(Printable("\x80 \xff \xfe"), "? ? ?");  // begins no letter
  EXPECT_EQ(Printable("\xc3 \xe3\x82"), "? ??");    // ends before its end
  EXPECT_EQ(Printable("\xc0\xaf \xe0\x80\xaf"), "?? ???");  // too long
  EXPECT_EQ(Printable("\xed\xa0\x80"), "???");              // half of a pair
  EXPECT_EQ(Printable("\xf4\x90\x80\x80"), "????");         // beyond the last
  EXPECT_EQ(Printable("\xf8\x88\x80\x80\x80"), "?????");
}

TEST(Printable, IsCutBetweenLetters) {
  EXPECT_EQ(Printable("abcdef", 6), "abcdef");
  EXPECT_EQ(Printable("abcdef", 4), "abcd...");
  EXPECT_EQ(Printable("aüüü", 4), "aüü...");
}

}  // namespace
}  // namespace kinegraph
