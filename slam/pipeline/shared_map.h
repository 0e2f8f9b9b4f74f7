#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "slam/common/mutex.h"
#include "slam/pipeline/keyframe_id_source.h"
#include "slam/pipeline/mapper_queue.h"

namespace semmap {

// A map that any number of sessions make together: one copy in memory, one mapper, and what one vehicle adds
// the others see. All sessions have the cameras that made the map and the same configuration of the mapper;
// the first one's is used. Thread-safe.
class SharedMap {
 public:
  // A new map.
  SharedMap() : ids_(std::make_shared<KeyFrameIdSource>()) {}
  // One that was stored; new keyframes get ids greater than `last_keyframe`.
  SharedMap(Map map, KeyFrameId last_keyframe)
      : ids_(std::make_shared<KeyFrameIdSource>(last_keyframe)), map_(std::move(map)) {}

  const std::shared_ptr<KeyFrameIdSource>& ids() const { return ids_; }

  // The map's mapper, made for who asks first.
  std::shared_ptr<MapperQueue> Mapper(const SlamConfig& config, const MappingCamera& camera,
                                      const ScalePyramidInfo& scale_info,
                                      std::shared_ptr<const Vocabulary> vocabulary, Executor* executor);

 private:
  const std::shared_ptr<KeyFrameIdSource> ids_;
  Mutex mutex_;  // guards the making of the mapper
  // The stored map, until there is a mapper.
  std::optional<Map> map_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<MapperQueue> mapper_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap
