#include "client/cli/download.h"

#include <filesystem>
#include <fstream>

#include "absl/strings/str_cat.h"
#include "slam/common/sha256.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

// Attempts in a row that bring nothing.
constexpr int kMaxFruitless = 5;

absl::Status NotWritten(const std::string& path) {
  return absl::UnavailableError(absl::StrCat(path, " cannot be written"));
}

absl::Status FetchAll(Client& client, const v1::ExportMapResponse& artifact, std::ofstream& file,
                      Sha256* sha256) {
  int64_t size = 0;
  for (int fruitless = 0;;) {
    const int64_t before = size;
    const absl::Status status =
        client.ReadArtifact(artifact.artifact(), size, [&](const v1::ReadArtifactResponse& response) {
          file.write(response.chunk().data(), static_cast<std::streamsize>(response.chunk().size()));
          sha256->Update(response.chunk());
          size += static_cast<int64_t>(response.chunk().size());
          return file.good();
        });
    if (status.ok() || !file) return status;
    const bool may_go_on = absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status);
    fruitless = size > before ? 0 : fruitless + 1;
    if (!may_go_on || fruitless == kMaxFruitless) return status;
  }
}

absl::Status FetchChecked(Client& client, const v1::ExportMapResponse& artifact, const std::string& path) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  if (!file) return NotWritten(path);
  Sha256 sha256;
  const absl::Status fetched = FetchAll(client, artifact, file, &sha256);
  file.close();
  if (!file) return NotWritten(path);
  SEMMAP_RETURN_IF_ERROR(fetched);
  if (sha256.Finish() == artifact.sha256()) return absl::OkStatus();
  return absl::DataLossError("the file that arrived is not the one that the server wrote");
}

}  // namespace

absl::Status Download(Client& client, const v1::ExportMapResponse& artifact, const std::string& path) {
  const std::string part = path + ".part";
  const absl::Status status = FetchChecked(client, artifact, part);
  std::error_code error;
  if (status.ok()) std::filesystem::rename(part, path, error);
  if (status.ok() && !error) return absl::OkStatus();
  std::error_code ignored;
  std::filesystem::remove(part, ignored);
  return status.ok() ? NotWritten(path) : status;
}

}  // namespace semmap::client
