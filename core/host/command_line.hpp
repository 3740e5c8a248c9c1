// Words of the command line -> a command.
#pragma once

#include <string>
#include <vector>

#include "core/host/commands.hpp"

namespace somas::host {

/// `arguments` without the program's name. Prints help and version itself. Throws run::UsageError
/// for what is no command line.
[[nodiscard]] Command parse_command_line(const std::vector<std::string>& arguments);

}  // namespace somas::host
