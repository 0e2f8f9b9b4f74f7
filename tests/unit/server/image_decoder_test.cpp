#include "server/image_decoder.h"

#include <limits>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "server/error_reasons.h"

namespace semmap::server {
namespace {

const cv::Size kSize(160, 120);

// A gradient with noise, so that compressed data is dense and damage shows.
cv::Mat TestImage(int type = CV_8UC1) {
  cv::Mat image(kSize, type);
  cv::RNG random(7);
  random.fill(image, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(image, image, {}, 1.5);
  return image;
}

v1::Image FileOf(const cv::Mat& pixels, const char* extension) {
  std::vector<uchar> bytes;
  cv::imencode(extension, pixels, bytes);
  v1::Image image;
  image.set_encoding(std::string(extension) == ".jpg" ? v1::IMAGE_ENCODING_JPEG : v1::IMAGE_ENCODING_PNG);
  image.set_data(bytes.data(), bytes.size());
  return image;
}

v1::Image RawOf(const cv::Mat& pixels, v1::ImageEncoding encoding) {
  v1::Image image;
  image.set_encoding(encoding);
  image.set_width(pixels.cols);
  image.set_height(pixels.rows);
  image.set_data(pixels.data, pixels.total() * pixels.elemSize());
  return image;
}

absl::StatusOr<cv::Mat> Decode(const v1::Image& image, ImageRole role = ImageRole::kGrey,
                               cv::Size size = kSize) {
  return DecodeImage(image, role, size, "image", 7);
}

v1::ErrorReason ReasonFor(const v1::Image& image, ImageRole role = ImageRole::kGrey, cv::Size size = kSize) {
  return ReasonOf(Decode(image, role, size).status());
}

double MaxDifference(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF); }

TEST(ImageDecoder, DecodesEveryEncoding) {
  const cv::Mat grey = TestImage();
  const cv::Mat colour = TestImage(CV_8UC3);
  cv::Mat grey_of_colour;
  cv::cvtColor(colour, grey_of_colour, cv::COLOR_BGR2GRAY);
  EXPECT_EQ(MaxDifference(*Decode(FileOf(grey, ".png")), grey), 0);
  EXPECT_EQ(MaxDifference(*Decode(RawOf(grey, v1::IMAGE_ENCODING_RAW_GRAY8)), grey), 0);
  EXPECT_EQ(MaxDifference(*Decode(RawOf(colour, v1::IMAGE_ENCODING_RAW_BGR8)), grey_of_colour), 0);
  EXPECT_EQ(MaxDifference(*Decode(FileOf(colour, ".png")), grey_of_colour), 0);
}

TEST(ImageDecoder, DecodesJpegAsOpenCvDoes) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const v1::Image file = FileOf(TestImage(type), ".jpg");
    const std::vector<uchar> bytes(file.data().begin(), file.data().end());
    const auto decoded = Decode(file);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(MaxDifference(*decoded, cv::imdecode(bytes, cv::IMREAD_GRAYSCALE)), 0);
  }
}

// Colours cost nothing of the grey image, and are those that OpenCV decodes.
TEST(ImageDecoder, KeepsColours) {
  const cv::Mat colour = TestImage(CV_8UC3);
  cv::Mat rgb;
  cv::cvtColor(colour, rgb, cv::COLOR_BGR2RGB);
  const std::vector<v1::Image> images = {FileOf(colour, ".png"), RawOf(colour, v1::IMAGE_ENCODING_RAW_BGR8),
                                         RawOf(rgb, v1::IMAGE_ENCODING_RAW_RGB8)};
  for (const v1::Image& image : images) {
    const auto decoded = DecodeColourImage(image, kSize, "image", 7);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(MaxDifference(decoded->colour, colour), 0);
    EXPECT_EQ(MaxDifference(decoded->grey, *Decode(image)), 0);
  }
  const v1::Image jpeg = FileOf(colour, ".jpg");
  const auto decoded = DecodeColourImage(jpeg, kSize, "image", 7);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  const std::vector<uchar> bytes(jpeg.data().begin(), jpeg.data().end());
  EXPECT_LE(MaxDifference(decoded->colour, cv::imdecode(bytes, cv::IMREAD_COLOR)), 2);
  EXPECT_EQ(MaxDifference(decoded->grey, *Decode(jpeg)), 0);
}

