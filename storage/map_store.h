#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/common/ids.h"
#include "slam/common/time.h"
#include "slam/geometry/camera.h"
#include "slam/geometry/se3.h"
#include "slam/map/map_delta.h"
#include "slam/map/map_parts.h"
#include "storage/storage_config.h"

// The database of maps. A map grows by deltas, each of which is one transaction: after a crash at any instant
// a map is as some delta left it, never in between. Everything is answered from the database; nothing is
// cached above it.
namespace semmap::storage {

// Ids that the store hands out. A map keeps its id for life; a session's id is unique within its map.
using MapId = StrongId<struct MapIdTag>;
using SessionId = StrongId<struct SessionIdTag>;

// ---------------------------------------------------------------------------------------------------------
// Values

// [begin, end), nanoseconds of the vehicles' clock. The default is all of time.
struct TimeRange {
  TimestampNs begin = std::numeric_limits<TimestampNs>::min();
  TimestampNs end = std::numeric_limits<TimestampNs>::max();
};

// Ties a map to the Earth: east-north-up axes at a WGS84 position, and where the map's points lie in them.
struct GeoAnchor {
  enum class Source {
    kGiven = 1,   // by a person or another program
    kFitted = 2,  // to fixes of satellite receivers
  };
  double latitude_deg = 0;   // [-90, 90]
  double longitude_deg = 0;  // [-180, 180]
  double altitude_m = 0;     // above the ellipsoid
  Sim3 enu_from_map;         // its scale is 1 where the map's own scale is known
  Source source = Source::kGiven;
  double rms_error_m = 0;  // of the fit, horizontal; 0 for a given one
};

// Free texts by free keys: at most 64, keys of 1 to 252 bytes, values of at most 1020.
using Labels = std::map<std::string, std::string>;

// What a map is created with.
struct NewMap {
  // [a-zA-Z0-9][a-zA-Z0-9_.-]{0,62}, unique in the store; see ValidateMapName.
  std::string name;
  TimestampNs created_at = 0;  // Unix epoch, as are all *_at
  // What the map's first vehicle looks through. Each session has its own, too.
  CameraRig rig;
  // False while the unit of length is arbitrary (monocular).
  bool scale_known = true;
  std::string display_name = {};  // at most 1024 bytes of any text
  Labels labels = {};
  std::optional<GeoAnchor> anchor = std::nullopt;
};

// What to change of what is said about a map; what is absent stays.
struct MapChanges {
  std::optional<std::string> display_name = std::nullopt;
  std::optional<Labels> labels = std::nullopt;
  // Of the anchor, an absent one takes it away.
  std::optional<std::optional<GeoAnchor>> anchor = std::nullopt;
  // Only if the map's version and revision still are these.
  struct State {
    uint64_t version = 0;
    uint64_t revision = 0;
  };
  std::optional<State> expected = std::nullopt;
};

struct MapInfo {
  // For life, unless the map is made over (RewriteMap).
  MapId id;
  std::string name;
  TimestampNs created_at = 0;
  std::string display_name;
  Labels labels;
  // Last change of contents or of what is said about it, to the second; absent for maps that an older version
  // of the store changed last.
  std::optional<TimestampNs> updated_at;
  CameraRig rig;
  bool scale_known = true;
  std::optional<GeoAnchor> anchor;
  uint64_t keyframe_count = 0;
  uint64_t point_count = 0;
  // Grows by one with each delta that is applied, whoever sent it, unless there is nothing in it but frames.
  uint64_t version = 0;
  // Grows by one with each change of name, display name, labels or anchor.
  uint64_t revision = 0;
  // The greatest ids that the map ever held, 0 for none: new ones must be greater.
  KeyFrameId last_keyframe_id;
  MapPointId last_point_id;
  // Of the camera centres of the keyframes, in the map frame; empty (isEmpty()) without keyframes.
  Eigen::AlignedBox3d camera_extent;
};

// A map made over as a whole: its contents, those of another one beside them if one is joined to it, and what
// has changed of both.
struct MapRewrite {
  // A map as it was when the changes were worked out.
  struct Basis {
    MapId map;
    uint64_t version = 0;
  };
  Basis map;
  // Comes along with all it holds. The ids of its keyframes, points and sessions grow by the greatest that
  // `map` ever held of each (MapInfo::last_keyframe_id, ...).
  std::optional<Basis> joined = std::nullopt;
  bool delete_joined = false;
  // By the new ids. Nothing is added: there are no new keyframes, points or frames, and no reset. Every point
  // of a joined map is among the changed or the removed ones.
  MapDelta changes = {};
  // For a map that has none.
  std::optional<GeoAnchor> anchor = std::nullopt;
};

// What a session is started with.
struct NewSession {
  MapId map;
  // The server's name of the session, 1 to 128 printable ASCII characters, unique in the store.
  std::string name;
  std::string vehicle_id;  // at most 256 bytes of any text
  TimestampNs started_at = 0;
  CameraRig rig;
};

// What the server counts and the store keeps for it.
struct SessionCounters {
  uint64_t frames_received = 0;
  uint64_t frames_tracked = 0;
};

struct SessionInfo {
  SessionId id;
  MapId map;
  std::string name;
  std::string vehicle_id;
  TimestampNs started_at = 0;
  // Absent while it runs, and for ever if the server died during it.
  std::optional<TimestampNs> ended_at;
  CameraRig rig;
  SessionCounters counters;
  // Number of frames with a stored pose.
  uint64_t stored_frames = 0;
  // The greatest frame sequence of any applied delta (frames and keyframes); absent before the first.
  std::optional<uint64_t> last_durable_sequence;
  // MapDelta::version of the last delta applied; 0 before the first.
  uint64_t last_delta_version = 0;
};

// A stored keyframe.
struct KeyFrameEntry {
  SessionId session;
  // record.features is null unless features were asked for. They are what the store kept of the keyframe's
  // (see StorageConfig::keyframe_keypoints), with features->frame_index telling which, at the precision of
  // storage/feature_codec.h.
  KeyFrameRecord record;
  // Of the frame; as many or fewer are stored.
  uint32_t keypoint_count = 0;
  // How many of its keypoints see a map point.
  uint32_t observation_count = 0;
};

// A frame of a trajectory. map_from_camera = (the keyframe's present pose) * keyframe_from_camera.
struct TrajectoryPose {
  SessionId session;
  uint64_t sequence = 0;
  TimestampNs timestamp = 0;
  KeyFrameId reference_keyframe;
  SE3 map_from_camera;
};

struct MapSummary {
  MapInfo map;
  // Camera centres and points; either may be empty.
  Eigen::AlignedBox3d camera_extent;
  Eigen::AlignedBox3d point_extent;
  struct ClassCount {
    uint8_t semantic_class = 255;
    uint64_t points = 0;
  };
  // Ascending by class; classes without points are left out.
  std::vector<ClassCount> points_per_class;
  uint64_t session_count = 0;
  uint64_t frame_count = 0;
  // Sum over sessions of the distance from frame to frame, in units of the map.
  double trajectory_length = 0;
  // Timestamps of the first and last keyframe; begin == end without keyframes.
  TimestampNs first_keyframe_time = 0;
  TimestampNs last_keyframe_time = 0;
  // Bytes of the packed features and observations of this map, and of the whole database with its log.
  uint64_t feature_bytes = 0;
  uint64_t observation_bytes = 0;
  uint64_t database_bytes = 0;
};

// One thing found wrong with a map.
struct IntegrityFinding {
  // A stable word for programs: "dangling-observation", "count-mismatch", "not-finite", "undecodable", ...
  std::string kind;
  // For people; names the thing and what is wrong with it.
  std::string message;
};

// ---------------------------------------------------------------------------------------------------------
// Queries. All results come in ascending order of id; `after` continues behind the last one of an earlier
// answer, so that it is a page token. limit 0 means no limit. All conditions must hold.

struct MapListQuery {
  std::string after = {};  // a name; maps come in order of names (bytes)
  size_t limit = 0;
};

struct MapPointQuery {
  std::optional<Eigen::AlignedBox3d> box = std::nullopt;  // closed; INVALID_ARGUMENT when empty or not finite
  std::vector<uint8_t> classes = {};                      // any of them; none given: all
  float min_confidence = 0;                               // of class_confidence
  uint32_t min_observations = 0;
  // Points whose [first_seen, last_seen] meets the range.
  std::optional<TimeRange> seen = std::nullopt;
  MapPointId after = {};
  size_t limit = 0;
};

struct KeyFrameQuery {
  std::optional<Eigen::AlignedBox3d> box = std::nullopt;  // of the camera centre, closed
  std::optional<TimeRange> time = std::nullopt;
  std::optional<SessionId> session = std::nullopt;
  bool with_features = false;
  KeyFrameId after = {};
  size_t limit = 0;
};

struct TrajectoryQuery {
  std::optional<SessionId> session = std::nullopt;  // absent: all sessions, one after the other
  std::optional<TimeRange> time = std::nullopt;
  // Continues behind this frame of a session (of the first one named here, when all are asked for).
  struct Position {
    SessionId session = {};
    uint64_t sequence = 0;
  };
  std::optional<Position> after = std::nullopt;
  size_t limit = 0;
};

// Called with one result after the other; returning false ends the query early, which is no failure. The call
// runs inside a read transaction of the calling thread: what it sees is one consistent state of the map, and
// it must not wait for long (the log of writes cannot shrink meanwhile) nor call the store.
using MapPointVisitor = std::function<bool(const MapPointRecord&)>;
using KeyFrameVisitor = std::function<bool(const KeyFrameEntry&)>;
using TrajectoryVisitor = std::function<bool(const TrajectoryPose&)>;

// Receives a whole map in the order of the methods, sessions, points and keyframes in that of their ids. A
// failure ends the reading and becomes its status. The rule for the visitors above holds for it, too.
class MapReader {
 public:
  virtual ~MapReader() = default;
  virtual absl::Status OnMap(const MapInfo& map) = 0;
  virtual absl::Status OnSession(const SessionInfo& session) = 0;
  virtual absl::Status OnPoint(const MapPointRecord& point) = 0;
  // With features.
  virtual absl::Status OnKeyFrame(const KeyFrameEntry& keyframe, KeyFrameObservations observations) = 0;
};

// How features become words of a place index.
struct PlaceWording {
  // Tells ways apart: words of different ones cannot be compared.
  uint64_t vocabulary = 0;
  // Ascending, with repetitions. Called by any thread.
  std::function<std::vector<uint32_t>(const FrameFeatures&)> words_of;
};

struct KeyFrameWords {
  KeyFrameId id;
  std::vector<uint32_t> words;
};

// A keyframe as far as it can be told without its features.
struct KeyFrameOutline {
  KeyFrameId id;
  SE3 map_from_camera;
  // In the order of the keypoints that see them.
  std::vector<MapPointId> points;
  // nullopt when none are stored by the vocabulary that was asked for.
  std::optional<std::vector<uint32_t>> words;
};

// Receives the outline of a map, keyframes in order of their ids; as MapReader.
class MapOutlineReader {
 public:
  virtual ~MapOutlineReader() = default;
  virtual absl::Status OnMap(const MapInfo& map) = 0;
  virtual absl::Status OnKeyFrame(KeyFrameOutline keyframe) = 0;
};

// Called now and then with the share of a long work that is done, [0, 1]; returning false ends the work with
// CANCELLED and leaves nothing behind.
using ProgressVisitor = std::function<bool(double)>;

// ---------------------------------------------------------------------------------------------------------

// Thread-safe: any method may be called from any thread. Writes are done one at a time; reads run
// at the same time as others and as a write, each on a snapshot of its own, and never hold up a writer.
//
// Errors of every method, besides those it names:
//   NOT_FOUND            no such map, session or keyframe
//   INVALID_ARGUMENT     a value that cannot be stored or asked for; nothing was changed
//   UNAVAILABLE          somebody else holds the database for longer than the configured time; try again
//   RESOURCE_EXHAUSTED   the disk is full; nothing was changed
//   DATA_LOSS            what is stored cannot be decoded or the database is damaged
//   INTERNAL             anything else that the database says
// After any error of a writing method the stored state is as before the call.
class MapStore {
 public:
  virtual ~MapStore() = default;

