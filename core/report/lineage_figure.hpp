// Where a champion comes from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/report/figure.hpp"

namespace somas::report {

/// Above: the line of first parents of a generation's champion, with its fitness and the operator
/// that made each member; second parents beside it; the best of every generation. Below: how many
/// individuals of each generation are ancestors by either parent. Without `generation`: the last.
/// Throws run::UsageError for what cannot be read.
[[nodiscard]] std::string lineage_figure(const std::filesystem::path& run,
                                         std::optional<std::uint64_t> generation,
                                         std::uint32_t population, const FigureSize& size);

}  // namespace somas::report
