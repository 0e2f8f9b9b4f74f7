#include "storage/validation.h"

#include <gtest/gtest.h>

namespace semmap::storage {
namespace {

TEST(IsUtf8, WellFormedText) {
  for (const char* text :
       {"", "town", "\xC3\xBC", "\xE2\x82\xAC", "\xF0\x9F\x9A\x97", "\xF4\x8F\xBF\xBF", "\x01"}) {
    EXPECT_TRUE(IsUtf8(text)) << text;
  }
}

// Too long forms, halves of pairs, beyond the last code point, cut short.
TEST(IsUtf8, IllFormedText) {
  for (const char* text :
       {"\x80", "\xC0\xAF", "\xC1\xBF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF0\x80\x80\x80",
        "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xC3", "\xE2\x82", "\xF0\x9F\x9A", "a\xFF", "\xC3\x28"}) {
    EXPECT_FALSE(IsUtf8(text)) << text;
  }
}

}  // namespace
}  // namespace semmap::storage
