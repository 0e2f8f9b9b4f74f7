#include "client/cli/operation_progress.h"

namespace semmap::client {

Client::Progress ShowOn(const Console& console) {
  return [&console](const v1::OperationMetadata& metadata) {
    if (console.err_is_terminal) {
      console.err << "\r" << static_cast<int>(100 * metadata.progress()) << " %  " << std::flush;
    }
    return true;
  };
}

}  // namespace semmap::client
