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

// The kind named before the colon, if it is known and something follows; else null.
const SourceKind* FindKind(const std::string& spec) {
  const size_t colon = spec.find(':');
  if (colon == std::string::npos || colon + 1 == spec.size()) return nullptr;
  for (const SourceKind& kind : kKinds) {
    if (spec.compare(0, colon, kind.name) == 0) return &kind;
  }
  return nullptr;
}

}  // namespace

bool IsSourceSpec(const std::string& spec) { return FindKind(spec) != nullptr; }

const char* SourceSpecHelp() { return "kitti:DIR|tum:DIR|euroc:DIR|folder:DIR|video:FILE"; }

absl::StatusOr<std::unique_ptr<FrameSource>> OpenSource(const std::string& spec,
                                                        const SourceOptions& options) {
  const SourceKind* kind = FindKind(spec);
  if (kind == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat("source '", spec, "' is not one of ", SourceSpecHelp()));
  }
  return kind->open(spec.substr(spec.find(':') + 1), options);
}

}  // namespace semmap::client
