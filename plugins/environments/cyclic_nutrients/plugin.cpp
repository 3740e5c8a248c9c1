#include "somas/sdk/plugin.hpp"

#include "plugins/environments/cyclic_nutrients/cyclic_nutrients.hpp"

SOMAS_PLUGIN("somas.cyclic_nutrients", "0.1.0", somas::environments::CyclicNutrients)
