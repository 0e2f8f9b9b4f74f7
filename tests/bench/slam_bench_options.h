#pragma once

#include <memory>
#include <string>

#include "client/sources/open_source.h"
#include "slam/pipeline/slam_config.h"
#include "slam/semantics/segmentation_queue.h"

namespace semmap::bench {

// What one benchmark run does.
struct BenchOptions {
  std::string source;  // KIND:PATH, see OpenSource
  client::SourceOptions source_options;
  SlamConfig config;
  // Frames come at their recorded pace instead of one after the other.
  bool realtime = false;
  // Without `realtime`: keyframes that may wait for the mapper when the next frame is tracked.
  int backlog = 0;
  // Loops are looked for and closed.
  bool close_loops = true;
  // Segments frames as config.segmentation says; null: nobody does.
  std::shared_ptr<SegmentationQueue> segmentation;
  // At most so many frames; 0: all.
  int max_frames = 0;
};

}  // namespace semmap::bench
