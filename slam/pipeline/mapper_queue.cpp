#include "slam/pipeline/mapper_queue.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <unordered_map>

#include <spdlog/spdlog.h>

#include "slam/pipeline/stopwatch.h"

namespace semmap {
namespace {

// Frames that wait for their keyframe keep their distance to it in its new unit.
void Rescale(const std::vector<KeyFramePose>& moved, std::deque<FramePose>* frames) {
  std::unordered_map<KeyFrameId, double, IdHash> factors;
  for (const KeyFramePose& keyframe : moved) {
    if (keyframe.rescale != 1) factors.emplace(keyframe.id, keyframe.rescale);
  }
  if (factors.empty()) return;
  for (FramePose& frame : *frames) {
    const auto factor = factors.find(frame.reference_keyframe);
    if (factor == factors.end()) continue;
    const SE3& pose = frame.keyframe_from_camera;
    frame.keyframe_from_camera = SE3(pose.rotation(), factor->second * pose.translation());
  }
}

}  // namespace

MapperQueue::MapperQueue(const SlamConfig& config, const MappingCamera& camera,
                         const ScalePyramidInfo& scale_info, std::shared_ptr<const Vocabulary> vocabulary,
                         Executor* executor)
    : loop_config_(config.loop),
      executor_(executor),
      capacity_(static_cast<size_t>(config.mapping.queue)),
      mapper_(config, camera, scale_info, std::move(vocabulary),
              [this](std::shared_ptr<const LocalMapView> view) {
                current_->view_version = view != nullptr ? view->version : 0;
                MutexLock lock(&mutex_);
                current_->view = std::move(view);
              }) {}

MapperQueue::~MapperQueue() {
  MutexLock lock(&mutex_);
  if (adjustment_) adjustment_->stop = true;
  const auto stopped = [this]()
                           ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return !running_ && adjusting_ == 0; };
  mutex_.Await(stopped);
}

void MapperQueue::Adopt(Map map) {
  mapper_.Adopt(std::move(map));
  CountMap();
  MutexLock lock(&mutex_);
  is_common_ = true;
}

void MapperQueue::CountMap() {
  MutexLock lock(&mutex_);
  map_keyframes_ = static_cast<int>(mapper_.map().keyframes().size());
  map_points_ = static_cast<int>(mapper_.map().points().size());
}

bool MapperQueue::IsQuiet() const {
  MutexLock lock(&mutex_);
  return !running_ && adjusting_ == 0;
}

MapPiece MapperQueue::TakePiece(const MapperSeat& seat) {
  MutexLock lock(&mutex_);
  std::deque<FramePose>& frames = seat.vehicle_->frames;
  return {mapper_.TakeMap(), std::vector<FramePose>(frames.begin(), frames.end())};
}

// --- The vehicles

MapperQueue::VehiclePtr MapperQueue::Join(MapDeltaSink* sink) {
  MutexLock lock(&mutex_);
  is_common_ = is_common_ || !vehicles_.empty() || map_keyframes_ > 0;
  auto vehicle = std::make_shared<Vehicle>(sink, mapper_.StartVehicle(is_common_));
  vehicles_.push_back(vehicle);
  return vehicle;
}

void MapperQueue::Leave(const VehiclePtr& vehicle) {
  MutexLock lock(&mutex_);
  std::erase(vehicles_, vehicle);
  std::erase_if(steps_, [&](const Step& step) { return step.vehicle == vehicle; });
  if (vehicles_.empty()) hurry_ = true;
  if (adjustment_ && adjustment_->vehicle == vehicle) adjustment_->stop = true;
  // Whosoever's step is under way may still speak to this sink.
  const auto quiet = [this, begun = steps_begun_]()
                         ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return steps_ended_ >= begun; };
  mutex_.Await(quiet);
}

bool MapperQueue::HasJoined(const VehiclePtr& vehicle) const {
  return std::find(vehicles_.begin(), vehicles_.end(), vehicle) != vehicles_.end();
}

std::vector<MapperQueue::VehiclePtr> MapperQueue::Vehicles() const {
  MutexLock lock(&mutex_);
  return vehicles_;
}

MapperState MapperQueue::State(const Vehicle& vehicle) const {
  MutexLock lock(&mutex_);
  return {vehicle.view,       is_common_,      Backlog() == 0, steps_.size() < capacity_,
          vehicle.recovering, vehicle.recovery};
}

