#include "server/map_writer.h"

#include <utility>

namespace semmap::server {

MapWriter::MapWriter(size_t capacity) : capacity_(capacity), thread_([this] { Run(); }) {}

MapWriter::~MapWriter() {
  {
    MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

void MapWriter::Post(std::function<void()> job) {
  MutexLock lock(&mutex_);
  mutex_.Await(&MapWriter::HasRoom, this);
  jobs_.push_back(std::move(job));
}

size_t MapWriter::waiting() const {
  MutexLock lock(&mutex_);
  return jobs_.size();
}

void MapWriter::Run() {
  while (true) {
    std::function<void()> job;
    {
      MutexLock lock(&mutex_);
      mutex_.Await(&MapWriter::HasWork, this);
      if (jobs_.empty()) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    job();
  }
}

}  // namespace semmap::server
