// Fitness over the generations, of one run or of several as replicates.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/report/figure.hpp"

namespace somas::report {

/// Of one run: best, median, and between the quartiles a band. Of several: the medians over the
/// replicates of their best, median and quartiles, with the range of the replicates' best and
/// median as bands; as far as all of them got. A directory that is no run stands for the runs in
/// it. Of a campaign with several conditions: a line and a band each, of their best. Throws
/// run::UsageError for what cannot be read, or fitness that counts different things.
[[nodiscard]] std::string evolution_figure(const std::vector<std::filesystem::path>& given,
                                           std::uint32_t population, const FigureSize& size,
                                           std::vector<std::string>& warnings);

}  // namespace somas::report
