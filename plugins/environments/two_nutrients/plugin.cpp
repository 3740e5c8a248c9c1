#include "somas/sdk/plugin.hpp"

#include "plugins/environments/two_nutrients/two_nutrients.hpp"

SOMAS_PLUGIN("somas.two_nutrients", "0.1.0", somas::environments::TwoNutrients)
