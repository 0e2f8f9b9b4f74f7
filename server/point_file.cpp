#include "server/point_file.h"

#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/map_conversion.h"
#include "slam/common/status_macros.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::server {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary formats are little endian");

using Rgb = std::array<uint8_t, 3>;

// A record of a binary format.
class Row {
 public:
  template <typename T>
  Row& Put(T value) {
    std::memcpy(bytes_.data() + size_, &value, sizeof value);
    size_ += sizeof value;
    return *this;
  }
  Row& PutPosition(const Eigen::Vector3d& position) {
    for (int axis = 0; axis < 3; ++axis) Put(static_cast<float>(position[axis]));
    return *this;
  }
  std::string_view bytes() const { return {bytes_.data(), size_}; }

 private:
  std::array<char, 64> bytes_;
  size_t size_ = 0;
};

// Both binary formats name the number of points in a text at the beginning. It is known at the end; a comment
// in the text is as much shorter as the number is longer, so that the text keeps its length.
class BinaryPointFile : public PointFile {
 public:
  explicit BinaryPointFile(OutputFile* output) : output_(output) {}

  absl::Status Add(const MapPointRecord& point) override {
    if (count_ == 0) SEMMAP_RETURN_IF_ERROR(output_->Append(PaddedHeading()));
    ++count_;
    return output_->Append(RowOf(point).bytes());
  }

  absl::Status Finish() override {
    if (count_ == 0) return output_->Append(PaddedHeading());
    return output_->ReplaceBeginning(PaddedHeading());
  }

 private:
  static constexpr size_t kPadding = 64;

  std::string PaddedHeading() const {
    const size_t longer = Heading(count_, "").size() - Heading(0, "").size();
    return Heading(count_, std::string(kPadding - longer, '-'));
  }

  virtual std::string Heading(uint64_t count, const std::string& comment) const = 0;
  virtual Row RowOf(const MapPointRecord& point) const = 0;

  OutputFile* const output_;
  uint64_t count_ = 0;
};

class PlyFile : public BinaryPointFile {
 public:
  using BinaryPointFile::BinaryPointFile;

 private:
  std::string Heading(uint64_t count, const std::string& comment) const override {
    return absl::StrCat(
        "ply\nformat binary_little_endian 1.0\ncomment ", comment,
        "\ncomment semmap: metres, class ids and colours of CARLA, 255: no class\nelement vertex ", count,
        "\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar class\n"
        "property float confidence\nproperty uint observations\nend_header\n");
  }
  Row RowOf(const MapPointRecord& point) const override {
    Row row;
    row.PutPosition(point.position_in_map);
    for (const uint8_t channel : ColourOf(point.semantic_class)) row.Put(channel);
    return row.Put(point.semantic_class).Put(point.class_confidence).Put(point.observation_count);
  }
};

class PcdFile : public BinaryPointFile {
 public:
  using BinaryPointFile::BinaryPointFile;

 private:
  std::string Heading(uint64_t count, const std::string& comment) const override {
    return absl::StrCat(
        "# .PCD v0.7 - Point Cloud Data file format\n# semmap: metres, class ids and colours of CARLA, 255: "
        "no class\n# ",
        comment,
        "\nVERSION 0.7\nFIELDS x y z rgb label confidence observations\nSIZE 4 4 4 4 4 4 4\n"
        "TYPE F F F F U F U\nCOUNT 1 1 1 1 1 1 1\nWIDTH ",
        count, "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", count, "\nDATA binary\n");
  }
  Row RowOf(const MapPointRecord& point) const override {
    const Rgb rgb = ColourOf(point.semantic_class);
    Row row;
    row.PutPosition(point.position_in_map);
    return row.Put(uint32_t{rgb[0]} << 16 | uint32_t{rgb[1]} << 8 | rgb[2])
        .Put(uint32_t{point.semantic_class})
        .Put(point.class_confidence)
        .Put(point.observation_count);
  }
};

class CsvFile : public PointFile {
 public:
  explicit CsvFile(OutputFile* output) : output_(output) {}

  absl::Status Add(const MapPointRecord& point) override {
    SEMMAP_RETURN_IF_ERROR(PutHeading());
    const Eigen::Vector3d& p = point.position_in_map;
    const Rgb rgb = ColourOf(point.semantic_class);
    return output_->Append(
        absl::StrFormat("%d,%.9g,%.9g,%.9g,%d,%s,%d,%d,%d,%.4g,%d,%d,%d\n", point.id.value(), p.x(), p.y(),
                        p.z(), point.semantic_class, ClassName(point.semantic_class), rgb[0], rgb[1], rgb[2],
                        point.class_confidence, point.observation_count, point.first_seen, point.last_seen));
  }
  absl::Status Finish() override { return PutHeading(); }

 private:
  absl::Status PutHeading() {
    if (output_->size() > 0) return absl::OkStatus();
    return output_->Append(
        "id,x,y,z,class,class_name,red,green,blue,confidence,observations,first_seen_ns,last_seen_ns\n");
  }

  OutputFile* const output_;
};

}  // namespace

Rgb ColourOf(uint8_t semantic_class) {
  return semantic_class < kSemanticClassCount ? kSemanticClasses[semantic_class].rgb : Rgb{255, 255, 255};
}

std::unique_ptr<PointFile> MakePointFile(v1::MapFileFormat format, OutputFile* output) {
  switch (format) {
    case v1::MAP_FILE_FORMAT_PLY:
      return std::make_unique<PlyFile>(output);
    case v1::MAP_FILE_FORMAT_PCD:
      return std::make_unique<PcdFile>(output);
    case v1::MAP_FILE_FORMAT_CSV:
      return std::make_unique<CsvFile>(output);
    default:
      return nullptr;
  }
}

}  // namespace semmap::server
