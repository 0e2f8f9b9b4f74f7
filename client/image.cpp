#include "client/image.h"

#include <bit>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

static_assert(std::endian::native == std::endian::little,
              "raw depth goes over the wire as it lies in memory");

constexpr std::string_view kJpegStart = "\xff\xd8\xff";
constexpr std::string_view kPngStart = "\x89PNG";

v1::ImageEncoding EncodingOfType(int type) {
  switch (type) {
    case CV_8UC1:
      return v1::IMAGE_ENCODING_RAW_GRAY8;
    case CV_8UC3:
      return v1::IMAGE_ENCODING_RAW_BGR8;
    case CV_16UC1:
      return v1::IMAGE_ENCODING_RAW_DEPTH16;
    case CV_32FC1:
      return v1::IMAGE_ENCODING_RAW_DEPTH_F32;
    default:
      return v1::IMAGE_ENCODING_UNSPECIFIED;
  }
}

absl::StatusOr<v1::Image> Encode(const cv::Mat& pixels, const char* extension, v1::ImageEncoding encoding,
                                 const std::vector<int>& parameters) {
  std::vector<uchar> file;
  try {
    if (pixels.empty() || !cv::imencode(extension, pixels, file, parameters)) {
      return absl::InvalidArgumentError("the image cannot be encoded");
    }
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("the image cannot be encoded: ", error.err));
  }
  v1::Image image;
  image.set_encoding(encoding);
  image.set_data(file.data(), file.size());
  return image;
}

}  // namespace

absl::StatusOr<v1::Image> FileImage(std::string file_bytes) {
  v1::Image image;
  if (file_bytes.starts_with(kJpegStart)) {
    image.set_encoding(v1::IMAGE_ENCODING_JPEG);
  } else if (file_bytes.starts_with(kPngStart)) {
    image.set_encoding(v1::IMAGE_ENCODING_PNG);
  } else {
    return absl::InvalidArgumentError("the file is neither JPEG nor PNG");
  }
  image.set_data(std::move(file_bytes));
  return image;
}

absl::StatusOr<v1::Image> RawImage(const cv::Mat& pixels) {
  const v1::ImageEncoding encoding = EncodingOfType(pixels.type());
  if (pixels.empty() || encoding == v1::IMAGE_ENCODING_UNSPECIFIED) {
    return absl::InvalidArgumentError("raw images are CV_8UC1, CV_8UC3, CV_16UC1 or CV_32FC1 and not empty");
  }
  const cv::Mat packed = pixels.isContinuous() ? pixels : pixels.clone();
  v1::Image image;
  image.set_encoding(encoding);
  image.set_width(packed.cols);
  image.set_height(packed.rows);
  image.set_data(packed.data, packed.total() * packed.elemSize());
  return image;
}

absl::StatusOr<v1::Image> PngImage(const cv::Mat& pixels) {
  // Speed before size: a vehicle has little time.
  return Encode(pixels, ".png", v1::IMAGE_ENCODING_PNG, {cv::IMWRITE_PNG_COMPRESSION, 1});
}

absl::StatusOr<v1::Image> JpegImage(const cv::Mat& pixels, int quality) {
  if (quality < 1 || quality > 100) return absl::InvalidArgumentError("JPEG quality is 1 to 100");
  return Encode(pixels, ".jpg", v1::IMAGE_ENCODING_JPEG, {cv::IMWRITE_JPEG_QUALITY, quality});
}

}  // namespace semmap::client
