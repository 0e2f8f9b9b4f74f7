#include <filesystem>
#include <fstream>

#include "client/cli/download.h"
#include "client/client.h"
#include "client/errors.h"
#include "service_fixture.h"

// Exports over the wire.
namespace semmap {
namespace {

class ExportServiceTest : public ServiceTest {
 protected:
  void SetUp() override {
    ServiceTest::SetUp();
    auto drive = client::Drive::Start(Connect(), DriveTo("town"), {});
    ASSERT_TRUE(drive.ok()) << drive.status();
    for (uint64_t sequence = 1; sequence <= 50; ++sequence) ASSERT_TRUE((*drive)->Send(Frame(sequence)).ok());
    ASSERT_TRUE((*drive)->Finish().ok());
  }

  static v1::ExportMapRequest CsvRequest() {
    v1::ExportMapRequest request;
    request.set_name("town");
    request.set_format(v1::MAP_FILE_FORMAT_CSV);
    return request;
  }
};

TEST_F(ExportServiceTest, TheFileArrivesWhole) {
  client::Client client(Connect());
  const auto exported = client.ExportMap(CsvRequest(), nullptr);
  ASSERT_TRUE(exported.ok()) << exported.status();
  const std::string path = directory_.path() + "/town.csv";
  const absl::Status downloaded = client::Download(client, exported->file, path);
  ASSERT_TRUE(downloaded.ok()) << downloaded;
  EXPECT_EQ(static_cast<int64_t>(std::filesystem::file_size(path)), exported->file.size_bytes());
  std::ifstream file(path);
  int lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  EXPECT_EQ(lines, 11);
  EXPECT_TRUE(client.DeleteOperation(exported->operation).ok());
  EXPECT_EQ(client::ErrorReason(
                client.ReadArtifact(exported->file.artifact(), 0, [](const auto&) { return true; })),
            "ARTIFACT_NOT_FOUND");
}

TEST_F(ExportServiceTest, AFileWithAnotherChecksumIsNotKept) {
  client::Client client(Connect());
  auto exported = client.ExportMap(CsvRequest(), nullptr);
  ASSERT_TRUE(exported.ok()) << exported.status();
  exported->file.mutable_sha256()->at(0) ^= 1;
  const std::string path = directory_.path() + "/town.csv";
  EXPECT_TRUE(absl::IsDataLoss(client::Download(client, exported->file, path)));
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
}

class ImportServiceTest : public ExportServiceTest {
 protected:
  // The town as a file.
  std::string FileOfTown(client::Client& client) {
    v1::ExportMapRequest request;
    request.set_name("town");
    request.set_format(v1::MAP_FILE_FORMAT_SEMMAP);
    const auto exported = client.ExportMap(request, nullptr);
    EXPECT_TRUE(exported.ok()) << exported.status();
    const std::string path = directory_.path() + "/town.semmap";
    const absl::Status downloaded = client::Download(client, exported->file, path);
    EXPECT_TRUE(downloaded.ok()) << downloaded;
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  static absl::StatusOr<v1::Map> Import(client::Client& client, const std::string& name, std::string bytes) {
    size_t at = 0;
    return client.ImportMap(
        name, "",
        [&](std::span<char> room) -> absl::StatusOr<size_t> {
          const size_t size = bytes.copy(room.data(), room.size(), at);
          at += size;
          return size;
        },
        nullptr);
  }
};

TEST_F(ImportServiceTest, ThereAndBackIsTheSameMap) {
  client::Client client(Connect());
  const std::string bytes = FileOfTown(client);
  const auto imported = Import(client, "village", bytes);
  ASSERT_TRUE(imported.ok()) << imported.status();
  EXPECT_EQ(imported->keyframe_count(), client.GetMap("town")->keyframe_count());
  EXPECT_EQ(StoredFrames("village"), StoredFrames("town"));
  EXPECT_EQ(client.CheckMap("village", nullptr)->problems_size(), 0);
}

TEST_F(ImportServiceTest, RefusalsCarryTheirReasons) {
  client::Client client(Connect());
  const std::string bytes = FileOfTown(client);
  EXPECT_EQ(client::ErrorReason(Import(client, "town", bytes).status()), "MAP_EXISTS");
  EXPECT_EQ(client::ErrorReason(Import(client, "village", bytes.substr(0, 20'000)).status()), "FILE_INVALID");
  EXPECT_EQ(client::ErrorReason(Import(client, "village", "").status()), "FILE_INVALID");
  EXPECT_EQ(client::ErrorReason(client.GetMap("village").status()), "MAP_NOT_FOUND");
  // The caller's own trouble.
  const auto broken = client.ImportMap(
      "village", "", [](std::span<char>) -> absl::StatusOr<size_t> { return absl::DataLossError("disk"); },
      nullptr);
  EXPECT_EQ(broken.status().message(), "disk");
}

}  // namespace
}  // namespace semmap
