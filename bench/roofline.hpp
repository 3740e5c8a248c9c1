// The step against what the machine could do: bytes and operations of each phase, how long they
// take at least, and how long they do.
#pragma once

#include <span>

namespace somas::bench {

/// Prints the roofline, Markdown or JSON. Arguments after --roofline:
///   --json       as JSON
///   --update     writes it into docs/roofline.md instead
///   --quick      a smaller world and hasty measurements: for tests
/// Returns an exit code.
int roofline(std::span<char* const> arguments);

}  // namespace somas::bench
