#include <functional>

#include <opencv2/imgcodecs.hpp>

#include "raw_stream.h"
#include "service_fixture.h"

namespace semmap {
namespace {

v1::Image FileImage(const char* extension, v1::ImageEncoding encoding, cv::Size size = {64, 48}) {
  cv::Mat pixels(size, CV_8UC1);
  cv::RNG(1).fill(pixels, cv::RNG::UNIFORM, 0, 255);
  std::vector<uchar> bytes;
  cv::imencode(extension, pixels, bytes);
  v1::Image image;
  image.set_encoding(encoding);
  image.set_data(bytes.data(), bytes.size());
  return image;
}
v1::Image Jpeg(cv::Size size = {64, 48}) { return FileImage(".jpg", v1::IMAGE_ENCODING_JPEG, size); }
v1::Image Png() { return FileImage(".png", v1::IMAGE_ENCODING_PNG); }

v1::Image HalfOf(v1::Image image) {
  image.mutable_data()->resize(image.data().size() / 2);
  return image;
}
v1::Image DamagedIn(v1::Image image, size_t bytes) {
  const size_t middle = image.data().size() / 2;
  image.mutable_data()->replace(middle, bytes, bytes, '\xff');
  return image;
}

struct BadFrame {
  const char* name;
  const char* reason;
  // Makes a good fourth frame of a mono drive a bad one.
  std::function<void(v1::Frame*)> spoil;
};

std::ostream& operator<<(std::ostream& out, const BadFrame& bad) { return out << bad.name; }

class BadFrameTest : public ServiceTest, public testing::WithParamInterface<BadFrame> {};

// Three good frames, a bad one, another good one: the stream ends with the status and reason of the fourth,
// the three are answered and stored, and the server goes on.
TEST_P(BadFrameTest, EndsTheStreamAndNothingElse) {
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(Rig(), "town"));
  for (uint64_t sequence = 1; sequence <= 3; ++sequence) stream.WriteFrame(Frame(sequence));
  v1::Frame bad = Frame(4);
  GetParam().spoil(&bad);
  stream.WriteFrame(bad);
  int answers = 0;
  v1::StreamFramesResponse response;
  while (stream.Read(&response)) answers += response.has_estimate() ? 1 : 0;
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(client::ErrorReason(status), GetParam().reason) << status;
  EXPECT_EQ(answers, 3);
  EXPECT_EQ(StoredFrames("town"), UpTo(3));

  auto drive = client::Drive::Start(Connect(), DriveTo("next"), {});
  ASSERT_TRUE(drive.ok()) << drive.status();
  ASSERT_TRUE((*drive)->Send(Frame(1)).ok());
  EXPECT_TRUE((*drive)->Finish().ok());
}

INSTANTIATE_TEST_SUITE_P(
    All, BadFrameTest,
    testing::Values(
        BadFrame{"TruncatedJpeg", "IMAGE_CORRUPT",
                 [](auto* frame) { *frame->mutable_image() = HalfOf(Jpeg()); }},
        BadFrame{"CorruptJpeg", "IMAGE_CORRUPT",
                 [](auto* frame) { *frame->mutable_image() = DamagedIn(Jpeg(), 40); }},
        BadFrame{"TruncatedPng", "IMAGE_CORRUPT",
                 [](auto* frame) { *frame->mutable_image() = HalfOf(Png()); }},
        BadFrame{"CorruptPng", "IMAGE_CORRUPT",
                 [](auto* frame) { *frame->mutable_image() = DamagedIn(Png(), 1); }},
        BadFrame{"EmptyImage", "IMAGE_CORRUPT",
                 [](auto* frame) {
                   frame->mutable_image()->set_encoding(v1::IMAGE_ENCODING_PNG),
                       frame->mutable_image()->clear_data();
                 }},
        BadFrame{"WrongSizeJpeg", "IMAGE_SIZE_MISMATCH",
                 [](auto* frame) {
                   *frame->mutable_image() = Jpeg({80, 48});
                 }},
        BadFrame{"WrongSizeRaw", "IMAGE_SIZE_MISMATCH",
                 [](auto* frame) { frame->mutable_image()->set_width(63); }},
        BadFrame{"ShortRaw", "IMAGE_CORRUPT",
                 [](auto* frame) { frame->mutable_image()->mutable_data()->pop_back(); }},
        BadFrame{"NoEncoding", "IMAGE_ENCODING_UNSUPPORTED",
                 [](auto* frame) { frame->mutable_image()->clear_encoding(); }},
        BadFrame{"NoImage", "IMAGE_MISSING", [](auto* frame) { frame->clear_image(); }},
        BadFrame{"StrayRightImage", "IMAGE_UNEXPECTED",
                 [](auto* frame) { *frame->mutable_right() = frame->image(); }},
        BadFrame{"StrayDepth", "IMAGE_UNEXPECTED",
                 [](auto* frame) { *frame->mutable_depth() = frame->image(); }},
        BadFrame{"TimeBackwards", "TIME_NOT_INCREASING", [](auto* frame) { frame->set_timestamp_ns(299); }},
        BadFrame{"TimeStands", "TIME_NOT_INCREASING", [](auto* frame) { frame->set_timestamp_ns(300); }},
        BadFrame{"SequenceBackwards", "SEQUENCE_NOT_INCREASING", [](auto* frame) { frame->set_sequence(2); }},
        BadFrame{"SequenceZero", "SEQUENCE_NOT_INCREASING", [](auto* frame) { frame->set_sequence(0); }}),
    [](const auto& test) { return std::string(test.param.name); });

using BadStreamTest = ServiceTest;

TEST_F(BadStreamTest, ARigThatContradictsItsImages) {
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(Rig(v1::SENSOR_TYPE_STEREO), "town"));
  stream.WriteFrame(Frame(1));
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(client::ErrorReason(status), "IMAGE_MISSING");
  EXPECT_EQ(client::ErrorMetadata(status, "field"), "right");
  EXPECT_EQ(client::ErrorMetadata(status, "sequence"), "1");
}

