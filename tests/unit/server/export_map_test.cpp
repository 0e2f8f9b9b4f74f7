#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "operation_fixture.h"
#include "server/handlers/map_handlers.h"

namespace semmap::server {
namespace {

// Points lie at x = 1, 6, 11 ...; z = 10; ids 1, 2, 3 ...; odd ones are of class 10, even ones of class 1.
class ExportMapTest : public OperationTest {
 protected:
  ExportMapTest() {
    MakeMap("town", "s1", 50);
    request_.set_name("maps/town");
  }

  v1::ExportMapResponse Export(v1::MapFileFormat format) {
    request_.set_format(format);
    operation_ = Finished(ExportMap(context_, request_));
    v1::ExportMapResponse response;
    EXPECT_TRUE(operation_.response().UnpackTo(&response)) << operation_.error().message();
    return response;
  }
  std::string Read(const std::string& artifact, int64_t offset = 0) {
    v1::ReadArtifactRequest request;
    request.set_name(artifact);
    request.set_offset(offset);
    auto source = ReadArtifact(context_, request);
    EXPECT_TRUE(source.ok()) << source.status();
    std::string bytes;
    v1::ReadArtifactResponse response;
    while (source.ok() && (*source)->Next(&response).value_or(false)) bytes += response.chunk();
    return bytes;
  }
  v1::ErrorReason ReadRefusal(const std::string& artifact, int64_t offset) {
    v1::ReadArtifactRequest request;
    request.set_name(artifact);
    request.set_offset(offset);
    return ReasonOf(ReadArtifact(context_, request).status());
  }

