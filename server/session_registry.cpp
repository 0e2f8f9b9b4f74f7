#include "server/session_registry.h"

#include <algorithm>

#include <spdlog/spdlog.h>

#include "absl/cleanup/cleanup.h"
#include "server/camera_comparison.h"
#include "server/error_reasons.h"
#include "server/names.h"
#include "server/random_id.h"
#include "server/rig_conversion.h"
#include "slam/common/status_macros.h"
#include "storage/map_loader.h"

namespace semmap::server {
namespace {

constexpr size_t kSessionIdBytes = 8;
constexpr size_t kTokenBytes = 16;
constexpr size_t kMaxFinished = 1000;
constexpr size_t kMaxRequestId = 63;
constexpr size_t kMaxUserAgent = 128;
// What is left of the drain when waiting frames are given up.
constexpr double kDrainShareForFrames = 0.7;

absl::Status CheckMode(v1::SessionMode mode) {
  switch (mode) {
    case v1::SESSION_MODE_MAP:
    case v1::SESSION_MODE_EXTEND:
    case v1::SESSION_MODE_LOCALIZE:
      return absl::OkStatus();
    default:
      return Error(v1::ERROR_REASON_FIELD_INVALID, "hello.mode must be given", {{"field", "hello.mode"}});
  }
}

absl::StatusOr<v1::OverloadPolicy> CheckPolicy(v1::OverloadPolicy policy) {
  switch (policy) {
    case v1::OVERLOAD_POLICY_UNSPECIFIED:
    case v1::OVERLOAD_POLICY_BLOCK:
      return v1::OVERLOAD_POLICY_BLOCK;
    case v1::OVERLOAD_POLICY_LATEST_WINS:
      return v1::OVERLOAD_POLICY_LATEST_WINS;
    default:
      return Error(v1::ERROR_REASON_FIELD_INVALID, "hello.overload_policy is not known",
                   {{"field", "hello.overload_policy"}});
  }
}

// In a time that does not tell how much of a guess was right.
bool SameSecret(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

}  // namespace

SessionRegistry::SessionRegistry(const SessionEnvironment& environment, const SlamConfig& slam,
                                 SlamSessionFactory factory, Timer* timer)
    : environment_(environment),
      slam_(slam),
      factory_(std::move(factory)),
      timer_(timer),
      extended_maps_([this](const storage::MapInfo& map) { return LoadToExtend(map); }) {}

SessionRegistry::~SessionRegistry() = default;

// --- Hello

absl::StatusOr<SessionIdentity> SessionRegistry::ReadHello(const v1::SessionHello& hello) const {
  SessionIdentity identity;
  SEMMAP_RETURN_IF_ERROR(ValidateId("hello.vehicle_id", hello.vehicle_id()));
  SEMMAP_ASSIGN_OR_RETURN(identity.map_id, ParseMapName("hello.map", hello.map()));
  SEMMAP_RETURN_IF_ERROR(ValidateText("hello.request_id", hello.request_id(), kMaxRequestId));
  SEMMAP_RETURN_IF_ERROR(ValidateText("hello.user_agent", hello.user_agent(), kMaxUserAgent));
  SEMMAP_RETURN_IF_ERROR(CheckMode(hello.mode()));
  SEMMAP_ASSIGN_OR_RETURN(identity.policy, CheckPolicy(hello.overload_policy()));
  SEMMAP_ASSIGN_OR_RETURN(identity.rig, RigFromProto(hello.rig(), environment_.config.max_image_pixels));
  identity.id = RandomHex(kSessionIdBytes);
  identity.resume_token = RandomHex(kTokenBytes);
  identity.vehicle_id = hello.vehicle_id();
  identity.request_id = hello.request_id();
  identity.mode = hello.mode();
  identity.created_at = environment_.wall_clock();
  return identity;
}

absl::StatusOr<SessionRegistry::Opened> SessionRegistry::Open(const v1::SessionHello& hello) {
  SEMMAP_ASSIGN_OR_RETURN(SessionIdentity identity, ReadHello(hello));
  if (auto session = FindRepeated(identity)) return Opened{std::move(session), true};
  SEMMAP_RETURN_IF_ERROR(Reserve(identity));
  const auto release = absl::MakeCleanup([this, reserved = identity] { Release(reserved); });
  SEMMAP_ASSIGN_OR_RETURN(auto session, Make(std::move(identity)));
  const SessionIdentity& made = session->identity();
  spdlog::info("session begins session={} map={} vehicle={} agent=\"{}\"", made.id, made.map_id,
               made.vehicle_id, hello.user_agent());
  session->WhenOver([this, id = made.id](const v1::Session& last) { OnOver(id, last); });
  bool draining = false;
  {
    MutexLock lock(&mutex_);
    sessions_.emplace(made.id, session);
    draining = draining_;
  }
  if (draining) {
    session->End(v1::SESSION_END_REASON_SHUTDOWN,
                 Error(v1::ERROR_REASON_SHUTTING_DOWN, "the server is stopping"));
  }
  return Opened{std::move(session), false};
}

std::shared_ptr<VehicleSession> SessionRegistry::FindRepeated(const SessionIdentity& identity) const {
  if (identity.request_id.empty()) return nullptr;
  MutexLock lock(&mutex_);
  const auto same = [&](const auto& entry) {
    const SessionIdentity& other = entry.second->identity();
    return other.request_id == identity.request_id && other.vehicle_id == identity.vehicle_id &&
           other.map_id == identity.map_id;
  };
  const auto found = std::find_if(sessions_.begin(), sessions_.end(), same);
  return found == sessions_.end() ? nullptr : found->second;
}

absl::Status SessionRegistry::Reserve(const SessionIdentity& identity) {
  MutexLock lock(&mutex_);
  if (draining_) return Error(v1::ERROR_REASON_SHUTTING_DOWN, "the server is stopping");
  const size_t count = sessions_.size() + reserved_.size();
  if (count >= static_cast<size_t>(environment_.config.max_sessions)) {
    return Error(v1::ERROR_REASON_TOO_MANY_SESSIONS,
                 "the server has as many sessions as it is configured for");
  }
  if (held_.contains(identity.map_id)) {
    return Error(v1::ERROR_REASON_MAP_IN_USE, "an operation changes this map right now",
                 {{"map", identity.map_id}});
  }
  if (IsMapTaken(identity))
    return Error(v1::ERROR_REASON_MAP_IN_USE, "another session changes this map right now");
  reserved_.emplace(identity.map_id, identity.mode);
  return absl::OkStatus();
}

bool SessionRegistry::IsMapTaken(const SessionIdentity& identity) const {
  const auto excludes = [&](v1::SessionMode other) {
    if (identity.mode == v1::SESSION_MODE_LOCALIZE || other == v1::SESSION_MODE_LOCALIZE) return false;
    return identity.mode == v1::SESSION_MODE_MAP;
  };
  const auto [begin, end] = reserved_.equal_range(identity.map_id);
  return std::any_of(begin, end, [&](const auto& entry) { return excludes(entry.second); }) ||
         std::any_of(sessions_.begin(), sessions_.end(), [&](const auto& entry) {
           const SessionIdentity& other = entry.second->identity();
           return other.map_id == identity.map_id && excludes(other.mode);
         });
}

void SessionRegistry::Release(const SessionIdentity& identity) {
  MutexLock lock(&mutex_);
  const auto [begin, end] = reserved_.equal_range(identity.map_id);
  const auto own = std::find_if(begin, end, [&](const auto& entry) { return entry.second == identity.mode; });
  if (own != end) reserved_.erase(own);
}

absl::StatusOr<std::shared_ptr<VehicleSession>> SessionRegistry::Make(SessionIdentity identity) {
  auto session = std::make_shared<VehicleSession>(std::move(identity), environment_);
  const SessionIdentity& made = session->identity();
  // First what leaves nothing behind when it fails.
  storage::MapId map;
  if (made.mode == v1::SESSION_MODE_MAP) {
    auto extended = std::make_shared<ExtendedMap>(std::make_shared<SharedMap>());
    SEMMAP_RETURN_IF_ERROR(session->CreateSlam(factory_, slam_, {nullptr, extended->slam}, extended));
    SEMMAP_ASSIGN_OR_RETURN(map, MakeEmptyMap(made));
    extended_maps_.Put(map, extended);
  } else {
    SEMMAP_ASSIGN_OR_RETURN(const storage::MapInfo stored_map, FindStoredMap(made));
    SEMMAP_RETURN_IF_ERROR(StartInMap(stored_map, session.get()));
    map = stored_map.id;
  }
  const auto stored =
      environment_.store->StartSession({map, made.id, made.vehicle_id, made.created_at, made.rig});
  if (!stored.ok()) return FromStore(stored.status());
  session->SetStored(map, stored->id);
  return session;
}

absl::StatusOr<storage::MapInfo> SessionRegistry::FindStoredMap(const SessionIdentity& identity) {
  auto map = environment_.store->GetMap(identity.map_id);
  if (!map.ok()) return FromStore(map.status());
  if (map->keyframe_count == 0)
    return Error(v1::ERROR_REASON_MAP_EMPTY, "the map has no keyframes", {{"map", identity.map_id}});
  if (identity.mode == v1::SESSION_MODE_EXTEND && !SameCameras(identity.rig, map->rig)) {
    return Error(v1::ERROR_REASON_RIG_INVALID,
                 "a map is extended with cameras like those that it was made with");
  }
  return map;
}

absl::Status SessionRegistry::StartInMap(const storage::MapInfo& map, VehicleSession* session) {
  SessionStart start;
  std::shared_ptr<ExtendedMap> extended;
  if (environment_.maps == nullptr) return NotImplemented("sessions in stored maps");
  if (session->identity().mode == v1::SESSION_MODE_LOCALIZE) {
    SEMMAP_ASSIGN_OR_RETURN(start.localize, environment_.maps->GetAndWait(map));
  } else {
    SEMMAP_ASSIGN_OR_RETURN(extended, extended_maps_.Get(map));
    start.shared = extended->slam;
  }
  return session->CreateSlam(factory_, slam_, std::move(start), std::move(extended));
}

// A copy beside the cache's, and of this very moment: nobody but those who extend it together changes the map
// from now on.
absl::StatusOr<std::shared_ptr<ExtendedMap>> SessionRegistry::LoadToExtend(
    const storage::MapInfo& map) const {
  const size_t max_bytes = static_cast<size_t>(environment_.config.map_memory_mb) << 20;
  auto restored = storage::LoadMap(*environment_.store, map.id,
                                   ScalePyramidInfo(slam_.orb.levels, slam_.orb.scale_factor), max_bytes,
                                   slam_.semantics.PointPolicy());
  if (absl::IsResourceExhausted(restored.status()))
    return WithReason(restored.status(), v1::ERROR_REASON_MAP_TOO_LARGE);
  if (!restored.ok()) return FromStore(restored.status());
  return std::make_shared<ExtendedMap>(
      std::make_shared<SharedMap>(std::move(restored->map), restored->info.last_keyframe_id));
}

absl::StatusOr<storage::MapId> SessionRegistry::MakeEmptyMap(const SessionIdentity& identity) {
  storage::MapStore& store = *environment_.store;
  const auto existing = store.GetMap(identity.map_id);
  storage::NewMap map;
  map.name = identity.map_id;
  map.created_at = identity.created_at;
  if (existing.ok()) {
    if (existing->keyframe_count != 0) {
      return Error(v1::ERROR_REASON_MAP_NOT_EMPTY, "the map holds keyframes already",
                   {{"map", identity.map_id}});
    }
    // An empty map knows nothing but what was said about it and an arbitrary rig: begin it anew with the
    // vehicle's.
    map.created_at = existing->created_at;
    map.display_name = existing->display_name;
    map.labels = existing->labels;
    map.anchor = existing->anchor;
    SEMMAP_RETURN_IF_ERROR(FromStore(store.DeleteMap(existing->id)));
    environment_.watchers->OnReset(existing->id);
  } else if (existing.status().code() != absl::StatusCode::kNotFound) {
    return FromStore(existing.status());
  }
  map.rig = identity.rig;
  map.scale_known = identity.rig.sensor != SensorType::kMono;
  const auto created = store.CreateMap(map);
  if (!created.ok()) return FromStore(created.status());
  return created->id;
}

// --- Later

absl::StatusOr<std::shared_ptr<VehicleSession>> SessionRegistry::Resume(const v1::SessionResume& resume) {
  SEMMAP_ASSIGN_OR_RETURN(const std::string id, ParseSessionName("resume.session", resume.session()));
  auto session = Find(id);
  if (session != nullptr && SameSecret(session->identity().resume_token, resume.resume_token()))
    return session;
  return Error(v1::ERROR_REASON_SESSION_NOT_RESUMABLE,
               "the session is over or unknown, or the token is wrong");
}

void SessionRegistry::OnStreamBroken(const std::shared_ptr<VehicleSession>& session,
                                     const StreamOutput* output) {
  const auto interruption = session->Detach(output);
  if (!interruption.has_value()) return;
  timer_->After(absl::Seconds(environment_.config.resume_timeout_s),
                [weak = std::weak_ptr<VehicleSession>(session), interruption] {
                  if (const auto waiting = weak.lock()) waiting->EndIfStillInterrupted(*interruption);
                });
}

std::shared_ptr<VehicleSession> SessionRegistry::Find(const std::string& session_id) const {
  MutexLock lock(&mutex_);
  const auto found = sessions_.find(session_id);
  return found == sessions_.end() ? nullptr : found->second;
}

std::optional<v1::Session> SessionRegistry::Describe(const std::string& session_id) const {
  if (const auto session = Find(session_id)) return session->Snapshot();
  MutexLock lock(&mutex_);
  const auto found = std::find_if(finished_.begin(), finished_.end(),
                                  [&](const auto& entry) { return entry.first == session_id; });
  if (found == finished_.end()) return std::nullopt;
  return found->second;
}

bool SessionRegistry::IsInUse(const std::string& map_id) const {
  const auto on_map = [&](const auto& entry) { return entry.second->identity().map_id == map_id; };
  return held_.contains(map_id) || reserved_.contains(map_id) ||
         std::any_of(sessions_.begin(), sessions_.end(), on_map);
}

bool SessionRegistry::IsMapInUse(const std::string& map_id) const {
  MutexLock lock(&mutex_);
  return IsInUse(map_id);
}

absl::StatusOr<std::shared_ptr<SessionRegistry::MapHold>> SessionRegistry::Hold(
    const std::vector<std::string>& map_ids) {
  MutexLock lock(&mutex_);
  for (const std::string& id : map_ids) {
    if (IsInUse(id))
      return Error(v1::ERROR_REASON_MAP_IN_USE, "a session or an operation is on the map", {{"map", id}});
  }
  held_.insert(map_ids.begin(), map_ids.end());
  return std::make_shared<MapHold>(this, map_ids);
}

void SessionRegistry::LetGo(const std::vector<std::string>& map_ids) {
  MutexLock lock(&mutex_);
  for (const std::string& id : map_ids) held_.erase(id);
}

size_t SessionRegistry::size() const {
  MutexLock lock(&mutex_);
  return sessions_.size();
}

void SessionRegistry::OnOver(const std::string& session_id, const v1::Session& last) {
  MutexLock lock(&mutex_);
  sessions_.erase(session_id);
  finished_.emplace_back(session_id, last);
  if (finished_.size() > kMaxFinished) finished_.pop_front();
}

std::vector<std::shared_ptr<VehicleSession>> SessionRegistry::All() const {
  MutexLock lock(&mutex_);
  std::vector<std::shared_ptr<VehicleSession>> all;
  for (const auto& [id, session] : sessions_) all.push_back(session);
  return all;
}

void SessionRegistry::Drain(absl::Duration timeout) {
  {
    MutexLock lock(&mutex_);
    draining_ = true;
  }
  const absl::Status stopping = Error(v1::ERROR_REASON_SHUTTING_DOWN, "the server is stopping");
  for (const auto& session : All()) session->End(v1::SESSION_END_REASON_SHUTDOWN, stopping);
  {
    MutexLock lock(&mutex_);
    if (mutex_.AwaitWithTimeout(timeout * kDrainShareForFrames, &SessionRegistry::IsEmpty, this)) return;
  }
  for (const auto& session : All()) session->DropWaitingFrames();
  MutexLock lock(&mutex_);
  if (!mutex_.AwaitWithTimeout(timeout * (1 - kDrainShareForFrames), &SessionRegistry::IsEmpty, this)) {
    spdlog::error("{} sessions could not be stored in time", sessions_.size());
  }
}

}  // namespace semmap::server
