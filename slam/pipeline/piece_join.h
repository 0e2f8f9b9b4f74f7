#pragma once

#include <memory>
#include <optional>

#include "slam/map/map_piece.h"
#include "slam/pipeline/keyframe_id_source.h"
#include "slam/pipeline/map_overlap.h"

namespace semmap {

// A piece that a vehicle mapped on its own, to become part of the map that it extends.
struct PieceJoin {
  std::shared_ptr<const MapPiece> piece;
  // Of the map: where the piece's keyframes get ids from.
  std::shared_ptr<KeyFrameIdSource> ids;
  // A frame of the piece that was found in the map, hanging on a keyframe of the map.
  std::optional<FramePose> found;
  // Where depth is measured, that frame will do if no keyframe of the piece is found in the map.
  bool trust_found = false;
};

// What became of it.
struct PieceJoinReport {
  MapOverlap overlap;
  bool joined = false;
  int fused_points = 0;
  // The piece's frames, hanging on keyframes of the map and in its unit; and its keyframes, as the piece had
  // them.
  std::vector<FramePose> frames;
  struct Moved {
    KeyFrameId id;
    uint64_t sequence = 0;
    SE3 piece_from_camera;
    double scale = 1;  // units of the map that one unit of the piece became
  };
  std::vector<Moved> keyframes;
};

// Looks for the piece in the map and, if that is sure, makes it part of it (MapJoiner); otherwise the map
// stays as it was. Sure: several keyframes tell the same (MapOverlap::IsSound), or one and the frame that was
// found. The whole map should be adjusted afterwards.
PieceJoinReport JoinPiece(const SlamConfig& config, const MappingCamera& camera, const PieceJoin& join,
                          PlaceMemory* places, Map* map);

}  // namespace semmap
