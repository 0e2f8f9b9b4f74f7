#include "client/sources/source_image.h"

#include "client/sources/file_list.h"
#include "tests/unit/sources/source_test_util.h"

namespace semmap::client {
namespace {

TEST(NaturalLess, ComparesNumbersByValue) {
  EXPECT_TRUE(NaturalLess("frame2.png", "frame10.png"));
  EXPECT_FALSE(NaturalLess("frame10.png", "frame2.png"));
  EXPECT_TRUE(NaturalLess("a9b1", "a10b0"));
  EXPECT_TRUE(NaturalLess("frame", "frame1"));
  EXPECT_FALSE(NaturalLess("x", "x"));
  // Equal numbers, different text: still one order, never both.
  EXPECT_NE(NaturalLess("f1", "f01"), NaturalLess("f01", "f1"));
}

using SourceImageTest = SourceTest;

TEST_F(SourceImageTest, KeepsTheBytesOfJpegAndPng) {
  WriteGray("a.png", 77);
  WriteGray("a.jpg", 77);
  for (const auto& [name, encoding] :
       {std::pair{"a.png", ImageEncoding::kPng}, std::pair{"a.jpg", ImageEncoding::kJpeg}}) {
    const auto image = ReadSourceImage(Path(name), false);
    ASSERT_TRUE(image.ok()) << image.status();
    EXPECT_EQ(image->encoding, encoding);
    EXPECT_EQ(image->encoded.size(), std::filesystem::file_size(Path(name)));
    EXPECT_TRUE(image->pixels.empty());
    EXPECT_EQ(LevelOf(*image), 77);
  }
}

TEST_F(SourceImageTest, DecodesOtherFormats) {
  WriteGray("a.pgm", 99);
  const auto image = ReadSourceImage(Path("a.pgm"), false);
  ASSERT_TRUE(image.ok()) << image.status();
  EXPECT_EQ(image->encoding, ImageEncoding::kNone);
  EXPECT_EQ(LevelOf(*image), 99);
}

TEST_F(SourceImageTest, ColourBecomesGrey) {
  ASSERT_TRUE(cv::imwrite(Path("c.png"), cv::Mat(8, 8, CV_8UC3, cv::Scalar(255, 0, 0))));
  const auto pixels = DecodeGray(ReadSourceImage(Path("c.png"), false).value());
  ASSERT_TRUE(pixels.ok());
  EXPECT_EQ(pixels->type(), CV_8UC1);
  EXPECT_NEAR(pixels->at<uint8_t>(4, 4), 29, 1);
}

TEST_F(SourceImageTest, ColourPixelsBecomeGreyToo) {
  SourceImage image;
  image.pixels = cv::Mat(4, 5, CV_8UC3, cv::Scalar(255, 0, 0));  // blue
  const auto pixels = DecodeGray(image);
  ASSERT_TRUE(pixels.ok()) << pixels.status();
  EXPECT_EQ(pixels->type(), CV_8UC1);
  EXPECT_NEAR(pixels->at<uint8_t>(3, 4), 29, 1);
}

TEST_F(SourceImageTest, DepthMustHaveSixteenBits) {
  WriteDepth("d.png", 4321);
  WriteGray("g.png", 1);
  const auto depth = DecodeDepth(ReadSourceImage(Path("d.png"), true).value());
  ASSERT_TRUE(depth.ok());
  EXPECT_EQ(depth->at<uint16_t>(3, 3), 4321);
  EXPECT_EQ(DecodeDepth(ReadSourceImage(Path("g.png"), true).value()).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(SourceImageTest, SaysWhatIsWrong) {
  WriteText("broken.png", "\x89PNG\r\n\x1A\n but not really");
  WriteText("text.png", "hello");
  WriteText("empty.png", "");
  EXPECT_EQ(DecodeGray(ReadSourceImage(Path("broken.png"), false).value()).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadSourceImage(Path("text.png"), false).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadSourceImage(Path("empty.png"), false).status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(ReadSourceImage(Path("none.png"), false).status().code(), absl::StatusCode::kNotFound);
  EXPECT_FALSE(ReadSourceImage(root_.string(), false).ok());
}

}  // namespace
}  // namespace semmap::client