  // --- Maps

  // ALREADY_EXISTS when the name is taken.
  virtual absl::StatusOr<MapInfo> CreateMap(const NewMap& map) = 0;
  virtual absl::StatusOr<MapInfo> GetMap(std::string_view name) = 0;
  virtual absl::StatusOr<MapInfo> GetMap(MapId map) = 0;
  virtual absl::StatusOr<std::vector<MapInfo>> ListMaps(const MapListQuery& query) = 0;
  // Removes the map with all that belongs to it. Name and map are gone at once and together; the rest follows
  // in bounded transactions between those of other writers, before this returns or, after a crash, when the
  // store is next opened. Sessions still writing get NOT_FOUND.
  virtual absl::Status DeleteMap(MapId map) = 0;
  // ALREADY_EXISTS when the name is taken.
  virtual absl::StatusOr<MapInfo> RenameMap(MapId map, std::string_view name) = 0;
  // Another map with the same contents, ids and sessions (these with the new map's id behind their names), in
  // bounded transactions; it is not seen before it is whole. ALREADY_EXISTS when the name is taken; ABORTED
  // when `map` was changed meanwhile.
  virtual absl::StatusOr<MapInfo> CopyMap(MapId map, std::string_view name, TimestampNs created_at,
                                          const ProgressVisitor& progress) = 0;
  // Writes one map, as it is at one instant, to a new file that ImportMap reads. The file appears under its
  // name when it is complete, until then with ".part" behind it. ALREADY_EXISTS; PERMISSION_DENIED.
  virtual absl::Status ExportMap(MapId map, const std::string& path, const ProgressVisitor& progress) = 0;
  // Makes a map of such a file, in bounded transactions; it is not seen before it is whole. Sessions keep
  // their names where these are free, others get the map's id behind theirs. The file may come from anywhere:
  // INVALID_ARGUMENT says what is wrong with it. It is this call's alone and may be changed (an older version
  // is upgraded). ALREADY_EXISTS when the name is taken.
  virtual absl::StatusOr<MapInfo> ImportMap(const std::string& path, std::string_view name,
                                            TimestampNs created_at, const ProgressVisitor& progress) = 0;
  // Replaces a map by what the rewrite makes of it, in bounded transactions beside it: until the last of them
  // the maps are as they were, after it name, description and session names are those that the map had at
  // that instant, its id is another and its version one more. ABORTED when a map was changed or deleted
  // meanwhile, CANCELLED by `progress`; INVALID_ARGUMENT for changes that are not as MapRewrite says.
  virtual absl::StatusOr<MapInfo> RewriteMap(const MapRewrite& rewrite, const ProgressVisitor& progress) = 0;
  // ABORTED when `changes.expected` is not how the map is.
  virtual absl::StatusOr<MapInfo> UpdateMap(MapId map, const MapChanges& changes) = 0;
  // nullopt takes the anchor away.
  absl::Status SetAnchor(MapId map, const std::optional<GeoAnchor>& anchor);

