#include "client/sources/open_source.h"

#include <array>

#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

using OpenFunction = absl::StatusOr<std::unique_ptr<FrameSource>> (*)(const std::string&,
                                                                      const SourceOptions&);

struct SourceKind {
  const char* name;
  OpenFunction open;
};

constexpr std::array<SourceKind, 5> kKinds = {{
    {"kitti", OpenKittiSource},
    {"tum", OpenTumSource},
    {"euroc", OpenEurocSource},
    {"folder", OpenFolderSource},
    {"video", OpenVideoSource},
}};

}  // namespace

const char* SourceSpecHelp() { return "kitti:DIR|tum:DIR|euroc:DIR|folder:DIR|video:FILE"; }

absl::StatusOr<std::unique_ptr<FrameSource>> OpenSource(const std::string& spec,
                                                        const SourceOptions& options) {
  const size_t colon = spec.find(':');
  const std::string path = colon == std::string::npos ? "" : spec.substr(colon + 1);
  for (const SourceKind& kind : kKinds) {
    if (colon != std::string::npos && !path.empty() && spec.substr(0, colon) == kind.name) {
      return kind.open(path, options);
    }
  }
  return absl::InvalidArgumentError(absl::StrCat("source '", spec, "' is not one of ", SourceSpecHelp()));
}

}  // namespace semmap::client