  v1::ExportMapRequest request_;
  v1::Operation operation_;
};

template <typename T>
T ValueAt(const std::string& bytes, size_t offset) {
  T value;
  EXPECT_LE(offset + sizeof value, bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST_F(ExportMapTest, Ply) {
  const v1::ExportMapResponse file = Export(v1::MAP_FILE_FORMAT_PLY);
  const std::string bytes = Read(file.artifact());
  EXPECT_EQ(static_cast<int64_t>(bytes.size()), file.size_bytes());
  EXPECT_EQ(file.sha256().size(), 32U);
  EXPECT_TRUE(bytes.starts_with("ply\nformat binary_little_endian 1.0\ncomment "));
  EXPECT_NE(bytes.find("\nelement vertex 10\n"), std::string::npos);
  const size_t body = bytes.find("end_header\n") + 11;
  constexpr size_t kRow = 3 * 4 + 4 + 4 + 4;
  ASSERT_EQ(bytes.size(), body + 10 * kRow);
  const size_t second = body + kRow;
  EXPECT_EQ(ValueAt<float>(bytes, second), 6);
  EXPECT_EQ(ValueAt<float>(bytes, second + 8), 10);
  // A building is grey, a vehicle blue.
  EXPECT_EQ(bytes.substr(second + 12, 4), (std::string{70, 70, 70, 1}));
  EXPECT_EQ(bytes.substr(body + 12, 4), (std::string{0, 0, static_cast<char>(142), 10}));
  EXPECT_EQ(ValueAt<float>(bytes, second + 16), 1);
  EXPECT_EQ(ValueAt<uint32_t>(bytes, second + 20), 1U);
}

TEST_F(ExportMapTest, Pcd) {
  const std::string bytes = Read(Export(v1::MAP_FILE_FORMAT_PCD).artifact());
  EXPECT_NE(bytes.find("\nWIDTH 10\nHEIGHT 1\n"), std::string::npos);
  EXPECT_NE(bytes.find("\nPOINTS 10\n"), std::string::npos);
  const size_t body = bytes.find("DATA binary\n") + 12;
  ASSERT_EQ(bytes.size(), body + 10 * 28);
  EXPECT_EQ(ValueAt<float>(bytes, body), 1);
  EXPECT_EQ(ValueAt<uint32_t>(bytes, body + 12), 142U);
  EXPECT_EQ(ValueAt<uint32_t>(bytes, body + 16), 10U);
}

TEST_F(ExportMapTest, CsvOfTheFilteredPoints) {
  request_.mutable_filter()->add_semantic_classes(1);
  request_.mutable_filter()->mutable_area()->mutable_sphere()->mutable_center()->set_x(16);
  request_.mutable_filter()->mutable_area()->mutable_sphere()->set_radius_m(11);
  std::istringstream lines(Read(Export(v1::MAP_FILE_FORMAT_CSV).artifact()));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "id,x,y,z,class,class_name,red,green,blue,confidence,observations,first_seen_ns,last_seen_ns");
  std::getline(lines, line);
  EXPECT_EQ(line, "4,16,0,10,1,Building,70,70,70,1,1,1600,1600");
  EXPECT_FALSE(std::getline(lines, line)) << line;
}

// The heading keeps its length, whatever the number in it.
TEST_F(ExportMapTest, AnEmptySelectionIsAFileWithoutPoints) {
  request_.mutable_filter()->set_min_observations(100);
  const std::string ply = Read(Export(v1::MAP_FILE_FORMAT_PLY).artifact());
  EXPECT_NE(ply.find("\nelement vertex 0\n"), std::string::npos);
  EXPECT_TRUE(ply.ends_with("end_header\n"));
  const std::string csv = Read(Export(v1::MAP_FILE_FORMAT_CSV).artifact());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1);
}

TEST_F(ExportMapTest, GeoJson) {
  request_.set_format(v1::MAP_FILE_FORMAT_GEOJSON);
  EXPECT_EQ(ReasonOf(ExportMap(context_, request_).status()), v1::ERROR_REASON_MAP_NOT_ANCHORED);
  ASSERT_TRUE(store_->SetAnchor(store_->GetMap("town")->id, storage::GeoAnchor{48, 11, 500, {}}).ok());
  request_.mutable_filter()->add_semantic_classes(1);
  const std::string text = Read(Export(v1::MAP_FILE_FORMAT_GEOJSON).artifact());
  EXPECT_TRUE(text.starts_with("{\"type\":\"FeatureCollection\",\"features\":[\n{"));
  EXPECT_TRUE(text.ends_with("}\n]}\n"));
  const auto count = [&](const std::string& what) {
    int found = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("\"type\":\"Point\""), 5);
  EXPECT_EQ(count("\"class_name\":\"Building\""), 5);
  EXPECT_EQ(count("\"type\":\"LineString\""), 1);
  EXPECT_EQ(count("\"session\":\"sessions/s1\",\"vehicle_id\":\"car\""), 1);
  EXPECT_EQ(count("{"), count("}"));
  EXPECT_EQ(count("["), count("]"));
}

TEST_F(ExportMapTest, GeoJsonOfNothing) {
  ASSERT_TRUE(store_->CreateMap({"empty", 1, SmallRig(), true}).ok());
  ASSERT_TRUE(store_->SetAnchor(store_->GetMap("empty")->id, storage::GeoAnchor{48, 11, 500, {}}).ok());
  request_.set_name("maps/empty");
  EXPECT_EQ(Read(Export(v1::MAP_FILE_FORMAT_GEOJSON).artifact()),
            "{\"type\":\"FeatureCollection\",\"features\":[]}\n");
}

TEST_F(ExportMapTest, ADownloadIsTakenUpWhereItBroke) {
  const v1::ExportMapResponse file = Export(v1::MAP_FILE_FORMAT_PLY);
  const std::string whole = Read(file.artifact());
  EXPECT_EQ(Read(file.artifact(), 100), whole.substr(100));
  EXPECT_EQ(Read(file.artifact(), file.size_bytes()), "");
  EXPECT_EQ(ReadRefusal(file.artifact(), file.size_bytes() + 1), v1::ERROR_REASON_FIELD_INVALID);
  EXPECT_EQ(ReadRefusal(file.artifact(), -1), v1::ERROR_REASON_FIELD_INVALID);
  EXPECT_EQ(ReadRefusal("artifacts/0", 0), v1::ERROR_REASON_ARTIFACT_NOT_FOUND);
  EXPECT_EQ(ReadRefusal("0", 0), v1::ERROR_REASON_NAME_INVALID);
}

TEST_F(ExportMapTest, TheFileGoesWithItsOperation) {
  const v1::ExportMapResponse file = Export(v1::MAP_FILE_FORMAT_CSV);
  v1::DeleteOperationRequest request;
  request.set_name(operation_.name());
  ASSERT_TRUE(DeleteOperation(context_, request).ok());
  EXPECT_EQ(ReadRefusal(file.artifact(), 0), v1::ERROR_REASON_ARTIFACT_NOT_FOUND);
}

TEST_F(ExportMapTest, Refusals) {
  EXPECT_EQ(ReasonOf(ExportMap(context_, request_).status()), v1::ERROR_REASON_FIELD_INVALID);
  request_.set_format(v1::MAP_FILE_FORMAT_PLY);
  request_.mutable_filter()->set_min_observations(-1);
  EXPECT_EQ(ReasonOf(ExportMap(context_, request_).status()), v1::ERROR_REASON_FIELD_INVALID);
  request_.clear_filter();
  request_.set_name("maps/nowhere");
  EXPECT_EQ(ReasonOf(ExportMap(context_, request_).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

TEST_F(ExportMapTest, AMapTooLargeForTheSpaceThatIsLeftLeavesNothing) {
  const auto other = artifacts_.Begin();
  ASSERT_TRUE(other.ok()) << other.status();
  ASSERT_TRUE((*other)->GrowTo((1 << 20) - 100).ok());
  request_.set_format(v1::MAP_FILE_FORMAT_CSV);
  const v1::Operation operation = Finished(ExportMap(context_, request_));
  EXPECT_EQ(operation.error().code(), static_cast<int>(absl::StatusCode::kResourceExhausted));
  EXPECT_TRUE(std::filesystem::is_empty(directory_.path() + "/artifacts"));
}

}  // namespace
}  // namespace semmap::server
