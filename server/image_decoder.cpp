#include "server/image_decoder.h"

#include <bit>
#include <cmath>
#include <cstring>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/jpeg_decoder.h"
#include "server/png_file.h"

namespace semmap::server {
namespace {

static_assert(std::endian::native == std::endian::little, "raw depth is taken as it is sent, little endian");

absl::Status Unsupported(const std::string& why) {
  return Error(v1::ERROR_REASON_IMAGE_ENCODING_UNSUPPORTED, why);
}
absl::Status Corrupt(const std::string& why) { return Error(v1::ERROR_REASON_IMAGE_CORRUPT, why); }
absl::Status OtherSize(int64_t width, int64_t height, cv::Size size) {
  return Error(v1::ERROR_REASON_IMAGE_SIZE_MISMATCH,
               absl::StrCat("is ", width, " x ", height, ", the rig says ", size.width, " x ", size.height));
}

// What of an encoding's pixels lies in memory; 0 bytes: not a raw encoding of this role.
struct RawLayout {
  int type = 0;
  size_t bytes_per_pixel = 0;
};

RawLayout LayoutOf(v1::ImageEncoding encoding, ImageRole role) {
  const bool depth = role == ImageRole::kDepth;
  switch (encoding) {
    case v1::IMAGE_ENCODING_RAW_GRAY8:
      return depth ? RawLayout{} : RawLayout{CV_8UC1, 1};
    case v1::IMAGE_ENCODING_RAW_RGB8:
    case v1::IMAGE_ENCODING_RAW_BGR8:
      return role == ImageRole::kGrey ? RawLayout{CV_8UC3, 3} : RawLayout{};
    case v1::IMAGE_ENCODING_RAW_DEPTH16:
      return depth ? RawLayout{CV_16UC1, 2} : RawLayout{};
    case v1::IMAGE_ENCODING_RAW_DEPTH_F32:
      return depth ? RawLayout{CV_32FC1, 4} : RawLayout{};
    default:
      return {};
  }
}

cv::Mat CopyRaw(const v1::Image& image, const RawLayout& layout, cv::Size size) {
  cv::Mat pixels(size, layout.type);
  std::memcpy(pixels.data, image.data().data(), image.data().size());
  if (image.encoding() == v1::IMAGE_ENCODING_RAW_RGB8) cv::cvtColor(pixels, pixels, cv::COLOR_RGB2BGR);
  if (layout.type == CV_32FC1) cv::patchNaNs(pixels, 0.0);
  return pixels;
}

// patchNaNs leaves infinities.
void ZeroInfinities(cv::Mat* depth) {
  depth->forEach<float>([](float& value, const int*) {
    if (!std::isfinite(value)) value = 0.0F;
  });
}

absl::StatusOr<cv::Mat> DecodeRaw(const v1::Image& image, ImageRole role, cv::Size size) {
  const RawLayout layout = LayoutOf(image.encoding(), role);
  if (layout.bytes_per_pixel == 0) return Unsupported("has an encoding that does not suit it");
  if (image.width() != size.width || image.height() != size.height) {
    return OtherSize(image.width(), image.height(), size);
  }
  const size_t expected = static_cast<size_t>(size.area()) * layout.bytes_per_pixel;
  if (image.data().size() != expected) {
    return Corrupt(absl::StrCat("has ", image.data().size(), " bytes, must have ", expected));
  }
  cv::Mat pixels = CopyRaw(image, layout, size);
  if (layout.type == CV_32FC1) ZeroInfinities(&pixels);
  return pixels;
}

absl::Status JpegError(const absl::Status& status) {
  const std::string message(status.message());
  switch (status.code()) {
    case absl::StatusCode::kOutOfRange:
      return Error(v1::ERROR_REASON_IMAGE_SIZE_MISMATCH, message);
    case absl::StatusCode::kUnimplemented:
      return Unsupported(message);
    default:
      return Corrupt(message);
  }
}

absl::Status CheckPngLayout(const PngHeader& header, ImageRole role) {
  if (role == ImageRole::kGrey) {
    return header.bit_depth <= 8 ? absl::OkStatus() : Unsupported("must have 8 bits a channel");
  }
  if (!header.grey) return Unsupported("must be a grey PNG file");
  const bool fits = header.bit_depth == 8 || (role == ImageRole::kDepth && header.bit_depth == 16);
  return fits ? absl::OkStatus() : Unsupported("has a bit depth that does not suit it");
}

// Empty when OpenCV cannot decode it.
cv::Mat DecodeWithOpenCv(const std::string& file, int flags) {
  try {
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1, const_cast<char*>(file.data()));
    return cv::imdecode(bytes, flags);
  } catch (const cv::Exception&) {
    return {};
  }
}

absl::StatusOr<cv::Mat> DecodePng(const v1::Image& image, ImageRole role, cv::Size size) {
  const auto header = CheckPngFile(image.data());
  if (!header.ok()) return Corrupt(std::string(header.status().message()));
  if (header->width != size.width || header->height != size.height) {
    return OtherSize(header->width, header->height, size);
  }
  if (absl::Status status = CheckPngLayout(*header, role); !status.ok()) return status;
  int flags = cv::IMREAD_UNCHANGED;
  if (role == ImageRole::kGrey) flags = header->grey ? cv::IMREAD_GRAYSCALE : cv::IMREAD_COLOR;
  cv::Mat pixels = DecodeWithOpenCv(image.data(), flags);
  if (pixels.size() != size) return Corrupt("cannot be decoded");
  if (role != ImageRole::kGrey && pixels.channels() != 1) return Unsupported("must have one channel");
  if (role == ImageRole::kDepth && pixels.type() == CV_8UC1) pixels.convertTo(pixels, CV_16U);
  return pixels;
}

bool IsFile(const v1::Image& image) {
  return image.encoding() == v1::IMAGE_ENCODING_JPEG || image.encoding() == v1::IMAGE_ENCODING_PNG;
}

// What a message says about the size of a file must be true.
absl::Status CheckDeclaredSize(const v1::Image& image, cv::Size size) {
  const bool says_size = image.width() != 0 || image.height() != 0;
  const bool right = image.width() == size.width && image.height() == size.height;
  return says_size && !right ? OtherSize(image.width(), image.height(), size) : absl::OkStatus();
}

// Everything but JPEG. Images of ImageRole::kGrey come as BGR if they have colours.
absl::StatusOr<cv::Mat> DecodeLossless(const v1::Image& image, ImageRole role, cv::Size size) {
  if (!IsFile(image)) return DecodeRaw(image, role, size);
  if (absl::Status status = CheckDeclaredSize(image, size); !status.ok()) return status;
  // Lossy compression invents depths and classes.
  if (image.encoding() == v1::IMAGE_ENCODING_JPEG) return Unsupported("must not be JPEG");
  return DecodePng(image, role, size);
}

absl::StatusOr<ColourImage> DecodeJpeg(const v1::Image& image, bool with_colour, cv::Size size) {
  if (absl::Status status = CheckDeclaredSize(image, size); !status.ok()) return status;
  if (with_colour) {
    auto decoded = DecodeJpegColour(image.data(), size);
    if (!decoded.ok()) return JpegError(decoded.status());
    return ColourImage{decoded->grey, decoded->colour};
  }
  auto grey = DecodeJpegGrey(image.data(), size);
  if (!grey.ok()) return JpegError(grey.status());
  return ColourImage{*grey, {}};
}

absl::StatusOr<ColourImage> DecodePicture(const v1::Image& image, bool with_colour, cv::Size size) {
  if (image.encoding() == v1::IMAGE_ENCODING_JPEG) return DecodeJpeg(image, with_colour, size);
  auto pixels = DecodeLossless(image, ImageRole::kGrey, size);
  if (!pixels.ok()) return pixels.status();
  if (pixels->channels() == 1) return ColourImage{*pixels, *pixels};
  ColourImage picture{{}, *pixels};
  cv::cvtColor(picture.colour, picture.grey, cv::COLOR_BGR2GRAY);
  return picture;
}

absl::Status WithField(const absl::Status& status, const char* field, uint64_t sequence) {
  return Error(ReasonOf(status), absl::StrCat(field, " of frame ", sequence, ": ", status.message()),
               {{"field", field}, {"sequence", std::to_string(sequence)}});
}

}  // namespace

absl::StatusOr<ColourImage> DecodeColourImage(const v1::Image& image, cv::Size size, const char* field,
                                              uint64_t sequence) {
  auto picture = DecodePicture(image, true, size);
  if (!picture.ok()) return WithField(picture.status(), field, sequence);
  return picture;
}

absl::StatusOr<cv::Mat> DecodeImage(const v1::Image& image, ImageRole role, cv::Size size, const char* field,
                                    uint64_t sequence) {
  if (role == ImageRole::kGrey) {
    auto picture = DecodePicture(image, false, size);
    if (!picture.ok()) return WithField(picture.status(), field, sequence);
    return std::move(picture->grey);
  }
  auto pixels = DecodeLossless(image, role, size);
  if (!pixels.ok()) return WithField(pixels.status(), field, sequence);
  return pixels;
}

}  // namespace semmap::server
