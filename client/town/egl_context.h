#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace semmap::town {

// An OpenGL 4.5 core context without window or display, by EGL's surfaceless platform (Mesa; llvmpipe where
// there is no GPU). One thread at a time may use it, after MakeCurrent.
class EglContext {
 public:
  // UNAVAILABLE, with EGL's reason, where there is no such platform or version.
  static absl::StatusOr<std::unique_ptr<EglContext>> Create();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  absl::Status MakeCurrent();
  // Name of the GL renderer, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)".
  const std::string& renderer_name() const { return renderer_name_; }

 private:
  EglContext(void* display, void* context) : display_(display), context_(context) {}

  void* display_;
  void* context_;
  std::string renderer_name_;
};

}  // namespace semmap::town
