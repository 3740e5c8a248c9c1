#include "somas/sdk/plugin.hpp"

#include "plugins/environments/seasons/seasons.hpp"

SOMAS_PLUGIN("somas.seasons", "0.1.0", somas::environments::Seasons)
