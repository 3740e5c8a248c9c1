// Sanity of the table that a library hands out: a wrong one is refused, not trusted.
#pragma once

#include "somas/sdk/abi.hpp"

namespace somas::plugins {

/// Throws BadPlugin unless every field of the table, of its classes and of their parameters is
/// usable: revision, fingerprint, sizes, names, kinds, and defaults within their own ranges.
void check_table(const PluginInfo* table);

}  // namespace somas::plugins
