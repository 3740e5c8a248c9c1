// The plugins of experiment 1, compiled into this program from the same sources.
#pragma once

#include <memory>

#include "core/plugins/library.hpp"

namespace somas::bench {

/// For experiment::LoadOptions::linked_in; made at the first call.
[[nodiscard]] const std::shared_ptr<const plugins::Library>& compiled_in();

}  // namespace somas::bench
