#include "aftermath.h"

#include <algorithm>
#include <set>

#include <grpcpp/grpcpp.h>

#include "absl/strings/str_cat.h"
#include "client/errors.h"
#include "connect.h"
#include "tests/integration/raw_stream.h"

namespace semmap::kill_test {
namespace {

// Between a relocalized position and that of the stored trajectory, in the unit of the map.
constexpr double kNear = 0.3;

// `count` of them, spread evenly, the last one among them.
std::vector<uint64_t> Spread(const std::vector<uint64_t>& sequences, size_t count) {
  std::vector<uint64_t> chosen;
  for (size_t i = 1; i <= count && !sequences.empty(); ++i) {
    const uint64_t sequence = sequences[std::max<size_t>(i * sequences.size() / count, 1) - 1];
    if (chosen.empty() || chosen.back() != sequence) chosen.push_back(sequence);
  }
  return chosen;
}

}  // namespace

void Tally::Add(const Tally& other) {
  kills += other.kills;
  inside += other.inside;
  maps += other.maps;
  empty += other.empty;
  frames += other.frames;
  keyframes += other.keyframes;
  culled += other.culled;
  asked += other.asked;
  found += other.found;
  ended += other.ended;
  failures.insert(failures.end(), other.failures.begin(), other.failures.end());
}

Aftermath::Aftermath(const std::string& address, Tally* tally)
    : connection_(Connect(address).value()), client_(connection_), tally_(tally) {}

bool Aftermath::InspectMap(const std::string& map) {
  const auto info = client_.GetMap(map);
  if (!info.ok()) {
    if (client::ErrorReason(info.status()) != "MAP_NOT_FOUND")
      Fail(absl::StrCat(map, " does not open: ", info.status().ToString()));
    return false;
  }
  const auto check = client_.CheckMap(map, nullptr);
  if (!check.ok()) {
    Fail(absl::StrCat(map, " cannot be checked: ", check.status().ToString()));
    return true;
  }
  for (const v1::MapProblem& problem : check->problems())
    Fail(absl::StrCat(map, ": ", problem.check(), " x ", problem.count(), ": ", problem.detail()));
  if (check->problems().empty()) ++tally_->maps;
  if (info->keyframe_count() == 0) ++tally_->empty;
  return true;
}

Aftermath::Trajectory Aftermath::ReadTrajectory(const std::string& map, const std::string& session) {
  Trajectory trajectory;
  v1::GetTrajectoryRequest request;
  request.set_map(map);
  request.set_session(session);
  const absl::Status status = client_.GetTrajectory(request, [&](const v1::GetTrajectoryResponse& response) {
    const v1::TrajectoryColumns& columns = response.trajectory();
    for (int i = 0; i < columns.sequences_size(); ++i) {
      const double* pose = columns.poses().data() + 7 * i;
      trajectory[columns.sequences(i)] = {pose[0], pose[1], pose[2]};
    }
    return true;
  });
  if (!status.ok()) Fail(absl::StrCat(map, " has no trajectory: ", status.ToString()));
  return trajectory;
}

void Aftermath::InspectContents(const Testimony& told, const std::string& map, int pictures) {
  // The sessions of copies have other names.
  const std::string session = map == told.map ? told.session : "";
  const Trajectory trajectory = ReadTrajectory(map, session);
  const std::vector<uint64_t> frames = told.Durable(told.tracked);
  for (const uint64_t sequence : frames) {
    if (trajectory.contains(sequence)) {
      ++tally_->frames;
    } else {
      Fail(absl::StrCat(map, ": frame ", sequence, " is gone, ", told.acknowledged, " was acknowledged"));
    }
  }
  std::set<uint64_t> kept;
  v1::QueryKeyFramesRequest request;
  request.set_map(map);
  request.set_session(session);
  const absl::Status status = client_.QueryKeyFrames(request, [&](const v1::KeyFrame& keyframe) {
    kept.insert(keyframe.sequence());
    return true;
  });
  if (!status.ok()) Fail(absl::StrCat(map, " has no keyframes: ", status.ToString()));
  for (const uint64_t sequence : told.Durable(told.keyframes)) {
    const bool culled = !kept.contains(sequence) && trajectory.contains(sequence);
    if (culled || kept.contains(sequence)) {
      ++tally_->keyframes;
      tally_->culled += culled ? 1 : 0;
    } else {
      Fail(absl::StrCat(map, ": keyframe ", sequence, " is gone, ", told.acknowledged, " was acknowledged"));
    }
  }
  for (const uint64_t sequence : Spread(frames, static_cast<size_t>(pictures))) {
    const auto pose = trajectory.find(sequence);
    if (pose != trajectory.end()) Relocalize(told, map, sequence, pose->second);
  }
}

void Aftermath::Relocalize(const Testimony& told, const std::string& map, uint64_t sequence,
                           const Eigen::Vector3d& expected) {
  ++tally_->asked;
  v1::RelocalizeRequest request;
  request.set_map(map);
  *request.mutable_rig() = told.recording->rig;
  *request.mutable_frame() = told.recording->frames[sequence - 1];
  const auto response = client_.Relocalize(request);
  if (!response.ok() || response->result() != v1::RELOCALIZE_RESULT_FOUND) {
    Fail(absl::StrCat(map, ": frame ", sequence, " of ", told.acknowledged, " acknowledged is not found: ",
                      response.ok() ? response->ShortDebugString() : response.status().ToString()));
    return;
  }
  const v1::Vector3& found = response->map_from_camera().translation();
  const double apart = (Eigen::Vector3d(found.x(), found.y(), found.z()) - expected).norm();
  if (apart < kNear) {
    ++tally_->found;
  } else {
    Fail(absl::StrCat(map, ": frame ", sequence, " is found ", apart, " from where it was"));
  }
}

void Aftermath::InspectSession(const Testimony& told) {
  const auto session = client_.GetSession(told.session);
  if (!session.ok()) {
    Fail(absl::StrCat(told.session, " is not known: ", session.status().ToString()));
    return;
  }
  const bool finished = told.end.ok();
  const v1::SessionState state = finished ? v1::SESSION_STATE_FINISHED : v1::SESSION_STATE_ABANDONED;
  // All may have been stored before the vehicle could be told.
  const bool state_fits = session->state() == state || session->state() == v1::SESSION_STATE_FINISHED;
  // What is acknowledged at the very end of a session is that its frames were processed, tracked or not.
  const std::vector<uint64_t> tracked = told.Durable(told.tracked);
  const uint64_t durable = tracked.empty() ? 0 : tracked.back();
  if (!state_fits || session->last_acknowledged_sequence() < durable)
    Fail(absl::StrCat(told.map, ": ", session->ShortDebugString(), ", ", durable, " was acknowledged"));
  RawStream stream(connection_->channel());
  v1::StreamFramesRequest resume;
  resume.mutable_resume()->set_session(told.session);
  resume.mutable_resume()->set_resume_token(told.resume_token);
  stream.Write(resume);
  const absl::Status refused = stream.Finish();
  if (client::ErrorReason(refused) == "SESSION_NOT_RESUMABLE") {
    ++tally_->ended;
  } else {
    Fail(absl::StrCat(told.map, ": a session that died is taken up: ", refused.ToString()));
  }
}

void Aftermath::Inspect(const Testimony& told, int pictures) {
  const bool there = InspectMap(told.map);
  if (told.session.empty()) return;  // the hello was not answered: nothing was promised
  if (!there) {
    Fail(absl::StrCat(told.map, " is not there"));
    return;
  }
  InspectContents(told, told.map, pictures);
  InspectSession(told);
}

}  // namespace semmap::kill_test
