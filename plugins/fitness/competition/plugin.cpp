#include "somas/sdk/plugin.hpp"

#include "plugins/fitness/competition/competition.hpp"

SOMAS_PLUGIN("somas.competition", "0.1.0", somas::fitness::Competition)
