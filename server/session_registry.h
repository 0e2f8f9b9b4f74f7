#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "semmap/v1/session.pb.h"
#include "server/shared_maps.h"
#include "server/timer.h"
#include "server/vehicle_session.h"
#include "slam/common/mutex.h"

namespace semmap::server {

// All sessions that are not over, and what the last thousand that are over came to. Begins sessions, finds
// them again, ends those that nobody resumes. Thread-safe; Open talks to the store and may take a while.
class SessionRegistry {
 public:
  // `environment`'s pointers and `timer` outlive the registry.
  SessionRegistry(const SessionEnvironment& environment, const SlamConfig& slam, SlamSessionFactory factory,
                  Timer* timer);
  ~SessionRegistry();
  SessionRegistry(const SessionRegistry&) = delete;
  SessionRegistry& operator=(const SessionRegistry&) = delete;

  struct Opened {
    std::shared_ptr<VehicleSession> session;
    bool resumed = false;  // a hello that was sent twice
  };
  // Checks the hello, makes map and session in the store. All reasons of a hello, see the contract.
  absl::StatusOr<Opened> Open(const v1::SessionHello& hello);
  // SESSION_NOT_RESUMABLE.
  absl::StatusOr<std::shared_ptr<VehicleSession>> Resume(const v1::SessionResume& resume);
  // A stream is gone without having ended its session.
  void OnStreamBroken(const std::shared_ptr<VehicleSession>& session, const StreamOutput* output);

  // Null when there is no such session, or it is over.
  std::shared_ptr<VehicleSession> Find(const std::string& session_id) const;
  // Running, or over and still remembered.
  std::optional<v1::Session> Describe(const std::string& session_id) const;
  // By a session, or held.
  bool IsMapInUse(const std::string& map_id) const;
  // Keeps sessions off the maps until it goes; copies are one hold. Outlived by the registry.
  class MapHold;
  // MAP_IN_USE when any of the maps is.
  absl::StatusOr<std::shared_ptr<MapHold>> Hold(const std::vector<std::string>& map_ids);
  size_t size() const;

  // Refuses new sessions, ends all and waits until they are stored. Past the deadline, frames that wait are
  // left out.
  void Drain(absl::Duration timeout);

 private:
  absl::StatusOr<SessionIdentity> ReadHello(const v1::SessionHello& hello) const;
  std::shared_ptr<VehicleSession> FindRepeated(const SessionIdentity& identity) const;
  // Holds a place and the map's name while a session is made. MAP_IN_USE when it would make a map that
  // another session makes or extends; any number may extend one together, or read it.
  absl::Status Reserve(const SessionIdentity& identity);
  void Release(const SessionIdentity& identity);
  bool IsMapTaken(const SessionIdentity& identity) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<std::shared_ptr<VehicleSession>> Make(SessionIdentity identity);
  absl::StatusOr<storage::MapId> MakeEmptyMap(const SessionIdentity& identity);
  // LOCALIZE and EXTEND: a map that has keyframes, and, to be extended, was made with the same cameras.
  absl::StatusOr<storage::MapInfo> FindStoredMap(const SessionIdentity& identity);
  // Has the session begin in the stored map. Loads it if it is not there; takes a while.
  absl::Status StartInMap(const storage::MapInfo& map, VehicleSession* session);
  absl::StatusOr<std::shared_ptr<ExtendedMap>> LoadToExtend(const storage::MapInfo& map) const;
  void OnOver(const std::string& session_id, const v1::Session& last);
  std::vector<std::shared_ptr<VehicleSession>> All() const;
  bool IsEmpty() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return sessions_.empty() && reserved_.empty();
  }
  bool IsInUse(const std::string& map_id) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void LetGo(const std::vector<std::string>& map_ids);

  const SessionEnvironment environment_;
  const SlamConfig slam_;
  const SlamSessionFactory factory_;
  Timer* const timer_;
  SharedMaps extended_maps_;

  mutable Mutex mutex_;  // guards all below
  std::map<std::string, std::shared_ptr<VehicleSession>> sessions_ ABSL_GUARDED_BY(mutex_);
  // Maps of the sessions that are being made, and what these will do.
  std::multimap<std::string, v1::SessionMode> reserved_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string> held_ ABSL_GUARDED_BY(mutex_);  // maps that sessions are kept off
  std::deque<std::pair<std::string, v1::Session>> finished_ ABSL_GUARDED_BY(mutex_);
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
};

class SessionRegistry::MapHold {
 public:
  MapHold(SessionRegistry* registry, std::vector<std::string> map_ids)
      : registry_(registry), map_ids_(std::move(map_ids)) {}
  ~MapHold() { registry_->LetGo(map_ids_); }
  MapHold(const MapHold&) = delete;
  MapHold& operator=(const MapHold&) = delete;

 private:
  SessionRegistry* const registry_;
  const std::vector<std::string> map_ids_;
};

}  // namespace semmap::server
