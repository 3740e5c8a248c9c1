#include "somas/sdk/plugin.hpp"

#include "plugins/fitness/survival_time/survival_time.hpp"

SOMAS_PLUGIN("somas.survival_time", "0.1.0", somas::fitness::SurvivalTime)
