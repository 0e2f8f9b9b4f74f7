#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "client/connection.h"
#include "client/errors.h"
#include "client/frame_keeper.h"
#include "client/grpc_status.h"
#include "client/image.h"
#include "client/names.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"

namespace semmap::client {
namespace {

TEST(Names, TakeIdsAndFullNames) {
  EXPECT_EQ(MapName("town"), "maps/town");
  EXPECT_EQ(MapName("maps/town"), "maps/town");
  EXPECT_EQ(SessionName("7f"), "sessions/7f");
  EXPECT_EQ(IdOfName("maps/town"), "town");
  EXPECT_EQ(IdOfName("town"), "town");
}

TEST(Errors, BringTheReasonOfTheServer) {
  google::rpc::ErrorInfo info;
  info.set_reason("MAP_NOT_FOUND");
  (*info.mutable_metadata())["map"] = "town";
  google::rpc::Status details;
  details.add_details()->PackFrom(info);
  const absl::Status status =
      FromGrpc(grpc::Status(grpc::StatusCode::NOT_FOUND, "no such map", details.SerializeAsString()));
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(status.message(), "no such map");
  EXPECT_EQ(ErrorReason(status), "MAP_NOT_FOUND");
  EXPECT_EQ(ErrorMetadata(status, "map"), "town");
  EXPECT_EQ(ErrorMetadata(status, "field"), "");
}

TEST(Errors, HaveNoReasonWhenTheServerGaveNone) {
  const absl::Status status = FromGrpc(grpc::Status(grpc::StatusCode::UNAVAILABLE, "no link", "no details"));
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(ErrorReason(status), "");
  EXPECT_TRUE(FromGrpc(grpc::Status::OK).ok());
}

TEST(Image, PacksPixelsAsTheyAre) {
  cv::Mat pixels(4, 6, CV_8UC1);
  cv::randu(pixels, 0, 255);
  const cv::Mat part = pixels.colRange(1, 4);
  const auto image = RawImage(part);
  ASSERT_TRUE(image.ok());
  EXPECT_EQ(image->width(), 3);
  EXPECT_EQ(image->data().size(), 12U);
  EXPECT_EQ(static_cast<uchar>(image->data()[4]), part.at<uchar>(1, 1));
  EXPECT_FALSE(RawImage(cv::Mat()).ok());
  EXPECT_FALSE(RawImage(cv::Mat(2, 2, CV_64FC1)).ok());
}

TEST(Image, KnowsFilesByTheirFirstBytes) {
  const cv::Mat pixels(8, 8, CV_8UC1, cv::Scalar(77));
  const auto png = PngImage(pixels);
  const auto jpeg = JpegImage(pixels, 90);
  ASSERT_TRUE(png.ok());
  ASSERT_TRUE(jpeg.ok());
  EXPECT_EQ(FileImage(png->data())->encoding(), v1::IMAGE_ENCODING_PNG);
  EXPECT_EQ(FileImage(jpeg->data())->encoding(), v1::IMAGE_ENCODING_JPEG);
  EXPECT_FALSE(FileImage("GIF89a").ok());
  EXPECT_FALSE(JpegImage(pixels, 0).ok());
  EXPECT_FALSE(PngImage(cv::Mat()).ok());
}

TEST(Connection, RefusesATokenWithoutTls) {
  ConnectOptions options;
  options.address = "127.0.0.1:1";
  options.token = "secret";
  EXPECT_EQ(Connection::Open(options).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Connection, GivesUpInTime) {
  ConnectOptions options;
  options.address = "127.0.0.1:1";
  options.connect_timeout = std::chrono::milliseconds(100);
  EXPECT_EQ(Connection::Open(options).status().code(), absl::StatusCode::kUnavailable);
}

v1::Frame Frame(uint64_t sequence) {
  v1::Frame frame;
  frame.set_sequence(sequence);
  return frame;
}

TEST(FrameKeeper, WritesAgainWhatTheServerDidNotReceive) {
  FrameKeeper keeper(10);
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
    keeper.Add(Frame(sequence));
    EXPECT_EQ(keeper.TakeUnwritten().sequence(), sequence);
  }
  EXPECT_FALSE(keeper.HasUnwritten());
  keeper.Rewind(2);
  EXPECT_EQ(keeper.TakeUnwritten().sequence(), 3U);
  keeper.Rewind(4);
  EXPECT_FALSE(keeper.HasUnwritten());
}

TEST(FrameKeeper, ForgetsWhatIsDurable) {
  FrameKeeper keeper(10);
  for (uint64_t sequence = 1; sequence <= 4; ++sequence) keeper.Add(Frame(sequence));
  keeper.TakeUnwritten();
  keeper.TakeUnwritten();
  keeper.OnAcknowledged(3);
  // Frame 3 was never written, so nobody can have acknowledged it.
  EXPECT_EQ(keeper.size(), 2U);
  EXPECT_EQ(keeper.TakeUnwritten().sequence(), 3U);
}

TEST(FrameKeeper, IsBoundedByGivingUpAnsweredFrames) {
  FrameKeeper keeper(3);
  for (uint64_t sequence = 1; sequence <= 5; ++sequence) {
    keeper.Add(Frame(sequence));
    keeper.TakeUnwritten();
  }
  EXPECT_EQ(keeper.size(), 5U);
  keeper.OnAnswered(1);
  EXPECT_EQ(keeper.size(), 4U);
  keeper.OnAnswered(4);
  EXPECT_EQ(keeper.size(), 3U);
}

}  // namespace
}  // namespace semmap::client