MapperQueue::Counts MapperQueue::CountsOf(const Vehicle& vehicle) const {
  MutexLock lock(&mutex_);
  Counts counts = vehicle.counts;
  counts.keyframes = map_keyframes_;
  counts.points = map_points_;
  return counts;
}

void MapperQueue::Push(const VehiclePtr& vehicle, TrackOutput* output) {
  {
    MutexLock lock(&mutex_);
    if (output->initial_pair) {
      // The first frame of the pair was not answered, but the map knows its pose now.
      const KeyFrameCandidate& first = output->initial_pair->first;
      vehicle->frames.push_back({first.sequence, first.timestamp, first.id, SE3()});
    }
    if (output->frame_pose) vehicle->frames.push_back(*output->frame_pose);
    if (output->lost_frame) vehicle->recovering = true;
  }
  if (output->reset_map) Enqueue(vehicle, ResetStep());
  if (output->initial_pair) Enqueue(vehicle, std::move(*output->initial_pair));
  if (output->keyframe) Enqueue(vehicle, std::move(*output->keyframe));
  if (output->lost_frame) Enqueue(vehicle, RecoverStep{std::move(*output->lost_frame)});
}

void MapperQueue::WaitForBacklog(const Vehicle& vehicle, size_t backlog) {
  MutexLock lock(&mutex_);
  const auto done = [this, &vehicle, backlog]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return vehicle.backlog <= backlog && (backlog > 0 || adjusting_ == 0);
  };
  mutex_.Await(done);
}

void MapperQueue::NotePiece(const VehiclePtr& vehicle, uint64_t sequence) {
  MutexLock lock(&mutex_);
  vehicle->waiting_from = sequence;
}

void MapperQueue::Join(const VehiclePtr& vehicle, PieceJoin join) {
  {
    MutexLock lock(&mutex_);
    join.found = vehicle->found;
  }
  Enqueue(vehicle, JoinStep{std::move(join)});
}

void MapperQueue::Finish(const VehiclePtr& vehicle) {
  WaitForBacklog(*vehicle, 0);
  Enqueue(vehicle, FinishStep());
  WaitForBacklog(*vehicle, 0);
}

// --- Steps

void MapperQueue::Enqueue(const VehiclePtr& vehicle, Work work) {
  {
    MutexLock lock(&mutex_);
    if (!HasJoined(vehicle)) return;
    steps_.push_back({vehicle, std::move(work)});
    ++vehicle->backlog;
    hurry_ = true;
    if (!running_) {
      running_ = true;
      if (executor_ != nullptr) executor_->Schedule([this] { Drain(); });
    } else if (executor_ == nullptr) {
      // Another vehicle's thread works; it will come to this step as well.
      const auto done = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return vehicle->backlog == 0; };
      mutex_.Await(done);
      return;
    }
  }
  if (executor_ == nullptr) Drain();
}

void MapperQueue::Drain() {
  while (const auto step = BeginStep()) {
    Stopwatch stopwatch;
    current_ = step->vehicle;
    std::visit([this](const auto& work) { Run(work); }, step->work);
    current_.reset();
    CountMap();
    if (!EndStep(step->vehicle.get(), stopwatch.LapMs())) return;
  }
}

std::optional<MapperQueue::Step> MapperQueue::BeginStep() {
  MutexLock lock(&mutex_);
  running_ = !steps_.empty();
  if (!running_) return std::nullopt;
  Step step = std::move(steps_.front());
  steps_.pop_front();
  hurry_ = !steps_.empty();
  ++steps_begun_;
  return step;
}

// Who waits for the step finds the mapper idle if nothing else waits.
bool MapperQueue::EndStep(Vehicle* vehicle, double ms) {
  MutexLock lock(&mutex_);
  vehicle->counts.map_ms += ms;
  --vehicle->backlog;
  ++steps_ended_;
  running_ = !steps_.empty();
  return running_;
}

// The tracker still reads the features, and the map must never see them without their classes.
KeyFrameCandidate MapperQueue::WithClasses(KeyFrameCandidate candidate) {
  auto features = std::make_shared<FrameFeatures>(*candidate.features);
  const bool filled = candidate.pending_classes->Fill(features.get());
  if (filled) candidate.features = std::move(features);
  candidate.pending_classes.reset();
  MutexLock lock(&mutex_);
  Counts& counts = current_->counts;
  ++(filled ? counts.classified_keyframes : counts.unclassified_keyframes);
  return candidate;
}

