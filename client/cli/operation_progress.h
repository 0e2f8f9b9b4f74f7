#pragma once

#include "client/cli/console.h"
#include "client/client.h"

namespace semmap::client {

// Shows how far an operation is, if the console is a terminal. `console` outlives the result.
Client::Progress ShowOn(const Console& console);

}  // namespace semmap::client
