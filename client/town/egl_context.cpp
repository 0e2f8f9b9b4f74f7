#include "client/town/egl_context.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {

absl::Status Unavailable(const char* what) {
  return absl::UnavailableError(
      absl::StrCat("no off-screen rendering: ", what, ", EGL error 0x", absl::Hex(eglGetError())));
}

EGLDisplay OpenDisplay() {
  if (!epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) return EGL_NO_DISPLAY;
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

}  // namespace

absl::StatusOr<std::unique_ptr<EglContext>> EglContext::Create() {
  const EGLDisplay display = OpenDisplay();
  if (display == EGL_NO_DISPLAY) return Unavailable("the surfaceless platform is missing");
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) return Unavailable("eglInitialize failed");
  if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) return Unavailable("desktop OpenGL is missing");
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               4,
                               EGL_CONTEXT_MINOR_VERSION,
                               5,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_NONE};
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) return Unavailable("no OpenGL 4.5 core context");
  std::unique_ptr<EglContext> result(new EglContext(display, context));
  SEMMAP_RETURN_IF_ERROR(result->MakeCurrent());
  result->renderer_name_ = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return result;
}

EglContext::~EglContext() {
  // The display stays open: other contexts of the process share it.
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

absl::Status EglContext::MakeCurrent() {
  if (eglGetCurrentContext() == context_) return absl::OkStatus();
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
    return Unavailable("eglMakeCurrent failed");
  }
  return absl::OkStatus();
}

}  // namespace semmap::town
