#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "slam/map/map_piece.h"
#include "slam/pipeline/mapper_queue.h"

namespace semmap {

// What a vehicle maps on its own until it finds itself in the map that it extends: a map with a mapper of its
// own, which nobody else sees and the store does not hear of. Used by one thread at a time.
class OwnPiece {
 public:
  OwnPiece(const SlamConfig& config, const MappingCamera& camera, const ScalePyramidInfo& scale_info,
           std::shared_ptr<const Vocabulary> vocabulary, Executor* executor)
      : queue_(std::make_shared<MapperQueue>(config, camera, scale_info, std::move(vocabulary), executor)),
        seat_(std::make_unique<MapperSeat>(queue_, nullptr)) {}

  MapperSeat& mapper() { return *seat_; }
  // Whether the mapper has nothing left to do.
  bool IsQuiet() const { return queue_->IsQuiet(); }
  // Waits until the mapper is quiet; the piece is gone then. Null when it is not worth joining.
  std::shared_ptr<const MapPiece> Take();

 private:
  std::shared_ptr<MapperQueue> queue_;
  std::unique_ptr<MapperSeat> seat_;
};

// Sees to it that the piece becomes part of the map once its vehicle has left it: as soon as the piece's
// mapper is quiet, again as the map grows around the place where the vehicle was found, and at the end of the
// drive. Used by one thread at a time.
class PieceHandover {
 public:
  // `map` must outlive it.
  PieceHandover(MapperSeat* map, std::shared_ptr<KeyFrameIdSource> ids) : map_(*map), ids_(std::move(ids)) {}

  void Begin(OwnPiece piece) { left_.emplace(std::move(piece)); }
  // With each frame that the vehicle drives in the map. Never waits.
  void OnFrame(bool is_keyframe);
  // Waits for the mapper; a piece that shows no place of the map is dropped.
  void Finish();

 private:
  void Take();
  void Try(bool trust_found);

  MapperSeat& map_;
  const std::shared_ptr<KeyFrameIdSource> ids_;
  std::optional<OwnPiece> left_;           // until its mapper is quiet
  std::shared_ptr<const MapPiece> piece_;  // then, until it is joined
  int tries_ = 0;
  int keyframes_ = 0;  // since it was tried last
  int patience_ = 0;   // how many there must be before it is tried again
};

}  // namespace semmap
