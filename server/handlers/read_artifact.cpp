#include <fstream>
#include <memory>
#include <string>

#include "server/artifacts.h"
#include "server/error_reasons.h"
#include "server/handlers/map_handlers.h"
#include "server/names.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

constexpr size_t kPiece = 256 << 10;

// The open file stays readable when the artifact is deleted meanwhile.
class FileSource : public ChunkSource<v1::ReadArtifactResponse> {
 public:
  FileSource(const std::string& path, int64_t offset) : file_(path, std::ios::binary) { file_.seekg(offset); }

  absl::StatusOr<bool> Next(v1::ReadArtifactResponse* response) override {
    std::string& chunk = *response->mutable_chunk();
    chunk.resize(kPiece);
    file_.read(chunk.data(), static_cast<std::streamsize>(kPiece));
    chunk.resize(static_cast<size_t>(file_.gcount()));
    if (!chunk.empty()) return true;
    if (file_.eof() && !file_.bad()) return false;
    return Error(v1::ERROR_REASON_STORE_UNAVAILABLE, "the file cannot be read");
  }

 private:
  std::ifstream file_;
};

}  // namespace

absl::StatusOr<std::unique_ptr<ChunkSource<v1::ReadArtifactResponse>>> ReadArtifact(
    const ServiceContext& context, const v1::ReadArtifactRequest& request) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseArtifactName("name", request.name()));
  SEMMAP_ASSIGN_OR_RETURN(const Artifact artifact, context.artifacts->Find(id));
  if (request.offset() < 0 || request.offset() > artifact.size_bytes) {
    return Error(v1::ERROR_REASON_FIELD_INVALID, "the offset is not in the file", {{"field", "offset"}});
  }
  return std::make_unique<FileSource>(artifact.path, request.offset());
}

}  // namespace semmap::server
