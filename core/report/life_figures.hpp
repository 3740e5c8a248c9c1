// Charts of one life.
#pragma once

#include <string>

#include "core/report/figure.hpp"
#include "core/report/life_history.hpp"

namespace somas::report {

/// Cells by state over time; grey behind them: what resources there were, where that ever fell
/// below nine tenths of the most.
[[nodiscard]] std::string population_figure(const LifeHistory& history, const Subject& subject,
                                            const FigureSize& size);

/// Below each other, with the boundaries of phases_of: cells stacked by state, with the first cell
/// of each state and the first row of each table marked; deaths by cause; divisions and
/// specializations; resources and tables, each relative to its most.
[[nodiscard]] std::string phases_figure(const LifeHistory& history, const Subject& subject,
                                        const FigureSize& size);

}  // namespace somas::report