TEST_F(BadStreamTest, ACalibrationThatIsNotANumber) {
  v1::CameraRig rig = Rig();
  rig.mutable_camera()->set_cy(std::numeric_limits<double>::quiet_NaN());
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(rig, "town"));
  const absl::Status status = stream.Finish();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(client::ErrorReason(status), "RIG_INVALID");
  EXPECT_EQ(client::Client(Connect()).ListMaps()->size(), 0U);
}

TEST_F(BadStreamTest, MessagesOutOfOrder) {
  {
    RawStream stream(Connect()->channel());
    stream.WriteFrame(Frame(1));
    EXPECT_EQ(client::ErrorReason(stream.Finish()), "MESSAGE_UNEXPECTED");
  }
  {
    RawStream stream(Connect()->channel());
    stream.WriteHello(Rig(), "town");
    stream.WriteHello(Rig(), "town");
    EXPECT_EQ(client::ErrorReason(stream.Finish()), "MESSAGE_UNEXPECTED");
  }
  {
    RawStream stream(Connect()->channel());
    stream.Write(v1::StreamFramesRequest());
    EXPECT_EQ(client::ErrorReason(stream.Finish()), "MESSAGE_UNEXPECTED");
  }
  {
    RawStream stream(Connect()->channel());
    stream.CloseWriting();
    EXPECT_EQ(client::ErrorReason(stream.Finish()), "MESSAGE_UNEXPECTED");
  }
}

TEST_F(BadStreamTest, AMessageThatIsTooLarge) {
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(Rig(), "town"));
  v1::Frame frame = Frame(1);
  frame.mutable_image()->mutable_data()->resize(33 << 20);
  stream.WriteFrame(frame);
  EXPECT_EQ(stream.Finish().code(), absl::StatusCode::kResourceExhausted);
}

class HelloTimeoutTest : public ServiceTest {
 protected:
  HelloTimeoutTest() { config_.server.hello_timeout_s = 0.1; }
};

TEST_F(HelloTimeoutTest, ASilentStreamIsEnded) {
  RawStream stream(Connect()->channel());
  EXPECT_EQ(client::ErrorReason(stream.Finish()), "MESSAGE_UNEXPECTED");
}

TEST_F(HelloTimeoutTest, AStreamThatSaidHelloMayBeSilent) {
  RawStream stream(Connect()->channel());
  ASSERT_TRUE(stream.WriteHello(Rig(), "town"));
  v1::StreamFramesResponse response;
  ASSERT_TRUE(stream.Read(&response));
  absl::SleepFor(absl::Milliseconds(300));
  stream.WriteFrame(Frame(1));
  // The acknowledgement may be faster than the pose.
  do {
    ASSERT_TRUE(stream.Read(&response));
  } while (!response.has_estimate());
  EXPECT_EQ(response.estimate().sequence(), 1U);
}

}  // namespace
}  // namespace semmap