void MapperQueue::Run(const KeyFrameCandidate& candidate) {
  if (candidate.pending_classes != nullptr) {
    mapper_.AddKeyFrame(WithClasses(candidate), &hurry_, &current_->mapping);
  } else {
    mapper_.AddKeyFrame(candidate, &hurry_, &current_->mapping);
  }
  Deliver(candidate.sequence);
  CloseLoop();
}

void MapperQueue::Run(const InitialPair& pair) {
  mapper_.AddInitialPair(pair, &current_->mapping);
  Deliver(pair.second.sequence);
}

void MapperQueue::Run(const ResetStep& /*reset*/) {
  {
    MutexLock lock(&mutex_);
    // Somebody joined meanwhile. The tracker goes on as one that is lost.
    if (is_common_) return;
    current_->frames.clear();
  }
  mapper_.Reset(&current_->mapping);
  Deliver(0);
}

void MapperQueue::Run(const RecoverStep& recover) {
  const TrackedFrame& frame = recover.lost.frame;
  SessionMapper::RecoveryReport report = mapper_.Recover(recover.lost, &current_->mapping);
  MutexLock lock(&mutex_);
  Vehicle& vehicle = *current_;
  vehicle.recovering = false;
  vehicle.counts.last_failure = report.failure;
  if (report.recovery == nullptr) {
    ++vehicle.counts.failed_recoveries;
    return;
  }
  ++vehicle.counts.recoveries;
  vehicle.recovery = std::move(report.recovery);
  const KeyFrame& reference = *mapper_.map().FindKeyFrame(vehicle.recovery->reference);
  const FramePose found{frame.sequence, frame.timestamp, reference.id,
                        reference.camera_from_map * vehicle.recovery->frame.camera_from_map.Inverse()};
  if (!vehicle.found) vehicle.found = found;
  // The vehicle was told that this frame is lost, but the trajectory need not have the gap.
  if (vehicle.frames.empty() || vehicle.frames.back().sequence < frame.sequence)
    vehicle.frames.push_back(found);
}

void MapperQueue::Run(const JoinStep& step) {
  PieceJoin join = step.join;
  if (join.found && !mapper_.map().Resolve(&*join.found)) join.found.reset();
  const PieceJoinReport report = mapper_.Join(join);
  const MapOverlap& overlap = report.overlap;
  spdlog::info("own piece {}: {} keyframes, {} found in the map, {} of one mind, {} points fused",
               report.joined ? "joined" : "not joined", overlap.keyframes, overlap.found,
               overlap.links.size(), report.fused_points);
  if (!report.joined) {
    MutexLock lock(&mutex_);
    ++current_->counts.refused_pieces;
    return;
  }
  TakeOver(report);
  PublishAndDeliverToAll();
  if (loop_config_.full_adjustment) StartFullAdjustment();
}

void MapperQueue::TakeOver(const PieceJoinReport& joined) {
  for (const PieceJoinReport::Moved& keyframe : joined.keyframes) {
    current_->corrections.NoteReportedElsewhere(keyframe.id, keyframe.sequence, keyframe.piece_from_camera,
                                                keyframe.scale);
  }
  MutexLock lock(&mutex_);
  ++current_->counts.joined_pieces;
  current_->waiting_from = 0;
  std::deque<FramePose>& frames = current_->frames;
  // The frame that was found is known to the map already.
  std::copy_if(joined.frames.begin(), joined.frames.end(), std::front_inserter(frames),
               [this](const FramePose& frame) {
                 return !current_->found || frame.sequence != current_->found->sequence;
               });
  std::stable_sort(frames.begin(), frames.end(),
                   [](const FramePose& a, const FramePose& b) { return a.sequence < b.sequence; });
}

void MapperQueue::Run(const FinishStep& /*finish*/) { Deliver(std::numeric_limits<uint64_t>::max()); }

