#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/map/map_delta.h"
#include "slam/map/map_piece.h"
#include "slam/pipeline/correction_log.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/session_mapper.h"
#include "slam/pipeline/tracker.h"

namespace semmap {

class MapperSeat;

// Stands between the mapper of a map and the trackers of the sessions that make it, most often one: trackers
// leave keyframes, frame poses and lost frames here (through a MapperSeat each) and read the newest view,
// without ever waiting for the mapper; the mapper works them off in order on the executor, or, without one,
// at once in the caller's thread. After a loop the whole map is adjusted as a long task beside the steps; a
// newer loop interrupts it and its result is dropped. Thread-safe.
class MapperQueue {
 public:
  // `executor` null: everything runs in the threads that bring it.
  MapperQueue(const SlamConfig& config, const MappingCamera& camera, const ScalePyramidInfo& scale_info,
              std::shared_ptr<const Vocabulary> vocabulary, Executor* executor);
  // Waits for the adjustment under way. All seats are gone.
  ~MapperQueue();

  // Before anybody takes a seat: goes on in a stored map. Who takes a seat where there is a map sees nothing
  // of it until a lost frame was found there.
  void Adopt(Map map);
  // No step waits or is under way, and no adjustment.
  bool IsQuiet() const;
  // What its only vehicle has mapped; the queue must be quiet, and is of no more use.
  MapPiece TakePiece(const MapperSeat& seat);

  struct Counts {
    int keyframes = 0;
    int points = 0;
    double map_ms = 0;
    int loops = 0;
    int recoveries = 0;
    int failed_recoveries = 0;
    // Pieces that the vehicle had mapped on its own and that became part of the map.
    int joined_pieces = 0;
    int refused_pieces = 0;  // so far; they may be tried again
    // Of the last recovery that was tried.
    LocalizationFailure last_failure = LocalizationFailure::kNone;
    // Of keyframes that came without classes and were to get them here.
    uint64_t classified_keyframes = 0;
    uint64_t unclassified_keyframes = 0;
  };

 private:
  friend class MapperSeat;

  // One session's part of it.
  struct Vehicle {
    Vehicle(MapDeltaSink* delta_sink, VehicleMapping vehicle_mapping)
        : sink(delta_sink), mapping(std::move(vehicle_mapping)) {}

    MapDeltaSink* const sink;  // null: nobody hears of the map, and frames stay here
    // Touched by the running step only, whosoever it is.
    VehicleMapping mapping;
    CorrectionLog corrections;
    uint64_t delta_version = 0;
    uint64_t view_version = 0;
    // Guarded by mutex_.
    size_t backlog = 0;  // own steps that wait or are under way
    bool recovering = false;
    std::shared_ptr<const Recovery> recovery;
    std::shared_ptr<const LocalMapView> view;
    std::deque<FramePose> frames;
    // Where the vehicle found itself first.
    std::optional<FramePose> found;
    // First frame of a piece that is not joined yet; 0: none.
    uint64_t waiting_from = 0;
    Counts counts;
  };
  using VehiclePtr = std::shared_ptr<Vehicle>;

  // The whole map being adjusted beside the steps, after a loop of `vehicle`.
  struct FullAdjustment {
    VehiclePtr vehicle;
    std::shared_ptr<FullBundle> bundle;
    std::atomic<bool> stop = false;
  };
  struct ResetStep {};
  struct RecoverStep {
    LostFrame lost;
  };
  struct ApplyStep {
    std::shared_ptr<FullAdjustment> adjustment;
  };
  struct JoinStep {
    PieceJoin join;
  };
  struct FinishStep {};
  using Work =
      std::variant<KeyFrameCandidate, InitialPair, ResetStep, RecoverStep, ApplyStep, JoinStep, FinishStep>;
  struct Step {
    VehiclePtr vehicle;
    Work work;
  };

  // What a seat does for its vehicle.
  VehiclePtr Join(MapDeltaSink* sink);
  void Leave(const VehiclePtr& vehicle);
  MapperState State(const Vehicle& vehicle) const;
  void Push(const VehiclePtr& vehicle, TrackOutput* output);
  void WaitForBacklog(const Vehicle& vehicle, size_t backlog);
  void NotePiece(const VehiclePtr& vehicle, uint64_t sequence);
  void Join(const VehiclePtr& vehicle, PieceJoin join);
  void Finish(const VehiclePtr& vehicle);
  Counts CountsOf(const Vehicle& vehicle) const;