  // --- Sessions

  // ALREADY_EXISTS when the name is taken.
  virtual absl::StatusOr<SessionInfo> StartSession(const NewSession& session) = 0;
  virtual absl::Status UpdateSession(MapId map, SessionId session, const SessionCounters& counters) = 0;
  // FAILED_PRECONDITION when it has ended before.
  virtual absl::Status EndSession(MapId map, SessionId session, TimestampNs ended_at,
                                  const SessionCounters& counters) = 0;
  virtual absl::StatusOr<SessionInfo> GetSession(MapId map, SessionId session) = 0;
  virtual absl::StatusOr<SessionInfo> GetSession(std::string_view name) = 0;
  // In order of ids, that is of their start; those with greater ids than `after`. limit 0: all.
  virtual absl::StatusOr<std::vector<SessionInfo>> ListSessions(MapId map, SessionId after, size_t limit) = 0;

  // --- Growing

  // Applies one delta as one transaction; when this returns OK it is durable (with synchronous NORMAL against
  // the death of the process, with FULL against that of the machine). Members are applied in their order:
  // - reset: what this session added so far (its keyframes, points and frames) is forgotten;
  //   FAILED_PRECONDITION when other sessions built on it;
  // - added_keyframes: ids must be new to the map;
  // - moved_keyframes: must exist;
  // - upserted_points: replaced as a whole, or added;
  // - observations: of existing keyframes, replaced as a whole; as long as the keypoints that the keyframe
  // was added
  //   with, or, by who loaded it, as long as those that are stored. With `features`, keypoints that were not
  //   stored before are when they see a point; without, that is INVALID_ARGUMENT;
  // - removed_keyframes: must exist, and so must the heir. They go with their features and observations;
  // their
  //   frames are re-anchored to the heir (rewritten poses); children that no delta moved to another parent
  //   become the heir's (the heir itself, when it is a child, takes the removed one's parent);
  // - removed_points: unknown ones are passed over. No observation may name a removed point any more, which
  // is
  //   not checked here but by CheckIntegrity;
  // - frames: of existing keyframes; a frame sent again replaces the earlier pose.
  // delta.version must be one more than that of the session's previous delta (the first may have any), so
  // that a delta is neither lost nor applied twice: ALREADY_EXISTS when it is not greater,
  // FAILED_PRECONDITION when one is missing. Empty deltas therefore count and are to be applied as well.
  // INVALID_ARGUMENT names the first member that breaks these rules or has values that are not finite.
  // FAILED_PRECONDITION also when the session has ended.
  virtual absl::Status Apply(MapId map, SessionId session, const MapDelta& delta) = 0;