// A delta of its own: what was removed before was removed in the old units.
void MapperQueue::CloseLoop() {
  const auto closed = mapper_.CloseLoop(&current_->mapping);
  if (!closed) return;
  spdlog::info(
      "loop closed: keyframe {} is at {}, {} and {} inliers, moved {:.2f}, scale {:.4f}, {} points fused",
      closed->loop.current.value(), closed->loop.old.value(), closed->loop.inliers,
      closed->loop.reverse_inliers, closed->correction.shift, closed->correction.scale,
      closed->correction.fused_points);
  PublishAndDeliverToAll();
  {
    MutexLock lock(&mutex_);
    ++current_->counts.loops;
  }
  if (loop_config_.full_adjustment) StartFullAdjustment();
}

void MapperQueue::StartFullAdjustment() {
  auto adjustment = std::make_shared<FullAdjustment>();
  adjustment->vehicle = current_;
  adjustment->bundle = mapper_.PrepareFullBundle();
  if (executor_ == nullptr) {
    adjustment->bundle->Solve(nullptr);
    Run(ApplyStep{std::move(adjustment)});
    return;
  }
  MutexLock lock(&mutex_);
  if (adjustment_) adjustment_->stop = true;
  adjustment_ = adjustment;
  ++adjusting_;
  executor_->ScheduleLong([this, adjustment] {
    adjustment->bundle->Solve(&adjustment->stop);
    if (!adjustment->stop) Enqueue(adjustment->vehicle, ApplyStep{adjustment});
    MutexLock finished(&mutex_);
    --adjusting_;
  });
}

void MapperQueue::Run(const ApplyStep& apply) {
  // A newer loop may have come after it was solved.
  if (apply.adjustment->stop) return;
  mapper_.Apply(*apply.adjustment->bundle);
  PublishAndDeliverToAll();
  MutexLock lock(&mutex_);
  if (adjustment_ == apply.adjustment) adjustment_.reset();
}

// --- What the vehicles and the store hear

void MapperQueue::PublishToAll(const std::vector<VehiclePtr>& vehicles) {
  const VehiclePtr whose_step = current_;
  for (const VehiclePtr& vehicle : vehicles) {
    current_ = vehicle;
    if (vehicle->mapping.center.IsValid()) mapper_.PublishView(vehicle->mapping);
  }
  current_ = whose_step;
}

void MapperQueue::PublishAndDeliverToAll() {
  const std::vector<VehiclePtr> vehicles = Vehicles();
  PublishToAll(vehicles);
  MapDelta delta = TakeDelta(0, vehicles);
  if (delta.empty() || current_->sink == nullptr) return;
  for (const VehiclePtr& vehicle : vehicles) {
    if (vehicle == current_) continue;
    MapDelta news;
    news.corrections = vehicle->corrections.Corrections();
    news.corrected_map_version = vehicle->view_version;
    if (!news.corrections.empty()) vehicle->sink->OnDelta(std::move(news));
  }
  delta.corrections = current_->corrections.Corrections();
  delta.corrected_map_version = current_->view_version;
  current_->sink->OnDelta(std::move(delta));
}

void MapperQueue::Deliver(uint64_t up_to_sequence) {
  const bool is_heard = current_->sink != nullptr;
  MapDelta delta = TakeDelta(is_heard ? up_to_sequence : 0, Vehicles());
  if (is_heard && !delta.empty()) current_->sink->OnDelta(std::move(delta));
}

MapDelta MapperQueue::TakeDelta(uint64_t up_to_sequence, const std::vector<VehiclePtr>& vehicles) {
  MapDelta delta = mapper_.TakeDelta();
  {
    MutexLock lock(&mutex_);
    for (const VehiclePtr& vehicle : vehicles) Rescale(delta.moved_keyframes, &vehicle->frames);
    delta.waiting_from = current_->waiting_from;
  }
  delta.frames = TakeFrames(up_to_sequence);
  if (delta.empty()) return delta;
  for (const VehiclePtr& vehicle : vehicles) vehicle->corrections.Note(delta, vehicle == current_);
  delta.version = ++current_->delta_version;
  return delta;
}

std::vector<FramePose> MapperQueue::TakeFrames(uint64_t up_to_sequence) {
  std::vector<FramePose> taken;
  MutexLock lock(&mutex_);
  std::deque<FramePose>& frames = current_->frames;
  while (!frames.empty() && frames.front().sequence <= up_to_sequence) {
    if (mapper_.map().Resolve(&frames.front())) taken.push_back(frames.front());
    frames.pop_front();
  }
  return taken;
}

}  // namespace semmap