TEST(ImageDecoder, GreyImagesHaveNoOtherColours) {
  for (const char* extension : {".jpg", ".png"}) {
    const v1::Image image = FileOf(TestImage(), extension);
    const auto decoded = DecodeColourImage(image, kSize, "image", 7);
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(decoded->colour.type(), CV_8UC1);
    EXPECT_EQ(MaxDifference(decoded->colour, *Decode(image)), 0);
  }
}

TEST(ImageDecoder, ColourImagesAreCheckedAlike) {
  v1::Image cut = FileOf(TestImage(CV_8UC3), ".jpg");
  cut.mutable_data()->resize(cut.data().size() / 2);
  EXPECT_EQ(ReasonOf(DecodeColourImage(cut, kSize, "image", 7).status()), v1::ERROR_REASON_IMAGE_CORRUPT);
  const v1::Image whole = FileOf(TestImage(CV_8UC3), ".jpg");
  EXPECT_EQ(ReasonOf(DecodeColourImage(whole, {200, 120}, "image", 7).status()),
            v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
}

TEST(ImageDecoder, DecodesDepthOfEveryKind) {
  cv::Mat millimetres(kSize, CV_16UC1, cv::Scalar(12345));
  EXPECT_EQ(MaxDifference(*Decode(FileOf(millimetres, ".png"), ImageRole::kDepth), millimetres), 0);
  EXPECT_EQ(MaxDifference(*Decode(RawOf(millimetres, v1::IMAGE_ENCODING_RAW_DEPTH16), ImageRole::kDepth),
                          millimetres),
            0);
  cv::Mat metres(kSize, CV_32FC1, cv::Scalar(2.5));
  metres.at<float>(3, 4) = std::numeric_limits<float>::quiet_NaN();
  metres.at<float>(5, 6) = std::numeric_limits<float>::infinity();
  const auto decoded = Decode(RawOf(metres, v1::IMAGE_ENCODING_RAW_DEPTH_F32), ImageRole::kDepth);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->at<float>(3, 4), 0);
  EXPECT_EQ(decoded->at<float>(5, 6), 0);
  EXPECT_EQ(decoded->at<float>(0, 0), 2.5F);
}

// Every proper prefix of a file is damaged, wherever it is cut.
TEST(ImageDecoder, FindsEveryTruncation) {
  for (const char* extension : {".jpg", ".png"}) {
    const v1::Image whole = FileOf(TestImage(), extension);
    ASSERT_TRUE(Decode(whole).ok());
    for (size_t length = 0; length < whole.data().size(); length += 1 + whole.data().size() / 200) {
      v1::Image cut = whole;
      cut.mutable_data()->resize(length);
      EXPECT_EQ(ReasonFor(cut), v1::ERROR_REASON_IMAGE_CORRUPT) << extension << " cut at " << length;
    }
    v1::Image cut = whole;
    cut.mutable_data()->pop_back();
    EXPECT_EQ(ReasonFor(cut), v1::ERROR_REASON_IMAGE_CORRUPT) << extension << " without its last byte";
  }
}

TEST(ImageDecoder, FindsEveryFlippedBitOfPng) {
  const v1::Image whole = FileOf(TestImage(), ".png");
  for (size_t at = 0; at < whole.data().size(); at += 97) {
    v1::Image damaged = whole;
    (*damaged.mutable_data())[at] = static_cast<char>((*damaged.mutable_data())[at] ^ 0x10);
    EXPECT_EQ(ReasonFor(damaged), v1::ERROR_REASON_IMAGE_CORRUPT) << "byte " << at;
  }
}

// JPEG has no checksum, so one wrong bit can make another valid picture; a stretch of overwritten data
// cannot.
TEST(ImageDecoder, FindsOverwrittenJpegData) {
  const v1::Image whole = FileOf(TestImage(), ".jpg");
  const size_t size = whole.data().size();
  for (const size_t at : {size / 4, size / 2, 3 * size / 4}) {
    v1::Image damaged = whole;
    for (size_t i = at; i < at + 64; ++i) (*damaged.mutable_data())[i] = static_cast<char>(0xFF);
    EXPECT_EQ(ReasonFor(damaged), v1::ERROR_REASON_IMAGE_CORRUPT) << "at " << at;
  }
}