  // --- Queries

  virtual absl::Status ForEachMapPoint(MapId map, const MapPointQuery& query,
                                       const MapPointVisitor& visit) = 0;
  // Those of `ids` that exist, in the order of `ids`.
  virtual absl::StatusOr<std::vector<MapPointRecord>> GetMapPoints(MapId map,
                                                                   std::span<const MapPointId> ids) = 0;
  virtual absl::Status ForEachKeyFrame(MapId map, const KeyFrameQuery& query,
                                       const KeyFrameVisitor& visit) = 0;
  // With features.
  virtual absl::StatusOr<KeyFrameEntry> GetKeyFrame(MapId map, KeyFrameId keyframe) = 0;
  // point_of_keypoint is as long as the keyframe has stored keypoints, and in their order; all none when
  // nothing was ever stored for it. `features` is null.
  virtual absl::StatusOr<KeyFrameObservations> GetObservations(MapId map, KeyFrameId keyframe) = 0;
  // Frames in order of session, then of sequence.
  virtual absl::Status ForEachTrajectoryPose(MapId map, const TrajectoryQuery& query,
                                             const TrajectoryVisitor& visit) = 0;
  // Everything there is of a map, as it was at one instant.
  virtual absl::Status ReadWhole(MapId map, MapReader* reader) = 0;
  // Where its keyframes stand, what they see and, by this vocabulary, look like; as it was at one instant.
  // Reads some three kilobytes a keyframe.
  virtual absl::Status ReadOutline(MapId map, uint64_t vocabulary, MapOutlineReader* reader) = 0;
  // Calls `read` with a reader of the map's parts, all as they were at one instant. The rule for visitors
  // holds for it, too.
  virtual absl::Status ReadParts(MapId map, absl::FunctionRef<absl::Status(MapPartReader&)> read) = 0;
  // Reads the whole map (not its features): seconds for millions of points.
  virtual absl::StatusOr<MapSummary> Summarize(MapId map) = 0;

