#include "storage/labels_codec.h"

#include <gtest/gtest.h>

namespace semmap::storage {
namespace {

using Labels = std::map<std::string, std::string>;

TEST(LabelsCodec, ThereAndBack) {
  for (const Labels& labels :
       {Labels(), Labels{{"a", ""}}, Labels{{"a", "b"}, {"key", std::string(1000, 'v')}}}) {
    const auto decoded = DecodeLabels(EncodeLabels(labels));
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, labels);
  }
}

TEST(LabelsCodec, NothingElseIsDecoded) {
  const Blob sound = EncodeLabels({{"a", "b"}, {"key", "value"}});
  for (size_t size = 0; size < sound.size(); ++size) {
    // Cut between two labels it is whole.
    if (size == 1 || size == 5) continue;
    EXPECT_TRUE(absl::IsDataLoss(DecodeLabels(BlobView(sound).first(size)).status())) << size;
  }
  Blob other_format = sound;
  other_format[0] = 2;
  EXPECT_TRUE(absl::IsDataLoss(DecodeLabels(other_format).status()));
  Blob huge = sound;
  huge[1] = 0xFF;
  EXPECT_TRUE(absl::IsDataLoss(DecodeLabels(huge).status()));
  const Blob twice = {1, 1, 'a', 0, 1, 'a', 0};
  EXPECT_TRUE(absl::IsDataLoss(DecodeLabels(twice).status()));
}

}  // namespace
}  // namespace semmap::storage
