#include "server/jpeg_decoder.h"

// jpeglib.h needs size_t and FILE.
#include <csetjmp>
#include <cstdio>
#include <string>

#include <jpeglib.h>

#include "absl/strings/str_cat.h"

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

Outcome ReadPixels(jpeg_decompress_struct* info, std::string_view file, cv::Mat* grey) {
  jpeg_mem_src(info, reinterpret_cast<const unsigned char*>(file.data()), file.size());
  jpeg_read_header(info, TRUE);
  if (static_cast<int64_t>(info->image_width) != grey->cols ||
      static_cast<int64_t>(info->image_height) != grey->rows) {
    return Outcome::kOtherSize;
  }
  if (!HasGreyOrColour(*info)) return Outcome::kOtherColours;
  info->out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(info);
  while (info->output_scanline < info->output_height) {
    JSAMPROW row = grey->ptr<uchar>(static_cast<int>(info->output_scanline));
    jpeg_read_scanlines(info, &row, 1);
  }
  jpeg_finish_decompress(info);
  return info->err->num_warnings == 0 ? Outcome::kDecoded : Outcome::kDamaged;
}

Outcome DecodeInto(std::string_view file, cv::Mat* grey, ErrorManager* errors) {
  jpeg_decompress_struct info;
  ProgressMonitor progress;
  SetUp(&info, errors, &progress);
  if (setjmp(errors->jump) != 0) {
    jpeg_destroy_decompress(&info);
    return Outcome::kDamaged;
  }
  jpeg_create_decompress(&info);
  info.progress = &progress.base;
  const Outcome outcome = ReadPixels(&info, file, grey);
  jpeg_destroy_decompress(&info);
  return outcome;
}

}  // namespace

absl::StatusOr<cv::Mat> DecodeJpegGrey(std::string_view file, cv::Size size) {
  cv::Mat grey(size, CV_8UC1);
  ErrorManager errors;
  switch (DecodeInto(file, &grey, &errors)) {
    case Outcome::kDecoded:
      return grey;
    case Outcome::kOtherSize:
      return absl::OutOfRangeError(absl::StrCat("the JPEG file is not ", size.width, " x ", size.height));
    case Outcome::kOtherColours:
      return absl::UnimplementedError("the JPEG file is neither grey nor YCbCr nor RGB");
    case Outcome::kDamaged:
      break;
  }
  return absl::DataLossError(absl::StrCat("the JPEG file is damaged: ", errors.message));
}

}  // namespace semmap::server