  void Enqueue(const VehiclePtr& vehicle, Work work);
  void Drain();
  std::optional<Step> BeginStep();
  // False when no step waits.
  bool EndStep(Vehicle* vehicle, double ms);
  void CountMap();
  KeyFrameCandidate WithClasses(KeyFrameCandidate candidate);
  void Run(const KeyFrameCandidate& candidate);
  void Run(const InitialPair& pair);
  void Run(const ResetStep& reset);
  void Run(const RecoverStep& recover);
  void Run(const ApplyStep& apply);
  void Run(const JoinStep& step);
  void Run(const FinishStep& finish);
  // The piece's frames come before the vehicle's own.
  void TakeOver(const PieceJoinReport& joined);
  void CloseLoop();
  void StartFullAdjustment();
  // After more of the map moved than one vehicle's surroundings.
  void PublishAndDeliverToAll();
  void PublishToAll(const std::vector<VehiclePtr>& vehicles);
  void Deliver(uint64_t up_to_sequence);
  // The map's changes and the vehicle's frames; empty when there is nothing to tell.
  MapDelta TakeDelta(uint64_t up_to_sequence, const std::vector<VehiclePtr>& vehicles);
  std::vector<FramePose> TakeFrames(uint64_t up_to_sequence);
  std::vector<VehiclePtr> Vehicles() const;
  bool HasJoined(const VehiclePtr& vehicle) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  size_t Backlog() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return steps_.size() + (running_ ? 1 : 0); }

  const LoopConfig loop_config_;
  Executor* const executor_;
  const size_t capacity_;
  // Touched by the running step only: the mapper, and whose step it is.
  SessionMapper mapper_;
  VehiclePtr current_;
  // True while another keyframe waits: the running step should hurry.
  std::atomic<bool> hurry_ = false;

  mutable Mutex mutex_;  // guards what trackers, mapper and long tasks exchange
  // The map is nobody's alone: it was stored, or a second vehicle has joined.
  bool is_common_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<VehiclePtr> vehicles_ ABSL_GUARDED_BY(mutex_);
  std::deque<Step> steps_ ABSL_GUARDED_BY(mutex_);
  bool running_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t steps_begun_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t steps_ended_ ABSL_GUARDED_BY(mutex_) = 0;
  int map_keyframes_ ABSL_GUARDED_BY(mutex_) = 0;
  int map_points_ ABSL_GUARDED_BY(mutex_) = 0;
  // The newest full adjustment, and how many long tasks have not ended.
  std::shared_ptr<FullAdjustment> adjustment_ ABSL_GUARDED_BY(mutex_);
  int adjusting_ ABSL_GUARDED_BY(mutex_) = 0;
};

// One session's place at a mapper. Used by one thread at a time, but for State and counts, which any may
// call.
class MapperSeat {
 public:
  // `sink` receives a delta after each step of this session, and corrections from those of others; until the
  // seat is gone.
  MapperSeat(std::shared_ptr<MapperQueue> queue, MapDeltaSink* sink)
      : queue_(std::move(queue)), vehicle_(queue_->Join(sink)) {}
  // Waits for the step under way; own steps that wait are dropped.
  ~MapperSeat() { queue_->Leave(vehicle_); }
  MapperSeat(const MapperSeat&) = delete;
  MapperSeat& operator=(const MapperSeat&) = delete;

  MapperState State() const { return queue_->State(*vehicle_); }
  // Takes over what the tracker wants done for a frame.
  void Push(TrackOutput* output) { queue_->Push(vehicle_, output); }
  // Returns once at most `backlog` own steps are waiting or under way; for 0 also once the whole map is
  // adjusted.
  void WaitForBacklog(size_t backlog) { queue_->WaitForBacklog(*vehicle_, backlog); }
  // Frames from `sequence` on are in a piece of the vehicle's own; 0: not any more.
  void NotePiece(uint64_t sequence) { queue_->NotePiece(vehicle_, sequence); }
  // The piece should become part of the map; counts tell whether it did. `found` is set here.
  void Join(PieceJoin join) { queue_->Join(vehicle_, std::move(join)); }
  // Waits for all own steps and delivers the remaining frame poses.
  void Finish() { queue_->Finish(vehicle_); }
  MapperQueue::Counts counts() const { return queue_->CountsOf(*vehicle_); }

 private:
  friend class MapperQueue;

  const std::shared_ptr<MapperQueue> queue_;
  const MapperQueue::VehiclePtr vehicle_;
};

}  // namespace semmap
