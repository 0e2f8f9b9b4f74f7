#pragma once

#include <string>
#include <string_view>

namespace semmap {

// Where a file that ships with semmap lies (trained models and the like), `relative` being its place below
// config/, such as "models/vocabulary/street.vocabulary". The environment variable SEMMAP_DATA_DIR decides if
// it is set; otherwise the installed folder counts if it has the file, then the source tree. The path
// returned need not exist.
std::string DataFilePath(std::string_view relative);

}  // namespace semmap
