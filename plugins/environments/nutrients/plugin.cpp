#include "somas/sdk/plugin.hpp"

#include "plugins/environments/nutrients/nutrients.hpp"

SOMAS_PLUGIN("somas.nutrients", "0.1.0", somas::environments::Nutrients)
