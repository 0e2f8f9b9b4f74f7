#include "server/jpeg_decoder.h"

// jpeglib.h needs size_t and FILE.
#include <csetjmp>
#include <cstdio>
#include <string>

#include <jpeglib.h>
#include <opencv2/imgproc.hpp>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// A progressive file may ask for any number of passes over the image; real ones have about ten.
constexpr int kMaxScans = 64;

// libjpeg reports errors by a call that must not return. C++ objects with destructors must not live between
// the setjmp and the longjmp: they are all in the caller of DecodeInto.
struct ErrorManager {
  jpeg_error_mgr base;
  jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
};

struct ProgressMonitor {
  jpeg_progress_mgr base;
};

[[noreturn]] void OnError(j_common_ptr info) {
  auto* manager = reinterpret_cast<ErrorManager*>(info->err);
  info->err->format_message(info, manager->message);
  longjmp(manager->jump, 1);
}

void OnMessage(j_common_ptr info, int level) {
  if (level >= 0) return;  // tracing
  auto* manager = reinterpret_cast<ErrorManager*>(info->err);
  if (info->err->num_warnings++ == 0) info->err->format_message(info, manager->message);
}

void OnProgress(j_common_ptr info) {
  if (reinterpret_cast<j_decompress_ptr>(info)->input_scan_number <= kMaxScans) return;
  auto* manager = reinterpret_cast<ErrorManager*>(info->err);
  snprintf(manager->message, sizeof(manager->message), "more than %d scans", kMaxScans);
  longjmp(manager->jump, 1);
}

enum class Outcome { kDecoded, kDamaged, kOtherSize, kOtherColours };

void SetUp(jpeg_decompress_struct* info, ErrorManager* errors, ProgressMonitor* progress) {
  info->err = jpeg_std_error(&errors->base);
  errors->base.error_exit = OnError;
  errors->base.emit_message = OnMessage;
  errors->message[0] = '\0';
  progress->base.progress_monitor = OnProgress;
}

bool HasGreyOrColour(const jpeg_decompress_struct& info) {
  return info.jpeg_color_space == JCS_GRAYSCALE || info.jpeg_color_space == JCS_YCbCr ||
         info.jpeg_color_space == JCS_RGB;
}

// What is wanted of a file, and what it has.
struct Request {
  J_COLOR_SPACE wanted = JCS_GRAYSCALE;  // of `pixels`; JCS_YCbCr only of a file that is made of it
  cv::Mat* pixels = nullptr;             // allocated as large as the file should be
  J_COLOR_SPACE found = JCS_UNKNOWN;
};

Outcome ReadPixels(jpeg_decompress_struct* info, std::string_view file, Request* request) {
  cv::Mat* pixels = request->pixels;
  jpeg_mem_src(info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  jpeg_read_header(info, TRUE);
  if (static_cast<int64_t>(info->image_width) != pixels->cols ||
      static_cast<int64_t>(info->image_height) != pixels->rows) {
    return Outcome::kOtherSize;
  }
  request->found = info->jpeg_color_space;
  const bool convertible = request->wanted != JCS_YCbCr || request->found == JCS_YCbCr;
  if (!HasGreyOrColour(*info) || !convertible) return Outcome::kOtherColours;
  info->out_color_space = request->wanted;
  jpeg_start_decompress(info);
  while (info->output_scanline < info->output_height) {
    JSAMPROW row = pixels->ptr<uchar>(static_cast<int>(info->output_scanline));
    jpeg_read_scanlines(info, &row, 1);
  }
  jpeg_finish_decompress(info);
  return info->err->num_warnings == 0 ? Outcome::kDecoded : Outcome::kDamaged;
}

Outcome DecodeInto(std::string_view file, Request* request, ErrorManager* errors) {
  jpeg_decompress_struct info;
  ProgressMonitor progress;
  SetUp(&info, errors, &progress);
  if (setjmp(errors->jump) != 0) {
    jpeg_destroy_decompress(&info);
    return Outcome::kDamaged;
  }
  jpeg_create_decompress(&info);
  info.progress = &progress.base;
  const Outcome outcome = ReadPixels(&info, file, request);
  jpeg_destroy_decompress(&info);
  return outcome;
}

absl::Status ToStatus(Outcome outcome, cv::Size size, const ErrorManager& errors) {
  switch (outcome) {
    case Outcome::kDecoded:
      return absl::OkStatus();
    case Outcome::kOtherSize:
      return absl::OutOfRangeError(absl::StrCat("the JPEG file is not ", size.width, " x ", size.height));
    case Outcome::kOtherColours:
      return absl::UnimplementedError("the JPEG file is neither grey nor YCbCr nor RGB");
    case Outcome::kDamaged:
      break;
  }
  return absl::DataLossError(absl::StrCat("the JPEG file is damaged: ", errors.message));
}

// The colours of a file of which `luma_and_chroma` are the pixels as they are stored: Y, Cb, Cr.
JpegImage FromYcc(const cv::Mat& luma_and_chroma) {
  JpegImage image;
  cv::extractChannel(luma_and_chroma, image.grey, 0);
  // OpenCV wants Cr first.
  cv::Mat reordered(luma_and_chroma.size(), CV_8UC3);
  cv::mixChannels({luma_and_chroma}, {reordered}, {0, 0, 1, 2, 2, 1});
  cv::cvtColor(reordered, image.colour, cv::COLOR_YCrCb2BGR);
  return image;
}

}  // namespace

absl::StatusOr<cv::Mat> DecodeJpegGrey(std::string_view file, cv::Size size) {
  cv::Mat grey(size, CV_8UC1);
  ErrorManager errors;
  Request request{JCS_GRAYSCALE, &grey};
  SEMMAP_RETURN_IF_ERROR(ToStatus(DecodeInto(file, &request, &errors), size, errors));
  return grey;
}

absl::StatusOr<JpegImage> DecodeJpegColour(std::string_view file, cv::Size size) {
  cv::Mat pixels(size, CV_8UC3);
  ErrorManager errors;
  Request request{JCS_YCbCr, &pixels};
  const Outcome outcome = DecodeInto(file, &request, &errors);
  if (outcome == Outcome::kDecoded) return FromYcc(pixels);
  if (outcome != Outcome::kOtherColours) return ToStatus(outcome, size, errors);
  JpegImage image;
  SEMMAP_ASSIGN_OR_RETURN(image.grey, DecodeJpegGrey(file, size));
  image.colour = image.grey;
  if (request.found == JCS_GRAYSCALE) return image;
  Request stored_as_rgb{JCS_EXT_BGR, &pixels};
  SEMMAP_RETURN_IF_ERROR(ToStatus(DecodeInto(file, &stored_as_rgb, &errors), size, errors));
  image.colour = pixels;
  return image;
}

}  // namespace semmap::server
