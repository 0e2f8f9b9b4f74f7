#include "client/sources/source_image.h"

#include <filesystem>
#include <fstream>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

ImageEncoding EncodingOf(const std::string& bytes) {
  if (absl::StartsWith(bytes, "\xFF\xD8\xFF")) return ImageEncoding::kJpeg;
  if (absl::StartsWith(bytes, "\x89PNG\r\n\x1A\n")) return ImageEncoding::kPng;
  return ImageEncoding::kNone;
}

absl::StatusOr<std::string> ReadBytes(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return absl::NotFoundError(absl::StrCat(path, ": ", error.message()));
  if (size > kMaxImageBytes) {
    return absl::ResourceExhaustedError(absl::StrCat(path, ": larger than ", kMaxImageBytes, " bytes"));
  }
  std::string bytes(size, '\0');
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  }
  return bytes;
}

std::string NameOf(const SourceImage& image) { return image.path.empty() ? "image" : image.path; }

absl::StatusOr<cv::Mat> Decode(const std::string& bytes, int flags, const std::string& name) {
  try {
    const cv::Mat input(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<char*>(bytes.data()));
    cv::Mat pixels = cv::imdecode(input, flags);
    if (!pixels.empty()) return pixels;
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", error.what()));
  }
  return absl::InvalidArgumentError(absl::StrCat(name, ": is no image that can be decoded"));
}

}  // namespace

absl::StatusOr<SourceImage> ReadSourceImage(const std::string& path, bool is_depth) {
  SEMMAP_ASSIGN_OR_RETURN(std::string bytes, ReadBytes(path));
  SourceImage image;
  image.path = path;
  image.encoding = EncodingOf(bytes);
  if (image.encoding != ImageEncoding::kNone) {
    image.encoded = std::move(bytes);
    return image;
  }
  const int flags = is_depth ? cv::IMREAD_UNCHANGED : cv::IMREAD_GRAYSCALE;
  SEMMAP_ASSIGN_OR_RETURN(image.pixels, Decode(bytes, flags, path));
  return image;
}

absl::StatusOr<cv::Mat> DecodeColour(const SourceImage& image) {
  if (image.encoding != ImageEncoding::kNone) return Decode(image.encoded, cv::IMREAD_COLOR, NameOf(image));
  if (image.pixels.type() == CV_8UC3) return image.pixels;
  SEMMAP_ASSIGN_OR_RETURN(const cv::Mat grey, DecodeGray(image));
  cv::Mat colour;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

absl::StatusOr<cv::Mat> DecodeGray(const SourceImage& image) {
  if (image.encoding != ImageEncoding::kNone) {
    return Decode(image.encoded, cv::IMREAD_GRAYSCALE, NameOf(image));
  }
  if (image.pixels.type() == CV_8UC3) {
    cv::Mat grey;
    cv::cvtColor(image.pixels, grey, cv::COLOR_BGR2GRAY);
    return grey;
  }
  if (image.pixels.type() != CV_8UC1 || image.pixels.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(NameOf(image), ": is not an 8-bit grey image"));
  }
  return image.pixels;
}

absl::StatusOr<cv::Mat> DecodeDepth(const SourceImage& image) {
  cv::Mat pixels = image.pixels;
  if (image.encoding != ImageEncoding::kNone) {
    SEMMAP_ASSIGN_OR_RETURN(pixels, Decode(image.encoded, cv::IMREAD_UNCHANGED, NameOf(image)));
  }
  if (pixels.type() != CV_16UC1 || pixels.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(NameOf(image), ": is not a 16-bit depth image"));
  }
  return pixels;
}

absl::StatusOr<cv::Mat> DecodeClasses(const SourceImage& image) {
  cv::Mat pixels = image.pixels;
  if (image.encoding == ImageEncoding::kPng) {
    SEMMAP_ASSIGN_OR_RETURN(pixels, Decode(image.encoded, cv::IMREAD_UNCHANGED, NameOf(image)));
  }
  if (pixels.type() != CV_8UC1 || pixels.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(NameOf(image), ": is not an 8-bit grey PNG of class ids"));
  }
  return pixels;
}

absl::StatusOr<cv::Size> ImageSizeOf(const std::string& path) {
  SEMMAP_ASSIGN_OR_RETURN(const SourceImage image, ReadSourceImage(path, false));
  SEMMAP_ASSIGN_OR_RETURN(const cv::Mat pixels, DecodeGray(image));
  return pixels.size();
}

}  // namespace semmap::client