TEST(ImageDecoder, RefusesNonsense) {
  v1::Image image;
  image.set_encoding(v1::IMAGE_ENCODING_JPEG);
  EXPECT_EQ(ReasonFor(image), v1::ERROR_REASON_IMAGE_CORRUPT);
  image.set_data("this is not a picture");
  EXPECT_EQ(ReasonFor(image), v1::ERROR_REASON_IMAGE_CORRUPT);
  image.set_encoding(v1::IMAGE_ENCODING_PNG);
  EXPECT_EQ(ReasonFor(image), v1::ERROR_REASON_IMAGE_CORRUPT);
  image.clear_encoding();
  EXPECT_EQ(ReasonFor(image), v1::ERROR_REASON_IMAGE_ENCODING_UNSUPPORTED);
  // A PNG file under JPEG's name.
  v1::Image swapped = FileOf(TestImage(), ".png");
  swapped.set_encoding(v1::IMAGE_ENCODING_JPEG);
  EXPECT_EQ(ReasonFor(swapped), v1::ERROR_REASON_IMAGE_CORRUPT);
}

TEST(ImageDecoder, ComparesSizesBeforeItDecodes) {
  const cv::Size other(200, 120);
  EXPECT_EQ(ReasonFor(FileOf(TestImage(), ".jpg"), ImageRole::kGrey, other),
            v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
  EXPECT_EQ(ReasonFor(FileOf(TestImage(), ".png"), ImageRole::kGrey, other),
            v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
  EXPECT_EQ(ReasonFor(RawOf(TestImage(), v1::IMAGE_ENCODING_RAW_GRAY8), ImageRole::kGrey, other),
            v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
  v1::Image contradicts = FileOf(TestImage(), ".jpg");
  contradicts.set_width(161);
  contradicts.set_height(120);
  EXPECT_EQ(ReasonFor(contradicts), v1::ERROR_REASON_IMAGE_SIZE_MISMATCH);
}

TEST(ImageDecoder, RawDataHasTheRightLength) {
  v1::Image raw = RawOf(TestImage(), v1::IMAGE_ENCODING_RAW_GRAY8);
  raw.mutable_data()->pop_back();
  EXPECT_EQ(ReasonFor(raw), v1::ERROR_REASON_IMAGE_CORRUPT);
  raw.mutable_data()->append("xx");
  EXPECT_EQ(ReasonFor(raw), v1::ERROR_REASON_IMAGE_CORRUPT);
}

TEST(ImageDecoder, EncodingsSuitTheRole) {
  const cv::Mat grey = TestImage();
  const v1::ErrorReason unsupported = v1::ERROR_REASON_IMAGE_ENCODING_UNSUPPORTED;
  EXPECT_EQ(ReasonFor(FileOf(grey, ".jpg"), ImageRole::kDepth), unsupported);
  EXPECT_EQ(ReasonFor(FileOf(grey, ".jpg"), ImageRole::kClassMask), unsupported);
  EXPECT_EQ(ReasonFor(FileOf(TestImage(CV_8UC3), ".png"), ImageRole::kDepth), unsupported);
  EXPECT_EQ(ReasonFor(FileOf(cv::Mat(kSize, CV_16UC1), ".png"), ImageRole::kGrey), unsupported);
  EXPECT_EQ(ReasonFor(FileOf(cv::Mat(kSize, CV_16UC1), ".png"), ImageRole::kClassMask), unsupported);
  EXPECT_EQ(ReasonFor(RawOf(grey, v1::IMAGE_ENCODING_RAW_GRAY8), ImageRole::kDepth), unsupported);
  EXPECT_EQ(ReasonFor(RawOf(cv::Mat(kSize, CV_16UC1), v1::IMAGE_ENCODING_RAW_DEPTH16)), unsupported);
  EXPECT_EQ(MaxDifference(*Decode(FileOf(grey, ".png"), ImageRole::kClassMask), grey), 0);
}

}  // namespace
}  // namespace semmap::server