  // --- Words. They follow from features and are kept because to make them takes the features of the whole
  // map.

  // From now on words are stored with the features that Apply stores. Before that: none are.
  virtual void StoreWordsBy(PlaceWording wording) = 0;
  // Stores words that were made of the stored features of keyframes; ABORTED, and nothing is stored, when the
  // map's version is another by now.
  virtual absl::Status StoreWords(MapId map, uint64_t version, uint64_t vocabulary,
                                  std::span<const KeyFrameWords> keyframes) = 0;

  // --- Care

  // Reads everything of the map and reports at most `max_findings` things that are wrong; empty: the map is
  // sound. Checks the database file's own structure as well. Damage is a finding, not a failure of the call.
  virtual absl::StatusOr<std::vector<IntegrityFinding>> CheckIntegrity(MapId map, size_t max_findings) = 0;
  // Removes or makes anew, in one transaction, what contradicts itself in the map, so that CheckIntegrity
  // finds it sound; what sound parts say is kept. Damage of the database file's own structure stays.
  virtual absl::Status RepairMap(MapId map) = 0;
  // Writes all maps as they are now to a new file, a database of its own, while others read and write. The
  // file appears under its name when it is complete. ALREADY_EXISTS; PERMISSION_DENIED.
  virtual absl::Status Backup(const std::string& path, const ProgressVisitor& progress) = 0;
  // Bytes of the whole database with its log.
  virtual absl::StatusOr<uint64_t> DatabaseBytes() = 0;
};

// ---------------------------------------------------------------------------------------------------------

// INVALID_ARGUMENT unless `name` is [a-zA-Z0-9][a-zA-Z0-9_.-]{0,62}.
absl::Status ValidateMapName(std::string_view name);

// Opens the store that config.uri names, creating it where there is none ("sqlite:///absolute/path.db" or
// "sqlite:relative/path.db"). Upgrades an older database, once, under an exclusive lock. INVALID_ARGUMENT for
// a uri nobody can open, FAILED_PRECONDITION for a database that is not semmap's or was written by a newer
// version, DATA_LOSS for a damaged one, UNAVAILABLE when it is locked, PERMISSION_DENIED when the file cannot
// be opened.
absl::StatusOr<std::unique_ptr<MapStore>> OpenMapStore(const StorageConfig& config);

// Makes URIs of another scheme openable ("postgresql"); ALREADY_EXISTS when somebody registered it.
// Thread-safe.
using MapStoreFactory = std::function<absl::StatusOr<std::unique_ptr<MapStore>>(const StorageConfig& config)>;
absl::Status RegisterMapStoreBackend(std::string_view scheme, MapStoreFactory factory);

}  // namespace semmap::storage
