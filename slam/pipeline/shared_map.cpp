#include "slam/pipeline/shared_map.h"

namespace semmap {

std::shared_ptr<MapperQueue> SharedMap::Mapper(const SlamConfig& config, const MappingCamera& camera,
                                               const ScalePyramidInfo& scale_info,
                                               std::shared_ptr<const Vocabulary> vocabulary,
                                               Executor* executor) {
  MutexLock lock(&mutex_);
  if (mapper_ == nullptr) {
    mapper_ = std::make_shared<MapperQueue>(config, camera, scale_info, std::move(vocabulary), executor);
    if (map_) mapper_->Adopt(*std::move(map_));
    map_.reset();
  }
  return mapper_;
}

}  // namespace semmap
