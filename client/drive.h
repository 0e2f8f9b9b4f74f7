#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/connection.h"
#include "semmap/v1/frame.pb.h"
#include "semmap/v1/session.pb.h"

namespace semmap::client {

struct DriveOptions {
  std::string vehicle_id;
  v1::SessionMode mode = v1::SESSION_MODE_MAP;
  std::string map;  // id or full name
  v1::CameraRig rig;
  v1::OverloadPolicy overload_policy = v1::OVERLOAD_POLICY_BLOCK;
  std::string user_agent;
  // How long Send may wait for credit and Finish for the summary.
  std::chrono::milliseconds send_timeout{60'000};
  std::chrono::milliseconds finish_timeout{300'000};
  // Whether a broken stream is taken up again (until the server's resume timeout is over).
  bool resume = true;
  // Frames kept for sending again; those that were answered are given up first when there are more.
  size_t max_kept_frames = 256;
};

// What the server tells while the vehicle drives. Called one at a time, in the order of the stream, from a
// thread of the library: must not block and must not call the Drive. Any may be empty.
struct DriveObserver {
  std::function<void(const v1::FrameEstimate&)> on_estimate;
  std::function<void(const v1::FramesDropped&)> on_dropped;
  std::function<void(const v1::Acknowledgement&)> on_acknowledgement;
  std::function<void(const v1::MapCorrection&)> on_correction;
  // The stream broke and was taken up again.
  std::function<void(const v1::SessionStarted&)> on_resumed;
};

// One vehicle's drive through one session. Send and Finish are called from one thread at a time. Destroying a
// drive that was not finished cuts its stream; the server then keeps the session for its resume timeout.
class Drive {
 public:
  // Opens the stream and waits for the server's SessionStarted (ConnectOptions::call_timeout).
  static absl::StatusOr<std::unique_ptr<Drive>> Start(std::shared_ptr<Connection> connection,
                                                      DriveOptions options, DriveObserver observer);
  virtual ~Drive() = default;

  // The server's answer to the hello (session, map, limits).
  virtual const v1::SessionStarted& started() const = 0;

  // Waits for credit, then hands the frame over. Not OK: the drive is over; the status is the server's, or
  // DEADLINE_EXCEEDED after send_timeout.
  virtual absl::Status Send(v1::Frame frame) = 0;
  // True when Send would not wait: a live vehicle that must not wait can leave the frame out.
  virtual bool HasCredit() const = 0;
  // Waits until every frame sent was answered (or dropped), at most `timeout`.
  virtual absl::Status WaitForAnswers(std::chrono::milliseconds timeout) = 0;
  // Says that there is nothing more and waits until everything is processed and stored. All observer calls
  // have been made when it returns.
  virtual absl::StatusOr<v1::SessionSummary> Finish() = 0;

  // For tests and demonstrations: breaks the stream as a lost radio link would.
  virtual void CutStream() = 0;
};

}  // namespace semmap::client
