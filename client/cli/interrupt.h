#pragma once

namespace semmap::client {

// From now on the first SIGINT or SIGTERM only sets a flag, so that a drive can end its session; a second one
// ends the process as usual.
void CatchInterrupts();
bool Interrupted();

}  // namespace semmap::client
