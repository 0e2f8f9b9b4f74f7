#include <filesystem>
#include <fstream>

#include "operation_fixture.h"
#include "server/handlers/map_handlers.h"
#include "server/map_upload.h"

namespace semmap::server {
namespace {

class ImportMapTest : public OperationTest {
 protected:
  ImportMapTest() {
    MakeMap("town", "s1", 50);
    header_.set_name("maps/again");
    header_.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
  }

  std::string ExportedFile() {
    v1::ExportMapRequest request;
    request.set_name("maps/town");
    request.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
    v1::ExportMapResponse exported;
    EXPECT_TRUE(Finished(ExportMap(context_, request)).response().UnpackTo(&exported));
    sha256_ = exported.sha256();
    std::ifstream file(directory_.path() + "/" + exported.artifact() + ".artifact", std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  absl::StatusOr<v1::Operation> Upload(const std::string& bytes) {
    auto upload = MapUpload::Begin(context_, header_);
    if (!upload.ok()) return upload.status();
    constexpr size_t kPiece = 10'000;
    for (size_t i = 0; i < bytes.size(); i += kPiece) {
      const absl::Status status = (*upload)->Append(std::string_view(bytes).substr(i, kPiece));
      if (!status.ok()) return status;
    }
    return (*upload)->Finish();
  }

  v1::ErrorReason Refusal() { return ReasonOf(MapUpload::Begin(context_, header_).status()); }

  // The exported file of the original is one.
  size_t FilesLeft() const {
    size_t files = 0;
    for ([[maybe_unused]] const auto& file :
         std::filesystem::directory_iterator(directory_.path() + "/artifacts")) {
      ++files;
    }
    return files;
  }

  v1::ImportMapHeader header_;
  std::string sha256_;
};

TEST_F(ImportMapTest, AnExportedMapComesBack) {
  const std::string bytes = ExportedFile();
  header_.set_sha256(sha256_);
  header_.set_request_id("once");
  const auto started = Upload(bytes);
  v1::Map map;
  ASSERT_TRUE(Finished(started).response().UnpackTo(&map));
  EXPECT_EQ(map.name(), "maps/again");
  EXPECT_EQ(map.keyframe_count(), 10);
  EXPECT_EQ(map.point_count(), 10);
  EXPECT_EQ(FilesLeft(), 1U) << "the uploaded file is still there";
  // Sent again, the request answers the same operation.
  EXPECT_EQ(Upload(bytes)->name(), started->name());
  header_.set_request_id("twice");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_EXISTS);
}

TEST_F(ImportMapTest, AnotherChecksum) {
  const std::string bytes = ExportedFile();
  header_.set_sha256(std::string(32, 'x'));
  EXPECT_EQ(ReasonOf(Upload(bytes).status()), v1::ERROR_REASON_CHECKSUM_MISMATCH);
  EXPECT_EQ(FilesLeft(), 1U);
}

TEST_F(ImportMapTest, AFileCutShortLeavesNothing) {
  const std::string bytes = ExportedFile();
  const v1::Operation operation = Finished(Upload(bytes.substr(0, bytes.size() / 2)));
  EXPECT_EQ(operation.error().code(), static_cast<int>(absl::StatusCode::kInvalidArgument));
  EXPECT_EQ(operation.error().details_size(), 1);
  EXPECT_EQ(FilesLeft(), 1U);
  EXPECT_TRUE(absl::IsNotFound(store_->GetMap("again").status()));
}

TEST_F(ImportMapTest, MoreThanThereIsRoomFor) {
  EXPECT_EQ(ReasonOf(Upload(std::string(2 << 20, 'x')).status()), v1::ERROR_REASON_FILES_TOO_LARGE);
  EXPECT_EQ(FilesLeft(), 0U);
}

TEST_F(ImportMapTest, BadHeadersAndChunks) {
  auto upload = MapUpload::Begin(context_, header_);
  ASSERT_TRUE(upload.ok()) << upload.status();
  EXPECT_EQ(ReasonOf((*upload)->Append(std::string((1 << 20) + 1, 'x'))), v1::ERROR_REASON_FIELD_INVALID);
  header_.set_sha256("short");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  header_.clear_sha256();
  header_.set_format(v1::MAP_FILE_FORMAT_PLY);
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_FIELD_INVALID);
  header_.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
  header_.set_name("again");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_NAME_INVALID);
  header_.set_name("maps/town");
  EXPECT_EQ(Refusal(), v1::ERROR_REASON_MAP_EXISTS);
}

TEST_F(ImportMapTest, AWholeMapIsNotFiltered) {
  v1::ExportMapRequest request;
  request.set_name("maps/town");
  request.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
  request.mutable_filter()->set_active_only(true);
  EXPECT_EQ(ReasonOf(ExportMap(context_, request).status()), v1::ERROR_REASON_FIELD_INVALID);
}

}  // namespace
}  // namespace semmap::server
